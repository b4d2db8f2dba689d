#include "vantage/config/config_text.h"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <unistd.h>

#include "config_error.h"
#include "temporary_folder.h"

namespace vantage {
namespace {

namespace fs = std::filesystem;

std::string ErrorOfReading(const std::string& path) {
  return test::ConfigErrorOf([&] { (void)ReadConfigFile(path); });
}

TEST(ReadConfigFile, GivesTextPathAndFolder) {
  const test::TemporaryFolder folder;
  const std::string path = folder.Write("a.yaml", "a: 1\n");
  const ConfigText text = ReadConfigFile(path);
  EXPECT_EQ(text.text, "a: 1\n");
  EXPECT_EQ(text.source, path);
  EXPECT_EQ(text.folder, folder.path().string());
}

TEST(ReadConfigFile, RefusesAMissingFile) {
  EXPECT_EQ(ErrorOfReading("/nowhere/a.yaml"),
            "/nowhere/a.yaml: cannot be opened: No such file or directory");
}

TEST(ReadConfigFile, RefusesADirectory) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(ErrorOfReading(folder.path().string()), folder.path().string() + ": is a directory");
}

TEST(ReadConfigFile, RefusesAFileItMayNotOpen) {
  if (::geteuid() == 0) GTEST_SKIP() << "root may open any file";
  const test::TemporaryFolder folder;
  const std::string path = folder.Write("a.yaml", "a: 1\n");
  fs::permissions(path, fs::perms::none);
  EXPECT_EQ(ErrorOfReading(path), path + ": cannot be opened: Permission denied");
}

// Opens, but the first read fails whoever asks: address 0 is not mapped.
TEST(ReadConfigFile, RefusesAFileThatCannotBeRead) {
  EXPECT_EQ(ErrorOfReading("/proc/self/mem"), "/proc/self/mem: cannot be read: Input/output error");
}

TEST(ReadConfigFile, RefusesAnEndlessFile) {
  EXPECT_EQ(ErrorOfReading("/dev/zero"), "/dev/zero: is larger than 1048576 bytes");
}

TEST(BuiltInConfigs, NamesTheArmsInOrder) {
  const std::vector<std::string> names = BuiltInConfigs(ConfigKind::kRobot);
  for (const char* name : {"panda", "planar2", "puma3", "puma560", "stanford", "ur5"}) {
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  }
  EXPECT_TRUE(std::is_sorted(names.begin(), names.end()));
}

TEST(FindConfigText, FindsABuiltInFileFromAnywhere) {
  const ConfigText text = FindConfigText(ConfigKind::kRobot, "puma560");
  EXPECT_EQ(text.source, "built-in:robots/puma560.yaml");
  EXPECT_NE(text.text.find("name: puma560\n"), std::string::npos);
  // Byte for byte as in the source tree.
  const ConfigText file = ReadConfigFile(VANTAGE_TEST_DATA "/../../config/robots/puma560.yaml");
  EXPECT_EQ(text.text, file.text);
}

TEST(FindConfigText, PrefersAFileOfThatName) {
  const test::TemporaryFolder folder;
  (void)folder.Write("puma560", "name: mine\n");
  EXPECT_EQ(FindConfigText(ConfigKind::kRobot, "puma560", folder.path().string()).text,
            "name: mine\n");
}

TEST(FindConfigText, IgnoresAFolderOfThatName) {
  const test::TemporaryFolder folder;
  fs::create_directory(folder.path() / "puma560");
  EXPECT_EQ(FindConfigText(ConfigKind::kRobot, "puma560", folder.path().string()).source,
            "built-in:robots/puma560.yaml");
}

TEST(FindConfigText, TakesAnAbsolutePath) {
  const test::TemporaryFolder folder;
  const std::string path = folder.Write("arm.yaml", "name: mine\n");
  EXPECT_EQ(FindConfigText(ConfigKind::kRobot, path, "/elsewhere").text, "name: mine\n");
}

TEST(FindConfigText, ListsTheKnownNames) {
  EXPECT_EQ(test::ConfigErrorOf([] { (void)FindConfigText(ConfigKind::kRobot, "puma56"); }),
            "robot: 'puma56' is neither a file nor built in (built in: panda, planar2, "
            "planar2_housed, puma3, puma3_housed, puma560, puma560_housed, stanford, ur5)");
}

TEST(FindConfigText, SaysWhyAPathCannotBeOpened) {
  EXPECT_EQ(test::ConfigErrorOf([] { (void)FindConfigText(ConfigKind::kRobot, "nowhere/a.yaml"); }),
            "nowhere/a.yaml: cannot be opened: No such file or directory");
}

TEST(FindConfigText, SaysThatAPathIsADirectory) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string();
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)FindConfigText(ConfigKind::kRobot, path); }),
            path + ": is a directory");
}

}  // namespace
}  // namespace vantage
