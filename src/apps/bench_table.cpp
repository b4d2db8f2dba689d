#include "bench_table.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <nlohmann/json.hpp>

#include "sim/suite/quantile.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

using sim::Quantile;

std::size_t Successes(const BenchRow& row) {
  return static_cast<std::size_t>(
      std::count_if(row.results.begin(), row.results.end(),
                    [](const sim::TaskResult& result) { return result.success; }));
}

template <typename Get>
std::vector<double> Values(const BenchRow& row, bool successes_only, Get get) {
  std::vector<double> values;
  for (const sim::TaskResult& result : row.results) {
    if (result.success || !successes_only) values.push_back(static_cast<double>(get(result)));
  }
  return values;
}

double Sum(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum;
}

}  // namespace

std::pair<double, double> WilsonInterval(std::size_t successes, std::size_t runs) {
  if (runs == 0) return {0.0, 1.0};
  constexpr double kZ = 1.959963984540054;
  const auto n = static_cast<double>(runs);
  const double p = static_cast<double>(successes) / n;
  const double z2 = kZ * kZ;
  const double middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = kZ / (1.0 + z2 / n) * std::sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

std::string BenchTable(const std::vector<BenchRow>& rows) {
  std::string table;
  table += Format("%-17s %-12s %7s %15s %6s %6s %7s %7s %7s %6s %7s %6s %6s %5s\n", "scenario",
                  "strategy", "success", "95 % interval", "t [s]", "95 %", "err[mm]", "95 %",
                  "[deg]", "lost", "way [m]", "moves", "low %", "viol.");
  std::string last_scenario;
  for (const BenchRow& row : rows) {
    const auto runs = static_cast<double>(row.results.size());
    const std::size_t successes = Successes(row);
    const auto interval = WilsonInterval(successes, row.results.size());
    const auto time = Values(row, true, [](const auto& r) { return r.duration; });
    const auto error = Values(row, false, [](const auto& r) { return r.true_error_mm; });
    const auto joints = Values(row, false, [](const auto& r) { return r.joint_error_deg; });
    const auto lost = Values(row, false, [](const auto& r) { return r.lost_events; });
    const auto way = Values(row, false, [](const auto& r) { return r.travel_m; });
    const auto moves = Values(row, false, [](const auto& r) { return r.moves; });
    const auto low = Values(row, false, [](const auto& r) { return r.low_share; });
    const auto violations = Values(row, false, [](const auto& r) { return r.limit_violations; });
    const double share = 100.0 * static_cast<double>(successes) / std::max(1.0, runs);
    table += Format(
        "%-17s %-12s %6.1f%% [%5.1f, %5.1f]%% %6.1f %6.1f %7.2f %7.1f %7.2f %6.1f %7.2f "
        "%6.1f %6.1f %5.0f\n",
        row.scenario == last_scenario ? "" : row.scenario.c_str(), row.strategy.c_str(), share,
        100.0 * interval.first, 100.0 * interval.second, Quantile(time, 0.5), Quantile(time, 0.95),
        Quantile(error, 0.5), Quantile(error, 0.95), Quantile(joints, 0.5), Sum(lost) / runs,
        Quantile(way, 0.5), Sum(moves) / runs, 100.0 * Sum(low) / runs, Sum(violations));
    last_scenario = row.scenario;
  }
  return table;
}

void WriteBenchJson(const std::vector<BenchRow>& rows, const std::string& suite, bool kinematic,
                    const std::string& path) {
  using Json = nlohmann::ordered_json;
  Json root;
  root["suite"] = suite;
  root["model"] = kinematic ? "kinematic" : "pixels";
  root["success_mm"] = sim::kSuccessMillimetres;
  root["rows"] = Json::array();
  for (const BenchRow& row : rows) {
    const auto runs = static_cast<double>(row.results.size());
    const std::size_t successes = Successes(row);
    const auto interval = WilsonInterval(successes, row.results.size());
    Json entry;
    entry["scenario"] = row.scenario;
    entry["strategy"] = row.strategy;
    entry["success"] = static_cast<double>(successes) / std::max(1.0, runs);
    entry["runs"] = row.results.size();
    entry["successes"] = successes;
    entry["interval"] = {interval.first, interval.second};
    entry["first_seed"] = row.first_seed;
    const auto time = Values(row, true, [](const auto& r) { return r.duration; });
    const auto error = Values(row, false, [](const auto& r) { return r.true_error_mm; });
    const auto joints = Values(row, false, [](const auto& r) { return r.joint_error_deg; });
    entry["time_s"] = {{"median", Quantile(time, 0.5)}, {"p95", Quantile(time, 0.95)}};
    entry["true_error_mm"] = {{"median", Quantile(error, 0.5)}, {"p95", Quantile(error, 0.95)}};
    entry["joint_error_deg"] = {{"median", Quantile(joints, 0.5)}, {"p95", Quantile(joints, 0.95)}};
    const auto mean = [&](const std::vector<double>& values) {
      return Sum(values) / std::max(1.0, runs);
    };
    entry["lost_events_mean"] =
        mean(Values(row, false, [](const auto& r) { return r.lost_events; }));
    entry["camera_travel_m_mean"] =
        mean(Values(row, false, [](const auto& r) { return r.travel_m; }));
    entry["moves_mean"] = mean(Values(row, false, [](const auto& r) { return r.moves; }));
    entry["low_share_mean"] = mean(Values(row, false, [](const auto& r) { return r.low_share; }));
    entry["goals_reached_mean"] =
        mean(Values(row, false, [](const auto& r) { return r.goals_reached; }));
    entry["limit_violations"] =
        Sum(Values(row, false, [](const auto& r) { return r.limit_violations; }));
    entry["failures"] = Json::array();
    for (std::size_t i = 0; i < row.results.size(); ++i) {
      const sim::TaskResult& r = row.results[i];
      if (r.success) continue;
      entry["failures"].push_back({{"seed", row.first_seed + i},
                                   {"end", r.end},
                                   {"time_s", r.duration},
                                   {"true_error_mm", r.true_error_mm},
                                   {"error_px", r.error_px},
                                   {"mm_per_px", r.mm_per_px},
                                   {"moves", r.moves},
                                   {"goals_reached", r.goals_reached}});
    }
    root["rows"].push_back(entry);
  }
  std::ofstream file(path);
  file << root.dump(1) << '\n';
  if (!file.flush()) throw WriteError(path);
}

}  // namespace vantage
