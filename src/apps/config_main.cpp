// vantage-config: reads configuration files without starting anything, and prints the reference of their keys.

#include <iostream>

#include "app.h"
#include "config_reference.h"

int main(int argc, char** argv) {
  CLI::App app("Checks configuration files, and prints the reference of all their keys.",
               "vantage-config");
  app.require_subcommand(1);

  std::string kind;
  std::vector<std::string> files;
  CLI::App* check = app.add_subcommand(
      "check", "Reads files as the programs would; says what is wrong with them");
  check->add_option("kind", kind, "What they are")
      ->required()
      ->check(CLI::IsMember(vantage::ConfigKindNames()));
  check->add_option("files", files, "YAML files, or built-in names")->required();

  std::vector<std::string> examples;
  CLI::App* reference = app.add_subcommand(
      "reference", "Prints every key with unit, range, default and meaning (Markdown)");
  reference->add_option("examples", examples, "Scenario files that use what no built-in one does");

  return vantage::RunApp(&app, argc, argv, [&] {
    if (reference->parsed()) {
      std::cout << vantage::ConfigReference(examples);
      return vantage::kExitOk;
    }
    for (const std::string& file : files) {
      const std::vector<std::string> remarks = vantage::CheckConfig(kind, file);
      std::cout << file << ": good\n";
      for (const std::string& remark : remarks) std::cout << "  " << remark << '\n';
    }
    return vantage::kExitOk;
  });
}
