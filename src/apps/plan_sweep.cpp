#include "plan_sweep.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "vantage/math/error.h"

namespace vantage {
namespace {

constexpr double kDegrees = 180.0 / M_PI;

std::string Exact(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

// What a shard's table begins with: equal for all shards of one problem.
std::string HeaderOf(const PlacementSetup& setup) {
  std::string header = "# vantage-plan sweep of " + setup.name + ", problem " +
                       std::to_string(setup.fingerprint) + ", " +
                       std::to_string(setup.bases.size()) +
                       " items\nitem,x [m],y [m],z [m],yaw [deg],found,value";
  const CameraRig& rig = setup.problem.rig;
  for (int i = 0; i < rig.size(); ++i) {
    header += "," + rig.axes[i].name + (AxisTurns(rig, i) ? " [rad]" : " [m]");
  }
  return header + "\n";
}

std::string LineOf(const PlacementSetup& setup, int item, const PlacedCamera& camera) {
  const BaseShift& base = setup.bases[item];
  std::string line = std::to_string(item);
  for (const double value : {base.shift.x(), base.shift.y(), base.shift.z()}) {
    line += "," + Exact(value);
  }
  line += "," + Exact(base.yaw * kDegrees) + (camera.feasible ? ",1," : ",0,") +
          (camera.feasible ? Exact(camera.value) : "");
  for (const double q : camera.q_c) line += "," + (camera.feasible ? Exact(q) : std::string());
  return line + "\n";
}

struct Table {
  std::string header;
  std::map<int, std::string> lines;
  int items{0};
};

void Append(const std::string& path, Table* table) {
  std::ifstream in(path);
  if (!in) throw ConfigError(path, "", "cannot be opened");
  std::string first, second, line;
  std::getline(in, first);
  std::getline(in, second);
  const std::size_t comma = first.rfind(", ");
  int items = 0;
  if (first.rfind("# vantage-plan sweep of ", 0) != 0 || comma == std::string::npos ||
      std::sscanf(first.c_str() + comma, ", %d items", &items) != 1) {
    throw ConfigError(path + ":1", "", "is no table of a sweep");
  }
  const std::string header = first + "\n" + second + "\n";
  if (!table->header.empty() && header != table->header) {
    throw ConfigError(path + ":1", "", "is of another problem than the first table");
  }
  table->header = header;
  table->items = items;
  for (int number = 3; std::getline(in, line); ++number) {
    int item = -1;
    if (std::sscanf(line.c_str(), "%d,", &item) != 1 || item < 0 || item >= items) {
      throw ConfigError(path + ":" + std::to_string(number), "", "is no line of a sweep");
    }
    if (!table->lines.emplace(item, line + "\n").second) {
      throw ConfigError(path + ":" + std::to_string(number), "",
                        "item " + std::to_string(item) + " is there twice");
    }
  }
}

}  // namespace

Shard ParseShard(const std::string& text) {
  Shard shard;
  int used = 0;
  if (std::sscanf(text.c_str(), "%d/%d%n", &shard.index, &shard.count, &used) != 2 ||
      used != static_cast<int>(text.size()) || shard.count < 1 || shard.index < 1 ||
      shard.index > shard.count) {
    throw ConfigError("", "--shard", "must be i/N with 1 <= i <= N, is '" + text + "'");
  }
  return shard;
}

void RunSweep(const PlacementSetup& setup, const Shard& shard, const std::string& path,
              const PlanProgress& told) {
  std::ofstream out(path);
  out << HeaderOf(setup);
  std::optional<double> best;
  const int items = static_cast<int>(setup.bases.size());
  for (int item = shard.index - 1; item < items; item += shard.count) {
    const PlacementModel model(ProblemAt(setup, item));
    const PlacedCamera camera = PlaceCamera(model, setup.search).best;
    out << LineOf(setup, item, camera) << std::flush;
    if (camera.feasible && (!best || camera.value > *best)) best = camera.value;
    if (told) told("sweep", static_cast<double>(item + 1) / items, best);
  }
  out.close();
  if (!out) throw WriteError(path);
}

void MergeSweeps(const std::vector<std::string>& paths, const std::string& path) {
  Table table;
  for (const std::string& part : paths) Append(part, &table);
  for (int item = 0; item < table.items; ++item) {
    if (table.lines.count(item) == 0) {
      throw ConfigError("", "--merge",
                        "item " + std::to_string(item) + " is in none of the tables");
    }
  }
  std::ofstream out(path);
  out << table.header;
  for (const auto& line : table.lines) out << line.second;
  out.close();
  if (!out) throw WriteError(path);
}

std::string BestOfSweep(const std::string& path, int most) {
  Table table;
  Append(path, &table);
  std::vector<std::pair<double, std::string>> found;
  for (const auto& [item, line] : table.lines) {
    double x = 0, y = 0, z = 0, yaw = 0, value = 0;
    int is_found = 0;
    if (std::sscanf(line.c_str(), "%*d,%lf,%lf,%lf,%lf,%d,%lf", &x, &y, &z, &yaw, &is_found,
                    &value) != 6 ||
        is_found == 0) {
      continue;
    }
    char text[160];
    std::snprintf(text, sizeof text,
                  "  item %d: base moved by (%g, %g, %g) m, %g deg: value %.6g\n", item, x, y, z,
                  yaw, value);
    found.emplace_back(-value, text);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::string text = std::to_string(found.size()) + " of " + std::to_string(table.lines.size()) +
                     " items have a camera\n";
  for (std::size_t i = 0; i < found.size() && static_cast<int>(i) < most; ++i) {
    text += found[i].second;
  }
  return text;
}

}  // namespace vantage
