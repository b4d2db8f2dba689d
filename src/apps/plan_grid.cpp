#include "plan_grid.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "vantage/math/error.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

constexpr const char* kTitle = "# vantage-plan grid check of ";
constexpr const char* kColumns = "camera,cell,score";

// What tables of one problem begin with.
std::string TitleOf(const PlacementSetup& setup) {
  return kTitle + setup.name + ", problem " + std::to_string(setup.fingerprint) + ", ";
}

std::string LineOf(const GridCamera& camera) {
  return std::to_string(camera.index) + "," + std::to_string(camera.cell) + "," +
         ExactText(camera.score) + "\n";
}

// A line, without its end, of a grid of `cameras`; nothing: it is none.
std::optional<GridCamera> CameraOf(const std::string& line, std::int64_t cameras) {
  long long index = -1;
  unsigned long long cell = 0;
  double score = 0.0;
  int used = 0;
  if (std::sscanf(line.c_str(), "%lld,%llu,%lf%n", &index, &cell, &score, &used) != 3 ||
      used != static_cast<int>(line.size()) || index < 0 || index >= cameras || std::isnan(score)) {
    return std::nullopt;
  }
  return GridCamera{index, cell, score};
}

struct Table {
  std::int64_t cameras{0};  // of the whole grid
  Shard shard;
  std::vector<GridCamera> kept;
};

Table ReadTable(const std::string& path, const PlacementSetup& setup) {
  std::ifstream in(path);
  if (!in) throw ConfigError(path, "", "cannot be opened");
  int number = 1;
  const auto refuse = [&](const std::string& reason) {
    throw ConfigError(path + ":" + std::to_string(number), "", reason);
  };
  std::string line;
  std::getline(in, line);
  if (line.rfind(kTitle, 0) != 0) refuse("is no table of a grid check");
  const std::string title = TitleOf(setup);
  if (line.rfind(title, 0) != 0) refuse("is of another problem than " + setup.name);
  const std::string rest = line.substr(title.size());
  Table table;
  long long cameras = 0, kept = 0;
  int used = 0;
  if (std::sscanf(rest.c_str(), "%lld cameras, part %d of %d, %lld kept%n", &cameras,
                  &table.shard.index, &table.shard.count, &kept, &used) != 4 ||
      used != static_cast<int>(rest.size()) || cameras < 1 || table.shard.index < 1 ||
      table.shard.index > table.shard.count) {
    refuse("is no first line of a grid check");
  }
  table.cameras = cameras;
  ++number;
  if (!std::getline(in, line) || line != kColumns)
    refuse("must be '" + std::string(kColumns) + "'");
  for (++number; std::getline(in, line); ++number) {
    const std::optional<GridCamera> camera = CameraOf(line, cameras);
    if (!camera) refuse("is no line of a grid check");
    table.kept.push_back(*camera);
  }
  if (static_cast<long long>(table.kept.size()) != kept) {
    throw ConfigError(path, "",
                      "has " + std::to_string(table.kept.size()) + " cameras, must have the " +
                          std::to_string(kept) + " of its first line");
  }
  return table;
}

}  // namespace

SearchedGrid SearchGrid(const PlacementModel& model, std::int64_t cameras, const Shard& shard,
                        const PlanProgress& told, const DealItems& deal) {
  SearchedGrid grid;
  grid.cameras = cameras;
  const std::vector<int> blocks = ItemsOf(shard, GridSearch::BlocksOf(cameras));
  GridSearch search(model, cameras);  // for `work` alone: it may run in another thread than `take`
  const auto work = [&](int block) {
    std::string text;
    for (const GridCamera& camera : search.Search(block)) text += LineOf(camera);
    return text;
  };
  std::size_t done = 0;
  const auto take = [&](int /*block*/, const std::string& text) {
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) {
      grid.best.Offer(CameraOf(line, cameras).value());
    }
    ++done;
    if (told) {
      told("grid check", static_cast<double>(done) / static_cast<double>(blocks.size()),
           grid.best.ValueOfBest(model));
    }
  };
  deal(blocks, work, take);
  return grid;
}

void WriteGridTable(const std::string& path, const PlacementSetup& setup, const Shard& shard,
                    const SearchedGrid& grid) {
  std::ofstream out(path);
  out << TitleOf(setup) << grid.cameras << " cameras, part " << shard.index << " of " << shard.count
      << ", " << grid.best.cameras().size() << " kept\n"
      << kColumns << '\n';
  for (const GridCamera& camera : grid.best.cameras()) out << LineOf(camera);
  out.close();
  if (!out) throw WriteError(path);
}

bool IsGridTable(const std::string& path) {
  std::ifstream in(path);
  if (!in) throw ConfigError(path, "", "cannot be opened");
  std::string first;
  std::getline(in, first);
  return first.rfind(kTitle, 0) == 0;
}

SearchedGrid ReadGridTables(const std::vector<std::string>& paths, const PlacementSetup& setup) {
  SearchedGrid grid;
  int parts = 0;
  std::set<int> there;
  for (const std::string& path : paths) {
    const Table table = ReadTable(path, setup);
    if (there.empty()) {
      grid.cameras = table.cameras;
      parts = table.shard.count;
    }
    const auto refuse = [&](const std::string& reason) {
      throw ConfigError(path + ":1", "", reason);
    };
    if (table.cameras != grid.cameras) {
      refuse("is of a grid of " + std::to_string(table.cameras) + " cameras, the first table of " +
             std::to_string(grid.cameras));
    }
    if (table.shard.count != parts) {
      refuse("is one of " + std::to_string(table.shard.count) + " parts, the first table of " +
             std::to_string(parts));
    }
    if (!there.insert(table.shard.index).second) {
      refuse("part " + std::to_string(table.shard.index) + " is there twice");
    }
    for (const GridCamera& camera : table.kept) grid.best.Offer(camera);
  }
  for (int part = 1; part <= parts; ++part) {
    if (there.count(part) > 0) continue;
    throw ConfigError("", "--merge",
                      "part " + std::to_string(part) + " of " + std::to_string(parts) +
                          " is in none of the tables");
  }
  return grid;
}

}  // namespace vantage
