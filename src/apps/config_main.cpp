// vantage-config: reads configuration files without starting anything, and prints the reference of their keys.

#include <iostream>

#include "app.h"
#include "config_reference.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

// Every file is read, whatever is wrong with the ones before.
int Check(const std::string& kind, const std::vector<std::string>& files) {
  int code = kExitOk;
  for (const std::string& file : files) {
    try {
      const std::vector<std::string> remarks = CheckConfig(kind, file);
      std::cout << file << ": good\n";
      for (const std::string& remark : remarks) std::cout << "  " << remark << '\n';
    } catch (const ConfigError& error) {
      std::cerr << "vantage-config: " << error.what() << '\n';
      code = kExitUsage;
    }
  }
  return code;
}

}  // namespace
}  // namespace vantage

int main(int argc, char** argv) {
  CLI::App app(
      "Checks configuration files, shows the built-in ones, and prints the reference of all keys.",
      "vantage-config");
  app.require_subcommand(1);
  std::string kind;
  const auto add_kind = [&](CLI::App* command) {
    command->add_option("kind", kind, "What they are")
        ->required()
        ->check(CLI::IsMember(vantage::ConfigKindNames()));
  };

  std::vector<std::string> files;
  CLI::App* check = app.add_subcommand(
      "check", "Reads files as the programs would; says what is wrong with them");
  add_kind(check);
  check->add_option("files", files, "YAML files, or built-in names")->required();

  CLI::App* list = app.add_subcommand("list", "Names the built-in files of a kind");
  add_kind(list);

  std::string name;
  CLI::App* show = app.add_subcommand(
      "show", "Prints a built-in file, to begin one of your own with: show scenario ur5-bad-view");
  add_kind(show);
  show->add_option("name", name, "Built-in name")->required();

  std::vector<std::string> examples;
  CLI::App* reference = app.add_subcommand(
      "reference", "Prints every key with unit, range, default and meaning (Markdown)");
  reference->add_option("examples", examples, "Scenario files that use what no built-in one does");

  return vantage::RunApp(&app, argc, argv, "", [&] {
    if (check->parsed()) return vantage::Check(kind, files);
    if (list->parsed()) {
      for (const std::string& known : vantage::ListConfigs(kind)) std::cout << known << '\n';
    } else if (show->parsed()) {
      std::cout << vantage::ShowConfig(kind, name);
    } else {
      std::cout << vantage::ConfigReference(examples);
    }
    return static_cast<int>(vantage::kExitOk);
  });
}
