#include "bench_table.h"

#include <gtest/gtest.h>

#include "read_file.h"
#include "sim/suite/quantile.h"
#include "temporary_folder.h"

namespace vantage {
namespace {

// Values from Wilson's formula, evaluated by hand.
TEST(BenchTable, WilsonInterval) {
  const auto [low, high] = WilsonInterval(8, 10);
  EXPECT_NEAR(low, 0.4902, 1e-4);
  EXPECT_NEAR(high, 0.9433, 1e-4);
  EXPECT_NEAR(WilsonInterval(200, 200).first, 0.9812, 1e-4);
  EXPECT_DOUBLE_EQ(WilsonInterval(200, 200).second, 1.0);
  EXPECT_DOUBLE_EQ(WilsonInterval(0, 0).first, 0.0);
  EXPECT_DOUBLE_EQ(WilsonInterval(0, 0).second, 1.0);
}

TEST(BenchTable, Quantile) {
  EXPECT_DOUBLE_EQ(sim::Quantile({}, 0.5), 0.0);
  EXPECT_DOUBLE_EQ(sim::Quantile({3.0}, 0.95), 3.0);
  EXPECT_DOUBLE_EQ(sim::Quantile({4.0, 1.0, 3.0, 2.0}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(sim::Quantile({4.0, 1.0, 3.0, 2.0}, 1.0), 4.0);
}

BenchRow Row() {
  BenchRow row{"S1/planar2", "active", 5, {}};
  sim::TaskResult good;
  good.success = good.converged = true;
  good.duration = 4.0;
  good.true_error_mm = 0.5;
  good.end = "converged";
  sim::TaskResult bad;
  bad.duration = 60.0;
  bad.true_error_mm = 30.0;
  bad.limit_violations = 2;
  bad.end = "HOLDING TOO_FEW_FEATURES";
  row.results = {good, bad};
  return row;
}

TEST(BenchTable, SaysWhatHappened) {
  const std::string table = BenchTable({Row()});
  EXPECT_NE(table.find("S1/planar2"), std::string::npos);
  EXPECT_NE(table.find(" 50.0%"), std::string::npos);
}

TEST(BenchTable, JsonNamesEveryFailureBySeed) {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "bench.json").string();
  WriteBenchJson({Row()}, "S1", true, path);
  const std::string text = test::ReadFile(path);
  EXPECT_NE(text.find("\"success\": 0.5"), std::string::npos) << text;
  EXPECT_NE(text.find("\"seed\": 6"), std::string::npos) << text;
  EXPECT_NE(text.find("\"limit_violations\": 2"), std::string::npos) << text;
}

}  // namespace
}  // namespace vantage
