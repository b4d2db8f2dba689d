#include "app.h"

#include <exception>
#include <iostream>

#include "vantage/math/error.h"

namespace vantage {

const char* Version() {
  return VANTAGE_VERSION;
}

int RunApp(CLI::App* app, int argc, char** argv, const std::function<int()>& run) {
  app->set_version_flag("--version", "vantage " VANTAGE_VERSION);
  app->footer("Exit codes: 0 done, 1 ran but did not reach its aim, 2 bad input, 3 other failure.");
  app->get_formatter()->column_width(34);
  try {
    app->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app->exit(error) == 0 ? kExitOk : kExitUsage;
  }
  try {
    return run();
  } catch (const ConfigError& error) {
    std::cerr << app->get_name() << ": " << error.what() << '\n';
    return kExitUsage;
  } catch (const std::exception& error) {
    std::cerr << app->get_name() << ": " << error.what() << '\n';
    return kExitFailure;
  }
}

}  // namespace vantage
