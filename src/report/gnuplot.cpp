#include "vantage/report/gnuplot.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>

#include "vantage/math/error.h"
#include "vantage/runtime/child_process.h"

namespace vantage {

std::string GnuplotString(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    // Between double quotes gnuplot hands what stands between backquotes to a shell.
    if (c == '"' || c == '\\' || c == '`' || c == '$') quoted += '\\';
    quoted += c == '\n' ? std::string("\\n") : std::string(1, c);
  }
  return quoted + "\"";
}

std::string GnuplotLiteral(const std::string& text) {
  std::string literal;
  for (const char c : text) {
    if (std::strchr("_^{}@&~\\", c) != nullptr) literal += '\\';
    literal += c == '\n' || c == '\r' ? ' ' : c;
  }
  return literal;
}

void RunGnuplot(const std::string& script_path) {
  const std::filesystem::path script = std::filesystem::absolute(script_path);
  const std::filesystem::path log = script.string() + ".log";
  ChildOptions options;
  // gnuplot resolves names against its own working directory; the script's folder is what is meant.
  options.arguments = {"gnuplot", "-e", "cd " + GnuplotString(script.parent_path().string()),
                       script.string()};
  options.output = log.string();
  std::optional<ChildProcess> child;
  try {
    child.emplace(options);
  } catch (const Error& error) {
    std::filesystem::remove(log);
    throw Error("cannot draw " + script_path + ": " + error.what() +
                " (install it: sudo apt-get install gnuplot-nox)");
  }
  const auto status = child->WaitFor(std::chrono::seconds(60));
  std::ostringstream said;
  said << std::ifstream(log).rdbuf();
  std::filesystem::remove(log);
  if (!status || !status->success()) {
    throw Error("gnuplot failed on " + script_path + ": " +
                (status ? status->ToString() : "no end after 60 s") + "\n" + said.str());
  }
}

}  // namespace vantage
