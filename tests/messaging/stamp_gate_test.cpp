#include "vantage/messaging/stamp_gate.h"

#include <gtest/gtest.h>

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

const Time kNow = FromMicroseconds(1'000'000'000);

TEST(StampGate, LetsNewerStampsPass) {
  StampGate gate;
  EXPECT_EQ(gate.Check(kNow - milliseconds(500), kNow), Refusal::kNone);
  EXPECT_EQ(gate.Check(kNow - milliseconds(499), kNow), Refusal::kNone);
}

TEST(StampGate, RefusesDuplicatesAndReorderedStamps) {
  StampGate gate;
  ASSERT_EQ(gate.Check(kNow, kNow), Refusal::kNone);
  EXPECT_EQ(gate.Check(kNow, kNow + milliseconds(1)), Refusal::kReordered);
  EXPECT_EQ(gate.Check(kNow - milliseconds(1), kNow + milliseconds(2)), Refusal::kReordered);
  EXPECT_EQ(gate.Check(kNow + milliseconds(1), kNow + milliseconds(3)), Refusal::kNone);
}

TEST(StampGate, RefusesTheFutureBeyondItsTolerance) {
  StampGate gate;
  EXPECT_EQ(gate.Check(kNow + milliseconds(101), kNow), Refusal::kFuture);
  EXPECT_EQ(gate.Check(kNow + milliseconds(100), kNow), Refusal::kNone);
}

// A refused stamp from the future must not make all honest ones look old.
TEST(StampGate, ForgetsWhatItRefused) {
  StampGate gate;
  ASSERT_EQ(gate.Check(kNow + seconds(100), kNow), Refusal::kFuture);
  EXPECT_EQ(gate.Check(kNow, kNow), Refusal::kNone);
}

TEST(StampGate, TakesARestartedSenderAfterAWhile) {
  StampGate gate;
  ASSERT_EQ(gate.Check(kNow, kNow), Refusal::kNone);
  const Time restarted = FromMicroseconds(5);
  EXPECT_EQ(gate.Check(restarted, kNow + seconds(1)), Refusal::kReordered);
  EXPECT_EQ(gate.Check(restarted, kNow + milliseconds(1001)), Refusal::kNone);
  EXPECT_EQ(gate.Check(restarted + milliseconds(1), kNow + milliseconds(1002)), Refusal::kNone);
}

TEST(StampGate, LooksAwayWhenToldTo) {
  StampGateOptions options;
  options.in_order = false;
  options.not_from_future = false;
  StampGate gate(options);
  EXPECT_EQ(gate.Check(kNow + seconds(100), kNow), Refusal::kNone);
  EXPECT_EQ(gate.Check(kNow, kNow), Refusal::kNone);
}

}  // namespace
}  // namespace vantage
