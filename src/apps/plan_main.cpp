// vantage-plan PROBLEM: where a camera should stand. Linked with plan_team_mpi.cpp it is vantage-plan-mpi.

#include <chrono>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>

#include "app.h"
#include "plan_grid.h"
#include "plan_pictures.h"
#include "plan_print.h"
#include "plan_result.h"
#include "plan_shard.h"
#include "plan_sweep.h"
#include "plan_team.h"
#include "vantage/config/config_text.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

struct Arguments {
  std::string problem;
  std::string out = "plans";
  std::int64_t grid_check = 0;
  std::optional<std::uint64_t> seed;
  std::string shard = "1/1";
  std::vector<std::string> merge;
  bool anew = false;
  bool no_pictures = false;
  bool list = false;
  bool quiet = false;
};

int List() {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kProblem)) {
    std::cout << name << ": " << LoadPlacement(name).description << '\n';
  }
  for (const std::string& name : BuiltInConfigs(ConfigKind::kScenario)) {
    std::cout << name << ": the scenario's camera; " << LoadPlacement(name).description << '\n';
  }
  return kExitOk;
}

std::string MakeStem(const std::string& folder, const std::string& name) {
  MakeOutputFolder("--out", folder);
  return (std::filesystem::path(folder) / name).string();
}

double SecondsSince(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

DealItems DealerOf(PlanTeam* team) {
  return [team](const auto& items, const auto& work, const auto& take) {
    team->Deal(items, work, take);
  };
}

// A shard's part of the grid check, or what the ranks that help rank 0 do of it: no search for a camera.
int SearchPartOfGrid(const Arguments& arguments, const PlacementSetup& setup, const Shard& shard,
                     PlanTeam* team) {
  const std::string path = MakeStem(arguments.out, setup.name) + "_grid" + SuffixOf(shard) + ".csv";
  const PlacementModel model(setup.problem);
  PlanProgressBar bar(arguments.quiet);
  const SearchedGrid grid =
      SearchGrid(model, arguments.grid_check, shard, std::ref(bar), DealerOf(team));
  bar.End();
  if (team->rank() > 0) return kExitOk;
  WriteGridTable(path, setup, shard, grid);
  if (!arguments.quiet) {
    std::cout << GridPartText(model, shard, grid) << "  " << path << '\n';
  }
  return kExitOk;
}

int PlaceFixed(const Arguments& arguments, const PlacementSetup& setup, PlanTeam* team) {
  const std::string stem = MakeStem(arguments.out, setup.name);
  // Before the search: tables that do not fit are refused at once.
  std::optional<SearchedGrid> grid;
  if (!arguments.merge.empty()) grid = ReadGridTables(arguments.merge, setup);
  const PlacementModel model(setup.problem);
  PlanProgressBar bar(arguments.quiet);
  const PlanProgress progress = std::ref(bar);
  const auto start = std::chrono::steady_clock::now();
  const PlacementResult result = PlaceCamera(model, setup.search, progress);
  const double seconds = SecondsSince(start);
  if (arguments.grid_check > 0) {
    // Without a result there is nothing to check: the other ranks, who wait for work, get none.
    const std::int64_t cameras = result.best.feasible ? arguments.grid_check : 0;
    grid = SearchGrid(model, cameras, {}, progress, DealerOf(team));
  }
  std::optional<GridCheck> check;
  if (grid && result.best.feasible) check = FinishGridCheck(model, result.best, *grid, progress);
  bar.End();
  std::vector<std::string> files{stem + "_plan.yaml"};
  std::optional<CameraPathResult> path;
  double path_seconds = 0.0;
  if (setup.camera_moves) {
    const auto path_start = std::chrono::steady_clock::now();
    path = PlanCameraPath(model, result.best, setup.path_search, progress);
    path_seconds = SecondsSince(path_start);
    bar.End();
  }
  const bool path_found = path && path->path.broken == 0;
  if (path_found) {
    files.push_back(stem + "_path.csv");
    WriteCameraPath(files.back(), setup, path->path);
  }
  if (!result.best.feasible) {
    std::cerr << PlanTeam::kProgram << ": " << InfeasibleText(setup, result);
    if (path) std::cout << PathText(model, *path, path_seconds);
    if (path_found) std::cout << "  " << files.back() << '\n';
    return path_found ? kExitOk : kExitNotReached;
  }
  WritePlacementResult(files[0], setup, model, result, seconds, check);
  if (!arguments.quiet) {
    std::cout << ResultText(setup, model, result, seconds);
    if (check) std::cout << GridCheckText(*check);
    if (path) std::cout << PathText(model, *path, path_seconds);
    std::cout << std::flush;
  }
  const auto print_files = [&] {
    if (arguments.quiet) return;
    for (const std::string& file : files) std::cout << "  " << file << '\n';
    std::cout << std::flush;
  };
  if (!arguments.no_pictures) {
    try {
      for (const std::string& file : PlotPlacementMap(setup, model, result, stem)) {
        files.push_back(file);
      }
      for (const std::string& file : DrawViews(setup, result, stem)) files.push_back(file);
    } catch (const Error&) {
      print_files();  // The result is there all the same.
      throw;
    }
  }
  print_files();
  if (!arguments.quiet && !setup.scenario.empty()) {
    std::cout << "from there: vantage-run " << setup.scenario << " --camera-plan " << files[0]
              << '\n';
  }
  return kExitOk;
}

int Sweep(const Arguments& arguments, const PlacementSetup& setup, PlanTeam* team) {
  const Shard shard = ParseShard(arguments.shard);
  const bool helps = team->rank() > 0;
  const std::string path =
      helps ? "" : MakeStem(arguments.out, setup.name) + "_sweep" + SuffixOf(shard) + ".csv";
  PlanProgressBar bar(arguments.quiet);
  const int left =
      RunSweep(setup, shard, path, arguments.anew ? Begin::kAnew : Begin::kWhereItStopped,
               std::ref(bar), DealerOf(team));
  bar.End();
  if (helps) return kExitOk;
  if (left > 0 && !arguments.quiet) {
    std::cout << left << " of the items were in the table already (--anew works them out again)\n";
  }
  if (!arguments.quiet) std::cout << BestOfSweep(path, 5) << "  " << path << '\n';
  return kExitOk;
}

int MergeTablesOfSweep(const Arguments& arguments) {
  const std::string path = MakeStem(arguments.out, "sweep") + ".csv";
  MergeSweeps(arguments.merge, path);
  if (!arguments.quiet) std::cout << BestOfSweep(path, 5) << "  " << path << '\n';
  return kExitOk;
}

int PlaceOne(const Arguments& arguments, const PlacementSetup& setup, PlanTeam* team) {
  const Shard shard = ParseShard(arguments.shard);
  const auto refuse = [&](const std::string& key, const std::string& what) {
    throw ConfigError(
        "", key, setup.name + " is one problem: only a sweep or a --grid-check can be " + what);
  };
  if (arguments.grid_check == 0) {
    if (shard.count > 1) refuse("--shard", "cut");
    if (team->size() > 1) refuse("", "dealt out to " + std::to_string(team->size()) + " ranks");
  }
  if (shard.count > 1 || team->rank() > 0) return SearchPartOfGrid(arguments, setup, shard, team);
  return PlaceFixed(arguments, setup, team);
}

int Run(Arguments arguments, PlanTeam* team) {
  arguments.quiet = arguments.quiet || team->rank() > 0;
  if (arguments.list) return List();
  const bool merges = !arguments.merge.empty();
  if (merges && !IsGridTable(arguments.merge.front())) return MergeTablesOfSweep(arguments);
  if (arguments.problem.empty()) {
    throw ConfigError("", merges ? "--merge" : "",
                      merges ? "tables of a grid check need their problem: PROBLEM --merge FILES"
                             : "name a problem or a scenario (see --list and --help)");
  }
  PlacementSetup setup = LoadPlacement(arguments.problem);
  if (arguments.seed) setup.search.seed = *arguments.seed;
  if (!arguments.quiet) std::cout << setup.name << ": " << setup.description << '\n' << std::flush;
  if (setup.sweep.size() > 0 && !merges) {
    if (arguments.grid_check > 0) {
      throw ConfigError("", "--grid-check",
                        setup.name + " is a sweep: only one problem is checked");
    }
    return Sweep(arguments, setup, team);
  }
  return PlaceOne(arguments, setup, team);
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Finds where a camera should stand for an arm's motion: the best observability (paper, eqs. "
      "13, 14, 16, 23) under field of view, depth, focus, occlusion, facing and keep-out limits. "
      "Writes the camera as YAML for vantage-run, a heat map and pictures of the views.",
      vantage::PlanTeam::kProgram);
  app.add_option("problem", arguments.problem,
                 "Built-in problem (see --list), a YAML file, or a scenario's name");
  app.add_option("--out", arguments.out, "Folder for the result and the pictures")
      ->capture_default_str();
  CLI::Option* grid_check =
      app.add_option("--grid-check", arguments.grid_check,
                     "Also searches a dense grid of this many cameras and states the gap")
          ->expected(0, 1)
          ->default_str("200000")
          ->check(CLI::Range(std::int64_t{1000}, std::int64_t{100000000000}));
  app.add_option("--seed", arguments.seed, "Of the search, instead of the problem's")
      ->check(vantage::WholeNumber());
  CLI::Option* shard =
      app.add_option(
             "--shard", arguments.shard,
             "Of a sweep, or of --grid-check: works on part i of N; the parts are independent")
          ->type_name("i/N")
          ->capture_default_str();
  app.add_option("--merge", arguments.merge,
                 "Joins the tables of a sweep's shards into sweep.csv in --out; after PROBLEM, "
                 "those of its grid check: states the gap")
      ->type_name("FILES")
      ->excludes(shard)
      ->excludes(grid_check);
  app.add_flag(
      "--anew", arguments.anew,
      "Of a sweep: works out all items, also those that an interrupted run left in the table");
  app.add_flag("--no-pictures", arguments.no_pictures, "Writes the result alone");
  app.add_flag("--list", arguments.list, "Lists the built-in problems and ends");
  app.add_flag("--quiet", arguments.quiet, "Prints nothing but errors");
  std::optional<vantage::PlanTeam> team;
  const int exit_code = vantage::RunApp(&app, argc, argv, "no camera keeps all limits", [&] {
    team.emplace(&argc, &argv);
    return vantage::Run(arguments, &*team);
  });
  if (team) team->Leave(exit_code);
  return exit_code;
}
