#include "vantage/messaging/panda.h"

#include <functional>
#include <limits>
#include <mutex>

#include <drake/lcmt_panda_command.hpp>
#include <drake/lcmt_panda_status.hpp>
#include <gtest/gtest.h>

#include "any_port.h"
#include "raw_client.h"
#include "samples.h"
#include "vantage/messaging/clock_offset.h"
#include "vantage/messaging/lcm_link.h"
#include "vantage/messaging/tcp_hub.h"
#include "vantage/runtime/child_process.h"

namespace vantage {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using test::BecomesTrue;
using test::Encoded;

// The numbers are lcm-gen's for Drake's own definitions.
TEST(Panda, TypesAreDrakes) {
  EXPECT_EQ(static_cast<std::uint64_t>(drake::lcmt_panda_status::getHash()), 0xbb48b43a6b578493U);
  EXPECT_EQ(static_cast<std::uint64_t>(drake::lcmt_panda_command::getHash()), 0x79f6a308cf94f449U);
}

TEST(Panda, StatusGoesThereAndBack) {
  const Bytes bytes = Encoded(test::SamplePandaStatus());
  PandaStatus got;
  ASSERT_EQ(Decode(bytes.data(), bytes.size(), &got), Refusal::kNone);
  EXPECT_EQ(got.stamp, test::SamplePandaStatus().stamp);
  EXPECT_EQ(got.q, test::SamplePandaStatus().q);
  EXPECT_EQ(got.qdot, test::SamplePandaStatus().qdot);
  EXPECT_EQ(got.mode, PandaMode::kMove);
  EXPECT_TRUE(got.velocity_control);
  EXPECT_FALSE(got.position_control);
}

TEST(Panda, CommandSaysWhatDrakesDriverReads) {
  PandaCommand command;
  command.stamp = FromMicroseconds(2'000'000);
  command.q = JointVector::LinSpaced(7, 0.0, 0.6);
  command.qdot = JointVector::LinSpaced(7, 1.0, 1.6);
  for (const bool position : {false, true}) {
    command.position_control = position;
    const Bytes bytes = Encoded(command);
    drake::lcmt_panda_command wire;
    ASSERT_GT(wire.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
    EXPECT_EQ(wire.utime, 2'000'000);
    EXPECT_EQ(wire.joint_position[6], 0.6);
    EXPECT_EQ(wire.joint_velocity[0], 1.0);
    EXPECT_EQ(wire.joint_torque, std::vector<double>(7));
    EXPECT_EQ(wire.position_control_expected, position ? 1 : 0);
    EXPECT_EQ(wire.velocity_control_expected, position ? 0 : 1);
    EXPECT_EQ(wire.torque_control_expected, 0);
  }
}

TEST(Panda, RefusalsOneByOne) {
  using Wire = drake::lcmt_panda_status;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    const Bytes bytes = Encoded(test::SamplePandaStatus());
    Wire wire;
    EXPECT_GT(wire.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
    change(&wire);
    Bytes out(static_cast<std::size_t>(wire.getEncodedSize()));
    wire.encode(out.data(), 0, static_cast<int>(out.size()));
    PandaStatus status;
    return Decode(out.data(), out.size(), &status);
  };
  EXPECT_EQ(changed([](Wire*) {}), Refusal::kNone);
  EXPECT_EQ(changed([](Wire* w) { w->joint_position[3] = std::nan(""); }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* w) { w->joint_velocity[0] = 1e9; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* w) { w->robot_mode = 7; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* w) { w->utime = -1; }), Refusal::kBadTime);
  EXPECT_EQ(changed([](Wire* w) {
              w->num_joints = 0;
              for (auto* values :
                   {&w->joint_position, &w->joint_position_desired, &w->joint_velocity,
                    &w->joint_velocity_desired, &w->joint_acceleration_desired, &w->joint_torque,
                    &w->joint_torque_desired, &w->joint_torque_external}) {
                values->clear();
              }
            }),
            Refusal::kLimit);
}

// A driver whose clock stands elsewhere and whose messages are 2 ms on their way, some much longer.
TEST(ClockOffset, TranslatesToOurClockByTheQuickestMessage) {
  ClockOffset clock;
  const Duration other = seconds(-1'000'000);
  Time last{};
  for (int i = 0; i < 1000; ++i) {
    const Time sent = Time(seconds(2'000'000)) + milliseconds(10 * i);
    const Time arrival = sent + milliseconds(i % 7 == 3 ? 2 : 2 + i % 5);
    const Time translated = clock.Translate(sent + other, arrival);
    EXPECT_LE(translated, arrival);
    EXPECT_GT(translated, last);  // In order, as they were sent.
    if (i > 10) {
      EXPECT_EQ(translated - sent, Duration(milliseconds(2)));
    }
    last = translated;
  }
}

// Clocks drift; an offset that was least an hour ago says nothing now.
TEST(ClockOffset, ForgetsWhatIsLongAgo) {
  ClockOffset clock(seconds(10));
  Time arrival = Time(seconds(100));
  for (int i = 0; i < 10'000; ++i) {
    arrival += milliseconds(10);
    // The sender's clock falls behind by 100 us a second.
    const Time sent = arrival - milliseconds(1) - Duration(1000 * i);
    const Time translated = clock.Translate(sent, arrival);
    EXPECT_LE(arrival - translated, Duration(milliseconds(3)));
  }
}

// What was least before a long pause is as old as the pause: the sender may be another by now.
TEST(ClockOffset, BeginsAnewAfterAGapLongerThanTheWindow) {
  ClockOffset clock(seconds(10));
  const Time arrival = Time(seconds(100));
  EXPECT_EQ(clock.Translate(arrival - milliseconds(1), arrival), arrival);
  const Time later = arrival + seconds(21);
  EXPECT_EQ(clock.Translate(later - seconds(5), later), later);
  const Time next = later + milliseconds(10);
  EXPECT_EQ(clock.Translate(next - seconds(5), next), next);
}

TEST(ClockOffset, KeepsTheWindowBeforeAcrossAShorterGap) {
  ClockOffset clock(seconds(10));
  const Time arrival = Time(seconds(100));
  EXPECT_EQ(clock.Translate(arrival - milliseconds(1), arrival), arrival);
  const Time later = arrival + seconds(19);
  EXPECT_EQ(clock.Translate(later - milliseconds(3), later), later - milliseconds(2));
}

// A driver that was started anew at once, with a clock that begins at zero.
TEST(ClockOffset, BeginsAnewWhenTheSendersClockGoesBack) {
  ClockOffset clock(seconds(10));
  const Time arrival = Time(seconds(100));
  EXPECT_EQ(clock.Translate(Time(seconds(50)), arrival), arrival);
  const Time later = arrival + seconds(2);
  EXPECT_EQ(clock.Translate(Time(milliseconds(1)), later), later);
}

TEST(ClockOffset, TakesReorderedMessagesForTheSameClock) {
  ClockOffset clock(seconds(10));
  const Time arrival = Time(seconds(100));
  EXPECT_EQ(clock.Translate(arrival - milliseconds(1), arrival), arrival);
  const Time later = arrival + milliseconds(1);
  EXPECT_EQ(clock.Translate(arrival - milliseconds(11), later), arrival - milliseconds(10));
}

TEST(PandaBridge, PassesStatesAndCommandsAndStandsWhenTheServoIsGone) {
  const TcpHub hub(test::AnyPort());
  std::mutex mutex;
  JointState state;
  PandaCommand command;
  std::atomic<int> states{0}, commands{0};
  LcmLink link({hub.url(), ""});
  link.Subscribe<JointState>(kJointStateChannel, [&](const JointState& v) {
    const std::lock_guard lock(mutex);
    state = v;
    ++states;
  });
  link.Subscribe<PandaCommand>(kPandaCommandChannel, [&](const PandaCommand& v) {
    const std::lock_guard lock(mutex);
    command = v;
    ++commands;
  });
  link.Start();
  ChildOptions options;
  options.arguments = {VANTAGE_PANDA_BRIDGE};
  options.environment["LCM_DEFAULT_URL"] = hub.url();
  options.output = "/dev/null";
  ChildProcess bridge(options);

  // A driver with a clock of its own.
  PandaStatus status = test::SamplePandaStatus();
  ASSERT_TRUE(BecomesTrue([&] {
    status.stamp += milliseconds(1);
    link.Publish(kPandaStatusChannel, status);
    return states > 0;
  }));
  {
    const std::lock_guard lock(mutex);
    EXPECT_EQ(state.q, status.q);
    EXPECT_EQ(state.qdot, status.qdot);
    EXPECT_LT(Clock::now() - state.stamp, Duration(seconds(20)));  // On our clock.
  }
  JointCommand wanted = test::SampleJointCommand();
  ASSERT_TRUE(BecomesTrue([&] {
    wanted.stamp = Clock::now();
    link.Publish(kJointCommandChannel, wanted);
    return commands > 0;
  }));
  // The servo says no more: a command to stand follows.
  ASSERT_TRUE(BecomesTrue([&] {
    const std::lock_guard lock(mutex);
    return command.qdot.isZero(0.0) && command.q == status.q;
  }));
  {
    const std::lock_guard lock(mutex);
    EXPECT_FALSE(command.position_control);
  }
  EXPECT_TRUE(bridge.Terminate(seconds(5)).success());
}

}  // namespace
}  // namespace vantage
