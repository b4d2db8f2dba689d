#include "config_reference.h"

#include <functional>
#include <iterator>
#include <sstream>

#include "map_recipe.h"
#include "measure_setup.h"
#include "vantage/config/config_text.h"
#include "vantage/config/placement_file.h"
#include "vantage/config/scenario.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

// One kind of file: how it is read, and what the page says of it.
struct Kind {
  const char* name;
  ConfigKind built_in;
  const char* intro;
  std::function<std::vector<std::string>(const std::string&, SchemaRecorder*)> read;
};

std::vector<std::string> Lines(const RobotRemarks& remarks) {
  std::vector<std::string> lines;
  for (const std::string& warning : remarks.warnings) lines.push_back("warning: " + warning);
  for (const std::string& note : remarks.notes) lines.push_back(note);
  return lines;
}

const std::vector<Kind>& Kinds() {
  static const std::vector<Kind> kinds{
      {"scenario", ConfigKind::kScenario,
       "One task for one arm and one camera: `vantage-run FILE`, and `vantage-servo`, "
       "`vantage-sim`. Built-in ones: "
       "`vantage-run --list`.",
       [](const std::string& name, SchemaRecorder* recorder) {
         return Lines(LoadScenario(name, recorder).remarks);
       }},
      {"robot", ConfigKind::kRobot,
       "An arm by DH rows, or by a URDF file (`urdf: arm.urdf`). A scenario's `robot` names such a "
       "file, or holds these "
       "keys itself.",
       [](const std::string& name, SchemaRecorder* recorder) {
         RobotRemarks remarks;
         static_cast<void>(FindRobot(name, "", recorder, &remarks));
         return Lines(remarks);
       }},
      {"measure", ConfigKind::kMeasure, "One configuration for `vantage-measure FILE`.",
       [](const std::string& name, SchemaRecorder* recorder) {
         static_cast<void>(FindMeasureSetup(name, recorder));
         return std::vector<std::string>();
       }},
      {"recipe", ConfigKind::kRecipe,
       "Two swept parameters for `vantage-map FILE`, over the keys of a measurement.",
       [](const std::string& name, SchemaRecorder* recorder) {
         static_cast<void>(FindMapRecipe(name, recorder));
         return std::vector<std::string>();
       }},
      {"problem", ConfigKind::kProblem,
       "A camera to place for an arm's motion: `vantage-plan FILE`. Built-in ones: `vantage-plan "
       "--list`.",
       [](const std::string& name, SchemaRecorder* recorder) {
         static_cast<void>(LoadPlacement(name, recorder));
         return std::vector<std::string>();
       }}};
  return kinds;
}

const Kind& KindNamed(const std::string& name) {
  for (const Kind& kind : Kinds()) {
    if (kind.name == name) return kind;
  }
  throw ConfigError("", "kind", "there is none that is called " + name);
}

// Text of a cell: a bar would end it.
std::string Cell(const std::string& text) {
  std::string cell;
  for (const char c : text) {
    if (c == '|') cell += '\\';
    cell += c == '\n' ? ' ' : c;
  }
  return cell;
}

// Keys in the order they are read, but each section's together.
std::vector<SchemaEntry> Grouped(const std::vector<SchemaEntry>& entries) {
  std::vector<SchemaEntry> grouped;
  for (const SchemaEntry& entry : entries) {
    const std::size_t dot = entry.path.rfind('.');
    const std::string section = dot == std::string::npos ? "" : entry.path.substr(0, dot + 1);
    // After the last key of the same section, else after the section's own line.
    const std::string own = section.substr(0, section.find_last_not_of(".[]") + 1);
    auto place = grouped.end();
    while (!section.empty() && place != grouped.begin()) {
      const std::string& path = std::prev(place)->path;
      if (path == own || path.compare(0, section.size(), section) == 0) break;
      --place;
    }
    grouped.insert(section.empty() || place == grouped.begin() ? grouped.end() : place, entry);
  }
  return grouped;
}

void PrintTable(const std::vector<SchemaEntry>& entries, std::ostream* out) {
  *out << "| key | type | unit | range | default | meaning |\n|---|---|---|---|---|---|\n";
  for (const SchemaEntry& entry : Grouped(entries)) {
    *out << "| `" << Cell(entry.path) << "` | " << Cell(entry.type) << " | " << Cell(entry.unit)
         << " | " << Cell(entry.range) << " | "
         << (entry.fallback.empty() ? "" : "`" + Cell(entry.fallback) + "`") << " | "
         << Cell(entry.help) << " |\n";
  }
}

}  // namespace

std::string ConfigReference(const std::vector<std::string>& examples) {
  std::ostringstream page;
  page << "# Reference: configuration files\n\n"
          "Made by `vantage-config reference` from the readers themselves; a test holds this page "
          "to them.\n\n"
          "Files are YAML. SI units and pixels, but for keys that end in `_deg`, `_deg_s` or "
          "`_deg_s2`. No default: "
          "the key is needed where its section is. `[]` stands for each element of a list. Keys "
          "that belong to one "
          "kind of rig, goal or robot are needed for that kind alone. An unknown key is an error: "
          "`file:line: key: "
          "reason`. `vantage-config check KIND FILE` reads a file and starts nothing.\n";
  for (const Kind& kind : Kinds()) {
    SchemaRecorder recorder;
    for (const std::string& name : BuiltInConfigs(kind.built_in)) kind.read(name, &recorder);
    if (kind.built_in == ConfigKind::kScenario) {
      for (const std::string& example : examples) kind.read(example, &recorder);
    }
    page << "\n## " << kind.name << "\n\n" << kind.intro << "\n\n";
    PrintTable(recorder.entries(), &page);
  }
  return page.str();
}

std::vector<std::string> CheckConfig(const std::string& kind, const std::string& name_or_path) {
  return KindNamed(kind).read(name_or_path, nullptr);
}

std::vector<std::string> ListConfigs(const std::string& kind) {
  return BuiltInConfigs(KindNamed(kind).built_in);
}

std::string ShowConfig(const std::string& kind, const std::string& name_or_path) {
  return FindConfigText(KindNamed(kind).built_in, name_or_path).text;
}

const std::vector<std::string>& ConfigKindNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> all;
    for (const Kind& kind : Kinds()) all.emplace_back(kind.name);
    return all;
  }();
  return names;
}

}  // namespace vantage
