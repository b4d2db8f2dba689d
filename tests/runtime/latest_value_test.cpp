#include "vantage/runtime/latest_value.h"

#include <array>
#include <thread>

#include <gtest/gtest.h>

#include "allocation_guard.h"

namespace vantage {
namespace {

TEST(LatestValue, IsEmptyAtFirst) {
  LatestValue<int> mailbox;
  int value = 7;
  EXPECT_FALSE(mailbox.Take(&value));
  EXPECT_EQ(value, 7);
}

TEST(LatestValue, GivesEachValueOnce) {
  LatestValue<int> mailbox;
  mailbox.Publish(3);
  int value = 0;
  ASSERT_TRUE(mailbox.Take(&value));
  EXPECT_EQ(value, 3);
  EXPECT_FALSE(mailbox.Take(&value));
}

TEST(LatestValue, NewerReplacesOlderAndCounts) {
  LatestValue<int> mailbox;
  for (int i = 1; i <= 10; ++i) mailbox.Publish(i);
  int value = 0;
  ASSERT_TRUE(mailbox.Take(&value));
  EXPECT_EQ(value, 10);
  EXPECT_EQ(mailbox.published(), 10);
  EXPECT_EQ(mailbox.dropped(), 9);
}

TEST(LatestValue, DoesNotCountTakenValuesAsDropped) {
  LatestValue<int> mailbox;
  int value = 0;
  for (int i = 0; i < 5; ++i) {
    mailbox.Publish(i);
    ASSERT_TRUE(mailbox.Take(&value));
  }
  EXPECT_EQ(mailbox.dropped(), 0);
}

TEST(LatestValue, DoesNotAllocate) {
  if (!test::AllocationGuard::kSupported) GTEST_SKIP();
  LatestValue<std::array<double, 64>> mailbox;
  std::array<double, 64> value{};
  const test::AllocationGuard guard;
  mailbox.Publish(value);
  EXPECT_TRUE(mailbox.Take(&value));
  EXPECT_EQ(guard.count(), 0U);
}

// A writer and a reader at full speed: what arrives is never torn, never older than what came before,
// and everything published is either taken or counted as dropped. Run under ThreadSanitizer too.
TEST(LatestValue, SurvivesTwoThreads) {
  constexpr long kValues = 200'000;
  using Block = std::array<long, 32>;
  LatestValue<Block> mailbox;
  std::thread writer([&] {
    Block block{};
    for (long i = 1; i <= kValues; ++i) {
      block.fill(i);
      mailbox.Publish(block);
    }
  });
  long last = 0;
  long taken = 0;
  bool torn = false;
  bool backwards = false;
  Block block{};
  while (last < kValues) {
    if (!mailbox.Take(&block)) continue;
    ++taken;
    for (const long entry : block) torn = torn || entry != block[0];
    backwards = backwards || block[0] <= last;
    last = block[0];
  }
  writer.join();
  EXPECT_FALSE(torn);
  EXPECT_FALSE(backwards);
  EXPECT_EQ(mailbox.published(), kValues);
  EXPECT_EQ(taken + mailbox.dropped(), kValues);
}

}  // namespace
}  // namespace vantage
