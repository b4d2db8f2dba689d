// vantage-measure FILE: the measures of one configuration.

#include <iostream>

#include "app.h"
#include "measure_evaluate.h"
#include "measure_print.h"
#include "measure_setup.h"
#include "vantage/config/config_text.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

struct Arguments {
  std::string file;
  std::vector<std::string> oracle_case;
  bool json = false;
  bool list = false;
  int select = 0;
  int samples = 50;
  std::string by = "w_c";
  std::string over = "mean";
};

SelectionOptions OptionsOf(const Arguments& arguments) {
  SelectionOptions options;
  if (arguments.by == "sigma_min") options.criterion = SelectionCriterion::kSigmaMin;
  if (arguments.by == "trace") options.criterion = SelectionCriterion::kTrace;
  if (arguments.over == "worst") options.over = SelectionOver::kWorst;
  return options;
}

int List() {
  for (const std::string& name : BuiltInConfigs(ConfigKind::kMeasure)) {
    std::cout << name << ": " << FindMeasureSetup(name).description << '\n';
  }
  return kExitOk;
}

int Run(const Arguments& arguments) {
  if (arguments.list) return List();
  if (arguments.file.empty() == arguments.oracle_case.empty()) {
    throw ConfigError("", "",
                      "name one file to measure, or one --oracle-case FILE ID (see --help)");
  }
  const MeasureSetup setup =
      arguments.oracle_case.empty()
          ? FindMeasureSetup(arguments.file)
          : LoadOracleSetup(arguments.oracle_case[0], arguments.oracle_case[1]);
  MeasureReport report = Report(setup);
  if (arguments.select > 0) {
    const auto all = static_cast<int>(setup.features.features().size());
    if (arguments.select > all) {
      throw ConfigError("", "--select",
                        "must be 1 to the number of features, " + std::to_string(all) + ", is " +
                            std::to_string(arguments.select));
    }
    report.choice =
        ChooseFeatures(setup, arguments.select, arguments.samples, OptionsOf(arguments));
  }
  std::cout << (arguments.json ? ToJson(setup, report) : ToTable(setup, report));
  return kExitOk;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  vantage::Arguments arguments;
  CLI::App app(
      "Measures one configuration of arm, camera and features: Jacobians, singular values, w_v, "
      "w_r, w_c, "
      "the ellipsoid and the cause of a low w_c.",
      "vantage-measure");
  app.add_option("file", arguments.file, "YAML file, or a built-in one (see --list)");
  app.add_option("--oracle-case", arguments.oracle_case,
                 "Measures case ID of an oracle FILE (JSON) instead of a file")
      ->type_name("FILE ID")
      ->expected(2);
  app.add_flag("--list", arguments.list, "Lists the built-in files and ends");
  app.add_flag("--json", arguments.json, "Prints one JSON object with stable keys, all digits");
  CLI::Option* const select =
      app.add_option("--select", arguments.select,
                     "Chooses the best K features, at the file's joints or along its `path`")
          ->type_name("K")
          ->check(CLI::Range(1, vantage::kMaxRows));
  app.add_option("--by", arguments.by,
                 "What makes them the best: w_c (default), sigma_min or trace")
      ->type_name("MEASURE")
      ->check(CLI::IsMember({"w_c", "sigma_min", "trace"}))
      ->needs(select);
  app.add_option("--over", arguments.over, "What counts along the path: mean (default) or worst")
      ->type_name("WHAT")
      ->check(CLI::IsMember({"mean", "worst"}))
      ->needs(select);
  app.add_option("--samples", arguments.samples, "Configurations along the path (default: 50)")
      ->type_name("N")
      ->check(CLI::Range(2, 2001))
      ->needs(select);
  return vantage::RunApp(&app, argc, argv, "", [&] { return vantage::Run(arguments); });
}
