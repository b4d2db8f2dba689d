// What built-in scenarios say more than once stays the same in all of them.

#include <sstream>

#include <gtest/gtest.h>

#include "vantage/config/config_text.h"

namespace vantage {
namespace {

// The lines of a key at the top level and of what it holds; comments between keys are left out.
std::string Block(const std::string& scenario, const std::string& key) {
  std::istringstream text(FindConfigText(ConfigKind::kScenario, scenario).text);
  std::string block;
  bool inside = false;
  for (std::string line; std::getline(text, line);) {
    if (line.rfind(key + ":", 0) == 0) {
      inside = true;
    } else if (!line.empty() && line[0] != ' ') {
      inside = false;
    }
    if (inside) block += line + "\n";
  }
  return block;
}

// One cell, and four rigs for its camera.
TEST(ScenarioFiles, ThePumasOfEveryRigAreOneCell) {
  const std::string first = "puma560-bad-view";
  for (const char* key : {"robot", "markers", "features", "goal", "servo", "sim"}) {
    SCOPED_TRACE(key);
    const std::string expected = Block(first, key);
    EXPECT_NE(expected, "");
    for (const char* other : {"puma560-rail", "puma560-gantry", "puma560-two-arms"}) {
      EXPECT_EQ(Block(other, key), expected) << other;
    }
  }
}

}  // namespace
}  // namespace vantage
