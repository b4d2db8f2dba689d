#include "app.h"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <iostream>

#include <unistd.h>

#include "vantage/math/error.h"

namespace vantage {
namespace {

// What does not fit onto the disk, or goes to a file that is closed, must not pass for done.
void FlushOutput() {
  std::cout.flush();
  if (!std::cout || std::fflush(stdout) != 0) {
    throw Error(std::string("cannot write the output: ") + std::strerror(errno));
  }
}

}  // namespace

const char* Version() {
  return VANTAGE_VERSION;
}

int RunApp(CLI::App* app, int argc, char** argv, const std::string& not_reached,
           const std::function<int()>& run) {
  app->set_version_flag("--version", "vantage " VANTAGE_VERSION);
  app->footer("Exit codes: 0 done, " + (not_reached.empty() ? "" : "1 " + not_reached + ", ") +
              "2 bad option, file or folder (nothing was started), 3 other failure.");
  app->get_formatter()->column_width(34);
  try {
    app->parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app->exit(error);  // --help, --version
    std::cerr << app->get_name() << ": " << error.what() << " (see --help)\n";
    return kExitUsage;
  }
  try {
    const int code = run();
    FlushOutput();
    return code;
  } catch (const ConfigError& error) {
    std::cerr << app->get_name() << ": " << error.what() << '\n';
    return kExitUsage;
  } catch (const std::exception& error) {
    std::cerr << app->get_name() << ": " << error.what() << '\n';
    return kExitFailure;
  }
}

CLI::Validator WholeNumber() {
  return CLI::Validator(
      [](std::string& text) {
        const bool digits =
            !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
        return digits ? std::string() : "must be a whole number, 0 or more, is " + text;
      },
      "");
}

void MakeOutputFolder(const std::string& option, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && ::access(folder.c_str(), W_OK | X_OK) != 0) {
    error = {errno, std::generic_category()};
  }
  if (error) throw ConfigError("", option, folder + ": " + error.message());
}

}  // namespace vantage
