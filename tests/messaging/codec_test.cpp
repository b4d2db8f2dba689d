#include "vantage/messaging/codec.h"

#include <functional>
#include <limits>

#include <bot_core/image_t.hpp>
#include <bot_core/rigid_transform_t.hpp>
#include <gtest/gtest.h>
#include <vantage_lcm/layouts.h>
#include <vantage_msgs/image_features_t.hpp>
#include <vantage_msgs/joint_command_t.hpp>
#include <vantage_msgs/joint_state_t.hpp>
#include <vantage_msgs/observability_t.hpp>
#include <vantage_msgs/servo_inputs_t.hpp>
#include <vantage_msgs/servo_setup_t.hpp>
#include <vantage_msgs/servo_status_t.hpp>
#include <vantage_msgs/sim_truth_t.hpp>

#include "samples.h"

namespace vantage {
namespace {

using test::Encoded;
using vantage_msgs::image_features_t;
using vantage_msgs::joint_command_t;
using vantage_msgs::joint_state_t;
using vantage_msgs::observability_t;
using vantage_msgs::servo_inputs_t;
using vantage_msgs::servo_setup_t;
using vantage_msgs::servo_status_t;
using vantage_msgs::sim_truth_t;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

template <typename Value>
Value RoundTrip(const Value& value) {
  const Bytes bytes = Encoded(value);
  Value decoded;
  EXPECT_EQ(Decode(bytes.data(), bytes.size(), &decoded), Refusal::kNone);
  return decoded;
}

// What becomes of a good message after one change to its wire form.
template <typename Wire, typename Value>
Refusal Changed(const Value& sample, const std::function<void(Wire*)>& change) {
  const Bytes bytes = Encoded(sample);
  Wire wire;
  EXPECT_EQ(wire.decode(bytes.data(), 0, static_cast<int>(bytes.size())),
            static_cast<int>(bytes.size()));
  change(&wire);
  Bytes changed(static_cast<std::size_t>(wire.getEncodedSize()));
  wire.encode(changed.data(), 0, static_cast<int>(changed.size()));
  Value decoded;
  return Decode(changed.data(), changed.size(), &decoded);
}

// What becomes of a good message after one change to its bytes.
template <typename Value>
Refusal ChangedBytes(const Value& sample, const std::function<void(Bytes*)>& change) {
  Bytes bytes = Encoded(sample);
  change(&bytes);
  Value decoded;
  return Decode(bytes.data(), bytes.size(), &decoded);
}

// --- Layout tables -------------------------------------------------------------------------------

// A table that differed from its .lcm file in one name, type or dimension would have another hash.
TEST(Layouts, HaveTheFingerprintsOfTheGeneratedClasses) {
  const auto same = [](const MessageLayout* layout, std::int64_t hash) {
    EXPECT_EQ(static_cast<std::int64_t>(Fingerprint(*layout)), hash) << layout->name;
  };
  same(kLayoutOf<joint_state_t>, joint_state_t::getHash());
  same(kLayoutOf<joint_command_t>, joint_command_t::getHash());
  same(kLayoutOf<image_features_t>, image_features_t::getHash());
  same(kLayoutOf<observability_t>, observability_t::getHash());
  same(kLayoutOf<servo_status_t>, servo_status_t::getHash());
  same(kLayoutOf<sim_truth_t>, sim_truth_t::getHash());
  same(kLayoutOf<servo_inputs_t>, servo_inputs_t::getHash());
  same(kLayoutOf<servo_setup_t>, servo_setup_t::getHash());
  same(kLayoutOf<bot_core::rigid_transform_t>, bot_core::rigid_transform_t::getHash());
  same(kLayoutOf<bot_core::image_metadata_t>, bot_core::image_metadata_t::getHash());
  same(kLayoutOf<bot_core::image_t>, bot_core::image_t::getHash());
}

// The numbers are lcm-gen's for libbot's own definitions (ripl/libbot2, bot2-core/lcmtypes).
TEST(Layouts, BotCoreTypesAreLibbots) {
  EXPECT_EQ(static_cast<std::uint64_t>(bot_core::rigid_transform_t::getHash()),
            0xea9ffbf2acc5c5aeU);
  EXPECT_EQ(static_cast<std::uint64_t>(bot_core::image_metadata_t::getHash()), 0x9a4b634d0577fb8eU);
  EXPECT_EQ(static_cast<std::uint64_t>(bot_core::image_t::getHash()), 0x14739ffe13d5f5f0U);
}

// --- Round trips ---------------------------------------------------------------------------------

TEST(RoundTrip, JointState) {
  const JointState sent = test::SampleJointState();
  const JointState got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.q, sent.q);
  EXPECT_EQ(got.qdot, sent.qdot);
}

TEST(RoundTrip, JointCommand) {
  const JointCommand sent = test::SampleJointCommand();
  const JointCommand got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.q, sent.q);
  EXPECT_EQ(got.qdot, sent.qdot);
}

TEST(RoundTrip, CameraPose) {
  const CameraPose sent = test::SampleCameraPose();
  const CameraPose got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_TRUE(got.X_WC.isApprox(sent.X_WC, 1e-15));
}

TEST(RoundTrip, ImageFeatures) {
  const ImageFeatures sent = test::SampleImageFeatures();
  const ImageFeatures got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.exposure, sent.exposure);
  EXPECT_TRUE(got.X_WC.isApprox(sent.X_WC, 1e-15));
  ASSERT_EQ(got.count, sent.count);
  for (int i = 0; i < sent.count; ++i) {
    EXPECT_EQ(got.markers[i].id, sent.markers[i].id);
    EXPECT_EQ(got.markers[i].pixel, sent.markers[i].pixel);
    EXPECT_EQ(got.markers[i].valid, sent.markers[i].valid);
  }
}

TEST(RoundTrip, ImageFeaturesWithoutMarkers) {
  ImageFeatures sent = test::SampleImageFeatures();
  sent.count = 0;
  EXPECT_EQ(RoundTrip(sent).count, 0);
}

TEST(RoundTrip, Observability) {
  const ObservabilityReport sent = test::SampleObservability();
  const ObservabilityReport got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.seq, sent.seq);
  EXPECT_EQ(got.k, sent.k);
  EXPECT_EQ(got.m, sent.m);
  EXPECT_EQ(got.n, sent.n);
  EXPECT_EQ(got.w_v, sent.w_v);
  EXPECT_EQ(got.w_r, sent.w_r);
  EXPECT_EQ(got.w_c, sent.w_c);
  EXPECT_EQ(got.composite.sigma, sent.composite.sigma);
  EXPECT_EQ(got.composite.w, sent.composite.w);
  EXPECT_EQ(got.composite.log_w, sent.composite.log_w);
  EXPECT_EQ(got.composite.sigma_min, sent.composite.sigma_min);
  EXPECT_EQ(got.composite.condition, sent.composite.condition);
  EXPECT_EQ(got.composite.rank, sent.composite.rank);
  EXPECT_EQ(got.sigma_min_v, sent.sigma_min_v);
  EXPECT_EQ(got.sigma_min_r, sent.sigma_min_r);
  EXPECT_EQ(got.axes, sent.axes);
  EXPECT_EQ(got.mm_per_px, sent.mm_per_px);
  EXPECT_EQ(got.threshold, sent.threshold);
  EXPECT_EQ(got.trigger_value, sent.trigger_value);
  EXPECT_EQ(got.trigger_measure, sent.trigger_measure);
  EXPECT_EQ(got.triggered, sent.triggered);
  EXPECT_EQ(got.cause, sent.cause);
  EXPECT_EQ(got.active_state, sent.active_state);
  EXPECT_EQ(got.active_reason, sent.active_reason);
  EXPECT_EQ(got.camera_moves, sent.camera_moves);
}

TEST(RoundTrip, ObservabilityOfASingularArm) {
  ObservabilityReport sent = test::SampleObservability();
  sent.w_c = sent.composite.w = 0.0;
  sent.composite.log_w = -kInfinity;
  sent.composite.condition = kInfinity;
  sent.mm_per_px = kInfinity;
  sent.axes.resize(0, 0);
  const ObservabilityReport got = RoundTrip(sent);
  EXPECT_EQ(got.composite.log_w, -kInfinity);
  EXPECT_EQ(got.composite.condition, kInfinity);
  EXPECT_EQ(got.mm_per_px, kInfinity);
  EXPECT_EQ(got.axes.size(), 0);
}

TEST(RoundTrip, ObservabilityBeforeTheFirstImage) {
  ObservabilityReport sent;
  sent.stamp = FromMicroseconds(1);
  EXPECT_EQ(RoundTrip(sent).composite.sigma.size(), 0);
}

TEST(RoundTrip, ServoStatus) {
  const ServoStatus sent = test::SampleServoStatus();
  const ServoStatus got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.seq, sent.seq);
  EXPECT_EQ(got.state, sent.state);
  EXPECT_EQ(got.reason, sent.reason);
  EXPECT_EQ(got.error_px, sent.error_px);
  EXPECT_EQ(got.markers_seen, sent.markers_seen);
  EXPECT_EQ(got.markers_needed, sent.markers_needed);
  EXPECT_EQ(got.loop_time_us, sent.loop_time_us);
  EXPECT_EQ(got.loop_time_max_us, sent.loop_time_max_us);
  EXPECT_EQ(got.loop_time_p50_us, sent.loop_time_p50_us);
  EXPECT_EQ(got.loop_time_p99_us, sent.loop_time_p99_us);
  EXPECT_EQ(got.loop_time_p999_us, sent.loop_time_p999_us);
  EXPECT_EQ(got.lateness_p999_us, sent.lateness_p999_us);
  EXPECT_EQ(got.lateness_max_us, sent.lateness_max_us);
  EXPECT_EQ(got.deadline_misses, sent.deadline_misses);
  EXPECT_EQ(got.refused_messages, sent.refused_messages);
  EXPECT_EQ(got.refused_by, sent.refused_by);
  EXPECT_EQ(got.dropped_messages, sent.dropped_messages);
  EXPECT_EQ(got.stops, sent.stops);
  EXPECT_EQ(got.stops_by, sent.stops_by);
  EXPECT_EQ(got.calibration.position, sent.calibration.position);
  EXPECT_EQ(got.calibration.rotation, sent.calibration.rotation);
  EXPECT_EQ(got.calibration.focal, sent.calibration.focal);
  EXPECT_EQ(got.calibration.revolute, sent.calibration.revolute);
  EXPECT_EQ(got.calibration.prismatic, sent.calibration.prismatic);
}

TEST(RoundTrip, GroundTruth) {
  const GroundTruth sent = test::SampleGroundTruth();
  const GroundTruth got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.q, sent.q);
  EXPECT_EQ(got.worst_error, sent.worst_error);
  EXPECT_EQ(got.rms_error, sent.rms_error);
  EXPECT_EQ(got.limit_violations, sent.limit_violations);
}

TEST(RoundTrip, CameraImage) {
  for (const PixelFormat format : {PixelFormat::kGray, PixelFormat::kRgb, PixelFormat::kJpeg}) {
    CameraImage sent = test::SampleCameraImage();
    sent.format = format;
    if (format == PixelFormat::kRgb) sent.width = 2;
    if (format == PixelFormat::kJpeg) sent.row_stride = 0;
    const CameraImage got = RoundTrip(sent);
    EXPECT_EQ(got.stamp, sent.stamp);
    EXPECT_EQ(got.width, sent.width);
    EXPECT_EQ(got.height, sent.height);
    EXPECT_EQ(got.row_stride, sent.row_stride);
    EXPECT_EQ(got.format, sent.format);
    EXPECT_EQ(got.data, sent.data);
  }
}

// To the nanosecond and the last bit: a replay starts from it.
TEST(RoundTrip, ServoRecordIsExact) {
  const ServoRecord sent = test::SampleServoRecord();
  const ServoRecord got = RoundTrip(sent);
  EXPECT_EQ(got.start, sent.start);
  EXPECT_EQ(got.lost, sent.lost);
  ASSERT_EQ(got.periods.size(), 2U);
  EXPECT_FALSE(got.periods[0].inputs.has_joints);
  EXPECT_FALSE(got.periods[0].inputs.has_pose);
  EXPECT_FALSE(got.periods[0].inputs.has_features);
  EXPECT_TRUE(got.periods[0].inputs.enabled);
  const PeriodRecord& period = got.periods[1];
  EXPECT_EQ(period.seq, 42);
  EXPECT_EQ(period.camera_step, 7);
  EXPECT_EQ(period.lateness, Duration(12'345));
  EXPECT_EQ(period.execution, Duration(6'789));
  const PeriodInputs& inputs = period.inputs;
  const PeriodInputs& wanted = sent.periods[1].inputs;
  EXPECT_EQ(inputs.now, wanted.now);
  EXPECT_FALSE(inputs.enabled);
  EXPECT_EQ(inputs.joints.stamp, wanted.joints.stamp);
  EXPECT_EQ(inputs.joints.q, wanted.joints.q);
  EXPECT_EQ(inputs.joints.qdot, wanted.joints.qdot);
  EXPECT_EQ(inputs.pose.stamp, wanted.pose.stamp);
  EXPECT_EQ(inputs.pose.X_WC.matrix(), wanted.pose.X_WC.matrix());
  EXPECT_EQ(inputs.features.stamp, wanted.features.stamp);
  EXPECT_EQ(inputs.features.exposure, wanted.features.exposure);
  EXPECT_EQ(inputs.features.X_WC.matrix(), wanted.features.X_WC.matrix());
  ASSERT_EQ(inputs.features.count, wanted.features.count);
  for (int i = 0; i < wanted.features.count; ++i) {
    EXPECT_EQ(inputs.features.markers[i].id, wanted.features.markers[i].id);
    EXPECT_EQ(inputs.features.markers[i].pixel, wanted.features.markers[i].pixel);
    EXPECT_EQ(inputs.features.markers[i].valid, wanted.features.markers[i].valid);
  }
  ASSERT_EQ(got.camera_steps.size(), 1U);
  EXPECT_EQ(got.camera_steps[0].step, 7);
  EXPECT_EQ(got.camera_steps[0].snapshot, sent.camera_steps[0].snapshot);
  EXPECT_EQ(got.camera_steps[0].command, sent.camera_steps[0].command);
}

TEST(RoundTrip, ServoSetup) {
  const ServoSetup sent = test::SampleServoSetup();
  const ServoSetup got = RoundTrip(sent);
  EXPECT_EQ(got.stamp, sent.stamp);
  EXPECT_EQ(got.start, sent.start);
  EXPECT_EQ(got.program, sent.program);
  EXPECT_EQ(got.scenario_name, sent.scenario_name);
  EXPECT_EQ(got.scenario, sent.scenario);
  EXPECT_FALSE(got.active_camera);
}

TEST(Encode, WritesTheNamesForPeople) {
  EXPECT_EQ(Changed<servo_status_t>(test::SampleServoStatus(),
                                    [](servo_status_t* m) {
                                      EXPECT_EQ(m->state_name, "HOLDING");
                                      EXPECT_EQ(m->reason_name, "STALE_FEATURES");
                                    }),
            Refusal::kNone);
  EXPECT_EQ(Changed<observability_t>(test::SampleObservability(),
                                     [](observability_t* m) {
                                       EXPECT_EQ(m->cause_name, "VIEW");
                                       EXPECT_EQ(m->active_state_name, "MOVING");
                                       EXPECT_EQ(m->active_reason_name, "MARKER_AT_RISK");
                                       EXPECT_NEAR(m->geometric_mean, 200.0, 1e-9);
                                     }),
            Refusal::kNone);
}

// --- Refusals by the bytes -----------------------------------------------------------------------

template <typename Value>
Value Sample();
template <>
JointState Sample() {
  return test::SampleJointState();
}
template <>
JointCommand Sample() {
  return test::SampleJointCommand();
}
template <>
CameraPose Sample() {
  return test::SampleCameraPose();
}
template <>
ImageFeatures Sample() {
  return test::SampleImageFeatures();
}
template <>
ObservabilityReport Sample() {
  return test::SampleObservability();
}
template <>
ServoStatus Sample() {
  return test::SampleServoStatus();
}
template <>
GroundTruth Sample() {
  return test::SampleGroundTruth();
}
template <>
CameraImage Sample() {
  return test::SampleCameraImage();
}

template <>
ServoRecord Sample() {
  return test::SampleServoRecord();
}
template <>
ServoSetup Sample() {
  return test::SampleServoSetup();
}

template <typename Value>
class EveryCodec : public ::testing::Test {};
using AllValues =
    ::testing::Types<JointState, JointCommand, CameraPose, ImageFeatures, ObservabilityReport,
                     ServoStatus, GroundTruth, CameraImage, ServoRecord, ServoSetup>;
TYPED_TEST_SUITE(EveryCodec, AllValues);

TYPED_TEST(EveryCodec, RefusesNothingAtAll) {
  TypeParam value;
  EXPECT_EQ(Decode(nullptr, 0, &value), Refusal::kTruncated);
}

TYPED_TEST(EveryCodec, RefusesAnotherFingerprint) {
  EXPECT_EQ(ChangedBytes(Sample<TypeParam>(), [](Bytes* b) { (*b)[7] ^= 1; }),
            Refusal::kFingerprint);
}

TYPED_TEST(EveryCodec, RefusesOneByteTooMany) {
  EXPECT_EQ(ChangedBytes(Sample<TypeParam>(), [](Bytes* b) { b->push_back(0); }),
            Refusal::kTrailingBytes);
}

TYPED_TEST(EveryCodec, RefusesEveryTruncation) {
  const std::size_t size = Encoded(Sample<TypeParam>()).size();
  for (std::size_t length = 0; length < size; ++length) {
    const Refusal refusal = ChangedBytes(Sample<TypeParam>(), [=](Bytes* b) { b->resize(length); });
    // Cut inside an array or a string, it is their count that does not fit.
    EXPECT_TRUE(refusal == Refusal::kTruncated || refusal == Refusal::kBadCount ||
                refusal == Refusal::kBadString)
        << length << " of " << size << " bytes: " << Name(refusal);
  }
}

TYPED_TEST(EveryCodec, RefusesWhatIsTooLarge) {
  EXPECT_EQ(ChangedBytes(Sample<TypeParam>(), [](Bytes* b) { b->resize(kMaxImageBytes + 1); }),
            Refusal::kTooLarge);
}

TYPED_TEST(EveryCodec, LeavesTheValueAloneWhenItRefuses) {
  Bytes bytes = Encoded(Sample<TypeParam>());
  bytes.push_back(0);
  TypeParam value = Sample<TypeParam>();
  value.stamp = FromMicroseconds(42);
  EXPECT_NE(Decode(bytes.data(), bytes.size(), &value), Refusal::kNone);
  EXPECT_EQ(value.stamp, FromMicroseconds(42));
}

TEST(Guard, RefusesStatesLargerThanAnyState) {
  EXPECT_EQ(ChangedBytes(Sample<JointState>(), [](Bytes* b) { b->resize(kMaxStateBytes + 1); }),
            Refusal::kTooLarge);
}

constexpr std::size_t kNumJointsAt = 16;  // Fingerprint, utime.

void PutInt32(Bytes* bytes, std::size_t at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) {
    (*bytes)[at + i] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
  }
}

// The counts that make lcm-gen's own decoder allocate gigabytes, throw or read out of bounds.
TEST(Guard, RefusesHostileCounts) {
  for (const std::uint32_t count : {0x7fffffffU, 0x80000000U, 0xffffffffU, 0x10000000U, 7U, 65U}) {
    EXPECT_EQ(
        ChangedBytes(Sample<JointState>(), [=](Bytes* b) { PutInt32(b, kNumJointsAt, count); }),
        Refusal::kBadCount)
        << std::hex << count;
  }
}

// Rows that take no bytes still cost memory: axes[2'000'000'000][0].
TEST(Guard, RefusesManyEmptyRows) {
  ObservabilityReport sample = Sample<ObservabilityReport>();
  sample.k = 0;
  sample.axes.resize(0, 0);
  const Bytes bytes = Encoded(sample);
  // num_axes lies behind the fingerprint, five 8-byte and three 4-byte fields ... and the 3 sigmas.
  const std::size_t at = 8 + 2 * 8 + 3 * 4 + 9 * 8 + 4 + 4 + 3 * 8;
  ASSERT_EQ(bytes[at + 3], 0);
  for (const std::uint32_t rows : {0x77359400U, 1000U}) {
    EXPECT_EQ(ChangedBytes(sample, [=](Bytes* b) { PutInt32(b, at, rows); }), Refusal::kBadCount);
  }
}

TEST(Guard, RefusesStringsWithoutEnd) {
  const std::size_t at = 8 + 8 + 8 + 4;  // state_name: its length, then "HOLDING\0".
  ASSERT_EQ(Encoded(Sample<ServoStatus>())[at + 4], 'H');
  EXPECT_EQ(ChangedBytes(Sample<ServoStatus>(), [=](Bytes* b) { (*b)[at + 4 + 7] = '!'; }),
            Refusal::kBadString);
  // Nor with two of them.
  EXPECT_EQ(ChangedBytes(Sample<ServoStatus>(), [=](Bytes* b) { (*b)[at + 4 + 3] = 0; }),
            Refusal::kBadString);
  for (const std::uint32_t length : {0U, 0xffffffffU, 0x7fffffffU, 0x80000000U}) {
    EXPECT_EQ(ChangedBytes(Sample<ServoStatus>(), [=](Bytes* b) { PutInt32(b, at, length); }),
              Refusal::kBadString)
        << length;
  }
}

TEST(Guard, ChecksNestedTypes) {
  const auto add_metadata = [](bot_core::image_t* m) {
    m->nmetadata = 2;
    m->metadata.resize(2);
    m->metadata[0].key = "lens";
    m->metadata[0].n = 3;
    m->metadata[0].value = {1, 2, 3};
    m->metadata[1].key = "";
    m->metadata[1].n = 0;
  };
  EXPECT_EQ(Changed<bot_core::image_t>(Sample<CameraImage>(), add_metadata), Refusal::kNone);

  bot_core::image_t wire;
  const Bytes plain = Encoded(Sample<CameraImage>());
  ASSERT_GT(wire.decode(plain.data(), 0, static_cast<int>(plain.size())), 0);
  add_metadata(&wire);
  Bytes bytes(static_cast<std::size_t>(wire.getEncodedSize()));
  wire.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  const std::size_t nmetadata_at = 8 + 8 + 5 * 4 + 32;
  const auto refusal_with = [&](std::size_t at, std::uint32_t value) {
    Bytes changed = bytes;
    PutInt32(&changed, at, value);
    CameraImage image;
    return Decode(changed.data(), changed.size(), &image);
  };
  EXPECT_EQ(refusal_with(nmetadata_at, 2), Refusal::kNone);
  EXPECT_EQ(refusal_with(nmetadata_at, 0x7fffffff), Refusal::kBadCount);
  EXPECT_EQ(refusal_with(nmetadata_at, 1), Refusal::kTrailingBytes);
  EXPECT_EQ(refusal_with(nmetadata_at + 4, 0), Refusal::kBadString);
  EXPECT_EQ(refusal_with(nmetadata_at + 4 + 4 + 5, 0x7fffffff), Refusal::kBadCount);
}

// --- Refusals by the content ---------------------------------------------------------------------

template <typename Wire, typename Value>
void ExpectJointRefusals() {
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<Value>(), change);
  };
  const auto resize = [](int n) {
    return [n](Wire* m) {
      m->num_joints = n;
      m->position.resize(n);
      m->velocity.resize(n);
    };
  };
  EXPECT_EQ(changed(resize(kMaxJoints)), Refusal::kNone);
  EXPECT_EQ(changed(resize(kMaxJoints + 1)), Refusal::kLimit);
  EXPECT_EQ(changed(resize(0)), Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->position[1] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->position[1] = kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->velocity[2] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->velocity[2] = -kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->position[0] = 1e7; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->velocity[0] = -1e7; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
  EXPECT_EQ(changed([](Wire* m) { m->utime = std::numeric_limits<std::int64_t>::max(); }),
            Refusal::kBadTime);
}

TEST(JointStateRefusals, OneByOne) {
  ExpectJointRefusals<joint_state_t, JointState>();
}
TEST(JointCommandRefusals, OneByOne) {
  ExpectJointRefusals<joint_command_t, JointCommand>();
}

TEST(CameraPoseRefusals, OneByOne) {
  using Wire = bot_core::rigid_transform_t;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<CameraPose>(), change);
  };
  EXPECT_EQ(changed([](Wire* m) { m->trans[2] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->trans[0] = 1e7; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->quat[3] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { std::fill_n(m->quat, 4, 0.0); }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->quat[0] += 0.01; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
}

TEST(CameraPose, NormalisesTheQuaternion) {
  using Wire = bot_core::rigid_transform_t;
  const Bytes bytes = Encoded(Sample<CameraPose>());
  Wire wire;
  ASSERT_GT(wire.decode(bytes.data(), 0, static_cast<int>(bytes.size())), 0);
  for (double& component : wire.quat) component *= 1.0005;
  Bytes scaled(bytes.size());
  wire.encode(scaled.data(), 0, static_cast<int>(scaled.size()));
  CameraPose pose;
  ASSERT_EQ(Decode(scaled.data(), scaled.size(), &pose), Refusal::kNone);
  EXPECT_TRUE(pose.X_WC.isApprox(test::SamplePose(), 1e-14));
}

TEST(ImageFeaturesRefusals, OneByOne) {
  using Wire = image_features_t;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<ImageFeatures>(), change);
  };
  const auto resize = [](int n) {
    return [n](Wire* m) {
      m->num_markers = n;
      m->id.resize(n);
      m->u.resize(n);
      m->v.resize(n);
      m->valid.resize(n);
      for (int i = 0; i < n; ++i) m->id[i] = i;
    };
  };
  EXPECT_EQ(changed(resize(kMaxMarkers)), Refusal::kNone);
  EXPECT_EQ(changed(resize(kMaxMarkers + 1)), Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->u[0] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->v[1] = kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->u[0] = -1e7; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->valid[0] = 2; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->id[3] = m->id[0]; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->camera_position[1] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->camera_orientation[1] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->camera_orientation[0] += 0.01; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
  EXPECT_EQ(changed([](Wire* m) { m->exposure_utime = -1; }), Refusal::kBadTime);
  EXPECT_EQ(changed([](Wire* m) { m->exposure_utime = m->utime + 1; }), Refusal::kBadTime);
}

TEST(ImageFeatures, IgnoresThePixelOfAMarkerNotSeen) {
  EXPECT_EQ(Changed<image_features_t>(Sample<ImageFeatures>(),
                                      [](image_features_t* m) { m->u[2] = kNaN; }),
            Refusal::kNone);
}

TEST(ObservabilityRefusals, OneByOne) {
  using Wire = observability_t;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<ObservabilityReport>(), change);
  };
  for (double Wire::*member :
       {&Wire::w_v, &Wire::w_r, &Wire::w_c, &Wire::log_w_c, &Wire::geometric_mean,
        &Wire::sigma_min_v, &Wire::sigma_min_r, &Wire::sigma_min_c, &Wire::condition,
        &Wire::mm_per_px, &Wire::threshold, &Wire::trigger_value}) {
    EXPECT_EQ(changed([=](Wire* m) { m->*member = kNaN; }), Refusal::kNotFinite);
  }
  EXPECT_EQ(changed([](Wire* m) { m->log_w_c = kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->condition = -kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->log_w_c = 710.0; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->log_w_c = 709.0; }), Refusal::kNone);
  EXPECT_EQ(changed([](Wire* m) { m->w_v = kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->sigma[1] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->axes[2][7] = kNaN; }), Refusal::kNotFinite);
  for (std::int32_t Wire::*member : {&Wire::trigger_measure, &Wire::triggered, &Wire::cause,
                                     &Wire::active_state, &Wire::active_reason, &Wire::rank}) {
    EXPECT_EQ(changed([=](Wire* m) { m->*member = 99; }), Refusal::kOutOfRange);
    EXPECT_EQ(changed([=](Wire* m) { m->*member = -1; }), Refusal::kOutOfRange);
  }
  EXPECT_EQ(changed([](Wire* m) { m->seq = -1; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->camera_moves = -1; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->n = kMaxJoints + 1; }), Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->m = 7; }), Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->n = -1; }), Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) {
              m->num_sigma = kMaxRows + 1;
              m->sigma.resize(kMaxRows + 1);
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) {
              m->num_axes = kMaxJoints + 1;
              m->axes.resize(kMaxJoints + 1, std::vector<double>(8));
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) {
              m->k = kMaxRows + 1;
              m->axes.assign(3, std::vector<double>(kMaxRows + 1));
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
}

TEST(ServoStatusRefusals, OneByOne) {
  using Wire = servo_status_t;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<ServoStatus>(), change);
  };
  for (double Wire::*member :
       {&Wire::error_px, &Wire::loop_time_us, &Wire::loop_time_max_us, &Wire::loop_time_p50_us,
        &Wire::loop_time_p99_us, &Wire::loop_time_p999_us, &Wire::lateness_p999_us,
        &Wire::lateness_max_us, &Wire::calibration_position, &Wire::calibration_rotation,
        &Wire::calibration_focal, &Wire::calibration_revolute, &Wire::calibration_prismatic}) {
    EXPECT_EQ(changed([=](Wire* m) { m->*member = kNaN; }), Refusal::kNotFinite);
  }
  for (std::int32_t Wire::*member : {&Wire::state, &Wire::reason}) {
    EXPECT_EQ(changed([=](Wire* m) { m->*member = 14; }), Refusal::kOutOfRange);
    EXPECT_EQ(changed([=](Wire* m) { m->*member = -1; }), Refusal::kOutOfRange);
  }
  for (std::int32_t Wire::*member : {&Wire::markers_seen, &Wire::markers_needed}) {
    EXPECT_EQ(changed([=](Wire* m) { m->*member = -1; }), Refusal::kOutOfRange);
  }
  for (std::int64_t Wire::*member :
       {&Wire::seq, &Wire::deadline_misses, &Wire::refused_messages, &Wire::dropped_messages,
        &Wire::stops, &Wire::refused_malformed, &Wire::refused_wrong_size,
        &Wire::refused_not_finite, &Wire::refused_out_of_range, &Wire::refused_reordered,
        &Wire::refused_future}) {
    EXPECT_EQ(changed([=](Wire* m) { m->*member = -1; }), Refusal::kOutOfRange);
  }
  EXPECT_EQ(changed([](Wire* m) { m->stops_by_reason[13] = -1; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
}

TEST(GroundTruthRefusals, OneByOne) {
  using Wire = sim_truth_t;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<GroundTruth>(), change);
  };
  const auto resize = [](int n) {
    return [n](Wire* m) {
      m->num_joints = n;
      m->position.resize(n);
    };
  };
  EXPECT_EQ(changed(resize(kMaxJoints + 1)), Refusal::kLimit);
  EXPECT_EQ(changed(resize(0)), Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->position[1] = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->worst_error = kInfinity; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->rms_error = kNaN; }), Refusal::kNotFinite);
  EXPECT_EQ(changed([](Wire* m) { m->position[0] = 1e7; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->limit_violations = -1; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
}

TEST(ServoRecordRefusals, OneByOne) {
  const auto changed = [](const std::function<void(servo_inputs_t*)>& change) {
    return Changed<servo_inputs_t>(test::SampleServoRecord(), change);
  };
  EXPECT_EQ(changed([](servo_inputs_t*) {}), Refusal::kNone);
  EXPECT_EQ(changed([](servo_inputs_t* m) {
              m->num_periods = 1001;
              m->periods.resize(1001);
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](servo_inputs_t* m) {
              m->periods[1].num_joints = kMaxJoints + 1;
              m->periods[1].position.resize(kMaxJoints + 1);
              m->periods[1].velocity.resize(kMaxJoints + 1);
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](servo_inputs_t* m) {
              m->periods[1].num_poses = 2;
              m->periods[1].pose.resize(2);
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](servo_inputs_t* m) {
              m->periods[1].num_images = 2;
              m->periods[1].image.resize(2);
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](servo_inputs_t* m) {
              auto& image = m->periods[1].image[0];
              image.num_markers = kMaxMarkers + 1;
              image.id.resize(kMaxMarkers + 1);
              image.u.resize(kMaxMarkers + 1);
              image.v.resize(kMaxMarkers + 1);
              image.valid.resize(kMaxMarkers + 1);
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[1].position[2] = kNaN; }),
            Refusal::kNotFinite);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[1].pose[0].X_WC[0][0] = kInfinity; }),
            Refusal::kNotFinite);
  // No rotation: a column stretched, and one turned over.
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[1].pose[0].X_WC[0][0] += 1e-3; }),
            Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) {
              for (auto& row : m->periods[1].image[0].exposure.X_WC) row[2] = -row[2];
            }),
            Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[1].image[0].u[0] = 1e7; }),
            Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[1].image[0].valid[0] = 2; }),
            Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[0].enabled = 2; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[0].seq = -1; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->lost = -1; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[0].time_ns = -1; }), Refusal::kBadTime);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->periods[1].pose[0].time_ns = -1; }),
            Refusal::kBadTime);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->camera_steps[0].snapshot_ns = -1; }),
            Refusal::kBadTime);
  EXPECT_EQ(changed([](servo_inputs_t* m) { m->start_utime = -1; }), Refusal::kBadTime);
}

TEST(ServoSetupRefusals, OneByOne) {
  const auto changed = [](const std::function<void(servo_setup_t*)>& change) {
    return Changed<servo_setup_t>(test::SampleServoSetup(), change);
  };
  EXPECT_EQ(changed([](servo_setup_t*) {}), Refusal::kNone);
  EXPECT_EQ(changed([](servo_setup_t* m) { m->active_camera = 2; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](servo_setup_t* m) { m->start_utime = -1; }), Refusal::kBadTime);
  EXPECT_EQ(changed([](servo_setup_t* m) { m->scenario.resize(kMaxRecordBytes); }),
            Refusal::kTooLarge);
}

TEST(CameraImageRefusals, OneByOne) {
  using Wire = bot_core::image_t;
  const auto changed = [](const std::function<void(Wire*)>& change) {
    return Changed<Wire>(Sample<CameraImage>(), change);
  };
  for (const int side : {0, -1, 16385}) {
    EXPECT_EQ(changed([=](Wire* m) { m->width = side; }), Refusal::kLimit);
    EXPECT_EQ(changed([=](Wire* m) { m->height = side; }), Refusal::kLimit);
  }
  EXPECT_EQ(changed([](Wire* m) {
              m->size = 0;
              m->data.clear();
            }),
            Refusal::kLimit);
  EXPECT_EQ(changed([](Wire* m) { m->pixelformat = 1498831189; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->row_stride = 4; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->row_stride = -8; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->row_stride = 0x7fffffff; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->height = 5; }), Refusal::kOutOfRange);
  EXPECT_EQ(changed([](Wire* m) { m->utime = -1; }), Refusal::kBadTime);
}

TEST(CameraImage, LastRowNeedNotBeFilledUp) {
  EXPECT_EQ(Changed<bot_core::image_t>(Sample<CameraImage>(),
                                       [](bot_core::image_t* m) {
                                         m->size = 3 * 8 + 5;
                                         m->data.resize(m->size);
                                       }),
            Refusal::kNone);
}

TEST(Refusal, HasANameForEach) {
  for (int i = 0; i < kNumRefusals; ++i) EXPECT_STRNE(Name(static_cast<Refusal>(i)), "UNKNOWN");
  EXPECT_STREQ(Name(static_cast<Refusal>(kNumRefusals)), "UNKNOWN");
}

}  // namespace
}  // namespace vantage
