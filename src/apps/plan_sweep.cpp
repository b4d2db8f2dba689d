#include "plan_sweep.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

// Of a line of the table.
constexpr std::size_t kCaseField = 1, kBaseField = 2, kFoundField = 6, kValueField = 7;

int MostCoordinates(const PlacementSweep& sweep) {
  int most = 0;
  for (const PlacementCase& one : sweep.cases) most = std::max(most, one.problem.rig.size());
  return most;
}

// The i-th rig coordinate's name and unit, when all cases have the same.
std::string CoordinateTitle(const PlacementSweep& sweep, int i) {
  std::string title;
  for (const PlacementCase& one : sweep.cases) {
    const CameraRig& rig = one.problem.rig;
    const std::string here =
        i < rig.size() ? rig.axes[i].name + (AxisTurns(rig, i) ? " [rad]" : " [m]") : "";
    if (!title.empty() && here != title) return "q_c" + std::to_string(i + 1) + " [m or rad]";
    title = here;
  }
  return title;
}

// What a shard's table begins with: equal for all shards of one problem and seed.
std::string HeaderOf(const PlacementSetup& setup) {
  std::string header =
      "# vantage-plan sweep of " + setup.name + ", problem " + std::to_string(setup.fingerprint) +
      ", seed " + std::to_string(setup.search.seed) + ", " + std::to_string(setup.sweep.size()) +
      " items\nitem,case,x [m],y [m],z [m],yaw [deg],found,value,camera x [m],camera y [m],"
      "camera z [m],camera qw,camera qx,camera qy,camera qz";
  for (int i = 0; i < MostCoordinates(setup.sweep); ++i) {
    header += "," + CoordinateTitle(setup.sweep, i);
  }
  return header + "\n";
}

std::string LineOf(const PlacementSetup& setup, int item, const PlacedCamera& camera) {
  const BaseShift& base = setup.sweep.BaseOf(item);
  std::string line = std::to_string(item) + "," + setup.sweep.CaseOf(item).name;
  for (const double value : {base.shift.x(), base.shift.y(), base.shift.z()}) {
    line += "," + ExactText(value);
  }
  line += "," + ExactText(base.yaw * kDegreesPerRadian) + (camera.feasible ? ",1" : ",0");
  const Eigen::Vector3d& p = camera.X_WC.translation();
  const Eigen::Quaterniond q(camera.X_WC.linear());
  for (const double value : {camera.value, p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()}) {
    line += "," + (camera.feasible ? ExactText(value) : "");
  }
  for (int i = 0; i < MostCoordinates(setup.sweep); ++i) {
    line += "," + (camera.feasible && i < camera.q_c.size() ? ExactText(camera.q_c(i)) : "");
  }
  return line + "\n";
}

// A line of the table in its parts.
std::vector<std::string> FieldsOf(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line);
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

struct Table {
  std::string header;
  std::map<int, std::string> lines;
  int items{0};
};

// The number of fields tells a line that was cut off while it was written, unless that was within the last.
bool IsWhole(const std::string& line, const std::string& header) {
  const std::string titles = header.substr(header.find('\n') + 1);
  return std::count(line.begin(), line.end(), ',') == std::count(titles.begin(), titles.end(), ',');
}

// A last line that was cut off while it was written: left out, or an error.
enum class Torn { kLeftOut, kRefused };

void Append(const std::string& path, Torn torn, Table* table) {
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
    if (in.eof() && torn == Torn::kLeftOut) return;
    const std::string where = path + ":" + std::to_string(number);
    int item = -1;
    if (std::sscanf(line.c_str(), "%d,", &item) != 1 || item < 0 || item >= items) {
      throw ConfigError(where, "", "is no line of a sweep");
    }
    if (in.eof() || !IsWhole(line, header)) {
      throw ConfigError(where, "", "is cut off: run this part of the sweep again to finish it");
    }
    if (!table->lines.emplace(item, line + "\n").second) {
      throw ConfigError(where, "", "item " + std::to_string(item) + " is there twice");
    }
  }
}

// At no time is there less in the file than before.
void WriteTable(const std::string& path, const std::string& header,
                const std::map<int, std::string>& lines) {
  const std::string fresh = path + ".new";
  std::ofstream out(fresh);
  out << header;
  for (const auto& line : lines) out << line.second;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(fresh, path, error);
  if (!out || error) throw WriteError(path);
}

// Lines that an interrupted run of the same sweep has left.
std::map<int, std::string> LinesLeft(const std::string& path, const std::string& header) {
  std::ifstream in(path);
  std::string first;
  if (!in || !std::getline(in, first) || header.rfind(first + "\n", 0) != 0) return {};
  Table table;
  table.header = header;
  Append(path, Torn::kLeftOut, &table);
  return table.lines;
}

}  // namespace

int RunSweep(const PlacementSetup& setup, const Shard& shard, const std::string& path, Begin begin,
             const PlanProgress& told, const DealItems& deal) {
  const std::string header = HeaderOf(setup);
  const bool helps = path.empty();
  std::map<int, std::string> lines;
  if (!helps && begin == Begin::kWhereItStopped) lines = LinesLeft(path, header);
  std::vector<int> items = ItemsOf(shard, setup.sweep.size());
  items.erase(
      std::remove_if(items.begin(), items.end(), [&](int item) { return lines.count(item) > 0; }),
      items.end());
  const auto left = static_cast<int>(lines.size());
  std::optional<double> best;
  const auto judge = [&](const std::string& line) {
    const std::vector<std::string> fields = FieldsOf(line);
    if (fields[kFoundField] != "1") return;
    const double value = std::strtod(fields[kValueField].c_str(), nullptr);
    if (!best || value > *best) best = value;
  };
  for (const auto& [item, line] : lines) judge(line);
  std::ofstream out;
  if (!helps) {
    WriteTable(path, header, lines);
    out.open(path, std::ios::app);
  }
  const auto work = [&](int item) {
    const PlacementModel model(ProblemAt(setup.sweep, item));
    return LineOf(setup, item, PlaceCamera(model, setup.search).best);
  };
  std::size_t done = 0;
  const auto take = [&](int item, const std::string& line) {
    out << line << std::flush;  // so that little is lost when the machine goes down
    lines[item] = line;
    judge(line);
    ++done;
    if (told) told("sweep", static_cast<double>(done) / static_cast<double>(items.size()), best);
  };
  deal(items, work, take);
  if (helps) return 0;
  out.close();
  if (!out) throw WriteError(path);
  WriteTable(path, header, lines);
  return left;
}

void MergeSweeps(const std::vector<std::string>& paths, const std::string& path) {
  Table table;
  for (const std::string& part : paths) Append(part, Torn::kRefused, &table);
  for (int item = 0; item < table.items; ++item) {
    if (table.lines.count(item) == 0) {
      throw ConfigError("", "--merge",
                        "item " + std::to_string(item) + " is in none of the tables");
    }
  }
  WriteTable(path, table.header, table.lines);
}

std::string BestOfSweep(const std::string& path, int most) {
  Table table;
  Append(path, Torn::kRefused, &table);
  std::vector<std::pair<double, std::string>> found;
  for (const auto& [item, line] : table.lines) {
    const std::vector<std::string> fields = FieldsOf(line);
    if (fields.size() <= kValueField || fields[kFoundField] != "1") continue;
    std::array<double, 4> base{};
    for (std::size_t i = 0; i < base.size(); ++i) {
      base[i] = std::strtod(fields[kBaseField + i].c_str(), nullptr);
    }
    const double value = std::strtod(fields[kValueField].c_str(), nullptr);
    found.emplace_back(
        -value, Format("  item %d, %.80s: base moved by (%g, %g, %g) m, %g deg: value %.6g\n", item,
                       fields[kCaseField].c_str(), base[0], base[1], base[2], base[3], value));
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
