#include "servo_replay.h"

#include <cstdio>
#include <iostream>

#include "app.h"

namespace vantage {
namespace {

void Print(const ReplayReport& report, const ReplayOptions& options) {
  std::printf("%s (%s, camera %s): %lld periods in %.2f s, %lld steps of the active camera\n",
              report.scenario_name.c_str(), report.program.c_str(),
              report.active_camera ? "active" : "fixed", static_cast<long long>(report.periods),
              report.duration, static_cast<long long>(report.camera_steps));
  std::printf("  %-20s %9s %9s %9s  %s\n", "channel", "compared", "different", "unmatched",
              "worst |logged - replayed| / max(1, |logged|)");
  for (const ChannelComparison& channel : report.channels) {
    std::printf("  %-20s %9lld %9lld %9lld  %.3g\n", channel.channel.c_str(),
                static_cast<long long>(channel.compared), static_cast<long long>(channel.different),
                static_cast<long long>(channel.unmatched), channel.worst);
  }
  if (const auto& first = report.first_difference) {
    std::printf("  first difference at t = %.6f s: %s.%s was %s, is %s\n", first->t,
                first->channel.c_str(), first->field.c_str(), first->logged.c_str(),
                first->replayed.c_str());
  }
  if (!report.cut_short.empty()) std::printf("  cut short: %s\n", report.cut_short.c_str());
  std::printf("  %s to %g\n", report.reproduced() ? "reproduced" : "NOT reproduced",
              options.tolerance);
}

}  // namespace

int PrintReplay(const std::string& log_path, const ReplayOptions& options) {
  bool reproduced = true;
  for (const ReplayReport& report : Replay(log_path, options)) {
    Print(report, options);
    reproduced = reproduced && report.reproduced();
  }
  return reproduced ? kExitOk : kExitNotReached;
}

}  // namespace vantage
