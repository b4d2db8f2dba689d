// vantage-map RECIPE: measures over two swept parameters, as a table and as pictures.

#include <cstdio>
#include <filesystem>
#include <iostream>

#include "app.h"
#include "map_plot.h"
#include "map_recipe.h"
#include "map_sweep.h"
#include "progress_bar.h"
#include "vantage/config/config_text.h"
#include "vantage/math/error.h"
#include "vantage/math/format.h"

namespace vantage {
namespace {

struct Arguments {
  std::string recipe;
  std::string out = "maps";
  std::vector<int> samples;
  bool no_pictures = false;
  bool list = false;
  bool quiet = false;
};

int List() {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kRecipe)) {
    std::cout << name << ": " << FindMapRecipe(name).setup.description << '\n';
  }
  return kExitOk;
}

std::string Place(const MapRecipe& recipe, const MapCell& cell) {
  return Format("%s %.6g, %s %.6g", recipe.axes[0].name.c_str(), cell.x,
                recipe.axes[1].name.c_str(), cell.y);
}

void PrintExtremes(const MapRecipe& recipe, const MapTable& table) {
  std::vector<MapQuantity> quantities{MapQuantity::kViewW, MapQuantity::kArmW,
                                      MapQuantity::kCompositeW};
  if (recipe.setup.translation_task > 0) quantities.push_back(MapQuantity::kPaperProduct);
  for (const MapQuantity quantity : quantities) {
    const std::optional<MapExtremes> extremes = FindExtremes(table, quantity);
    if (!extremes) continue;
    std::printf("  %-13s  max %-12.6g at %s;  min %-12.6g at %s\n", Name(quantity), extremes->max,
                Place(recipe, extremes->at_max).c_str(), extremes->min,
                Place(recipe, extremes->at_min).c_str());
  }
  std::fflush(stdout);
}

int Run(const Arguments& arguments) {
  if (arguments.list) return List();
  if (arguments.recipe.empty()) throw ConfigError("", "", "name a recipe (see --list and --help)");
  MapRecipe recipe = FindMapRecipe(arguments.recipe);
  for (std::size_t i = 0; i < arguments.samples.size(); ++i) {
    recipe.axes[i].samples = arguments.samples[i];
  }
  MakeOutputFolder("--out", arguments.out);

  ProgressBar progress(arguments.quiet);
  const MapTable table = Sweep(recipe, [&](int done, int rows) {
    progress.Show(static_cast<double>(done) / rows,
                  std::to_string(done) + " of " + std::to_string(rows) + " rows");
  });
  progress.End();
  const std::string stem = (std::filesystem::path(arguments.out) / recipe.setup.name).string();
  std::vector<std::string> files{stem + ".csv"};
  WriteCsv(recipe, table, files[0]);
  if (!arguments.quiet) {
    std::cout << recipe.setup.name << ": " << recipe.setup.description << '\n' << std::flush;
    PrintExtremes(recipe, table);
  }
  const auto print_files = [&] {
    if (arguments.quiet) return;
    for (const std::string& file : files) std::cout << "  " << file << '\n';
    std::cout << std::flush;
  };
  try {
    if (!arguments.no_pictures) {
      for (const std::string& file : PlotMap(recipe, table, recipe.picture, stem)) {
        files.push_back(file);
      }
    }
  } catch (const Error&) {
    print_files();  // The table is there all the same.
    throw;
  }
  print_files();
  return kExitOk;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Maps w_v, w_r and w_c over two swept parameters of camera or arm: a CSV table, and surface "
      "and "
      "heat-map pictures (PNG, SVG) by gnuplot. fig3, fig4, fig6a, fig6b and fig7 are the paper's.",
      "vantage-map");
  app.add_option("recipe", arguments.recipe, "Built-in recipe (see --list) or a YAML file");
  app.add_option("--out", arguments.out, "Folder for the table and the pictures")
      ->capture_default_str();
  app.add_option("--samples", arguments.samples, "Samples along x and y, instead of the recipe's")
      ->type_name("NX NY")
      ->expected(2)
      ->check(CLI::Range(2, 2001));
  app.add_flag("--no-pictures", arguments.no_pictures, "Writes the table alone");
  app.add_flag("--list", arguments.list, "Lists the built-in recipes and ends");
  app.add_flag("--quiet", arguments.quiet, "Prints nothing but errors");
  return vantage::RunApp(&app, argc, argv, "", [&] { return vantage::Run(arguments); });
}
