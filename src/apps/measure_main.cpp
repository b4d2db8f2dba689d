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
};

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
  const Measurement measurement = Evaluate(setup, setup.q, setup.q_c);
  std::cout << (arguments.json ? ToJson(setup, measurement) : ToTable(setup, measurement));
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
  return vantage::RunApp(&app, argc, argv, [&] { return vantage::Run(arguments); });
}
