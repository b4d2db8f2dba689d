// vantage-watch: what the servo does, live on a terminal.

#include <iostream>
#include <thread>

#include <unistd.h>

#include "app.h"
#include "vantage/math/error.h"
#include "vantage/messaging/transport.h"
#include "vantage/runtime/signal_stop.h"
#include "watch_screen.h"

namespace vantage {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(100);

struct Arguments {
  std::string prefix;
  bool once = false;
  double wait = 2.0;
};

// One view as plain text.
void Print(const std::vector<TextLine>& lines) {
  for (const TextLine& line : lines) {
    std::string text;
    for (const TextSpan& span : line) text += span.text;
    text.erase(text.find_last_not_of(' ') + 1);
    std::cout << text << '\n';
  }
}

int Watch(const Arguments& arguments) {
  const SignalStop stop;
  const Transport transport = JoinTransport();
  WatchCollector collector(arguments.prefix);
  LcmLink link({transport.url, ""});
  link.SubscribeAll([&](std::string_view channel, const void* data, std::size_t size) {
    collector.OnMessage(channel, data, size, Clock::now());
  });
  link.Start();

  WatchHeader header;
  header.url = transport.url;
  if (arguments.once) {
    const Time end = Clock::now() + FromSeconds(arguments.wait);
    while (Clock::now() < end && !stop.stopped()) {
      std::this_thread::sleep_for(kTick);
      collector.Tick(Clock::now());
    }
    header.connected = link.stats().connected;
    const WatchState state = collector.Get();
    Print(RenderWatch(state, header, Clock::now(), 120, 1000));
    return state.status ? kExitOk : kExitNotReached;
  }

  if (isatty(STDOUT_FILENO) == 0) throw Error("the output is no terminal; --once prints one view");
  WatchScreen screen;
  WatchState state = collector.Get();
  Time shown = Clock::now();
  while (!stop.stopped()) {
    const int key = screen.Key(kTick);
    if (key == 'q' || key == 'Q') break;
    if (key == 'p' || key == 'P' || key == ' ') header.paused = !header.paused;
    collector.Tick(Clock::now());
    header.connected = link.stats().connected;
    if (!header.paused) {
      state = collector.Get();
      shown = Clock::now();
    }
    screen.Draw(RenderWatch(state, header, shown, screen.columns(), screen.rows()));
  }
  return kExitOk;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app("Live view of a servo on a terminal: state, measures, joints, loop, channels",
               "vantage-watch");
  app.add_option("--prefix", arguments.prefix, "Of the servo's channels; others are listed too");
  app.add_flag("--once", arguments.once,
               "Prints one view as plain text and ends; exit code 1 when no servo was heard");
  app.add_option("--wait", arguments.wait, "With --once: listens for this long [s]")
      ->check(CLI::Range(0.1, 60.0))
      ->capture_default_str();
  return vantage::RunApp(&app, argc, argv, "no servo heard (--once)",
                         [&] { return vantage::Watch(arguments); });
}
