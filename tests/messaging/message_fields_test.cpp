#include "vantage/messaging/message_fields.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "samples.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

MessageContent ContentOf(const Bytes& bytes) {
  const MessageLayout* layout = FindLayout(bytes.data(), bytes.size());
  if (layout == nullptr) throw Error("unknown type");
  return ContentOf(*layout, bytes.data(), bytes.size());
}

template <typename Value>
Value Get(const std::vector<MessageField>& fields, const std::string& name) {
  const auto found = std::find_if(fields.begin(), fields.end(),
                                  [&](const MessageField& field) { return field.name == name; });
  if (found == fields.end()) throw Error("no field " + name);
  return std::get<Value>(found->value);
}

TEST(FindLayout, KnowsEveryTypeByItsFingerprint) {
  const auto name = [](const Bytes& bytes) -> std::string {
    const MessageLayout* layout = FindLayout(bytes.data(), bytes.size());
    return layout == nullptr ? "none" : layout->name;
  };
  EXPECT_EQ(name(test::Encoded(test::SampleJointState())), "vantage_msgs.joint_state_t");
  EXPECT_EQ(name(test::Encoded(test::SampleCameraImage())), "bot_core.image_t");
  EXPECT_EQ(name(test::Encoded(test::SampleServoRecord())), "vantage_msgs.servo_inputs_t");
  EXPECT_EQ(name(Bytes(8, 7)), "none");
  EXPECT_EQ(name(Bytes(3)), "none");
}

TEST(ContentOf, GivesNumbersTextsAndArraysByName) {
  const ObservabilityReport report = test::SampleObservability();
  const auto fields = ContentOf(test::Encoded(report)).fields;
  EXPECT_EQ(fields.front().name, "utime");
  EXPECT_EQ(Get<std::int64_t>(fields, "utime"), 5'000'000);
  EXPECT_EQ(Get<double>(fields, "w_v"), report.w_v);
  EXPECT_EQ(Get<double>(fields, "sigma[2]"), 100.0);
  EXPECT_EQ(Get<double>(fields, "axes[1][3]"), report.axes(3, 1));
  EXPECT_EQ(Get<std::string>(fields, "cause_name"), "VIEW");
  EXPECT_EQ(Get<std::int64_t>(fields, "camera_moves"), 4);
}

TEST(ContentOf, KeepsTheSignOfIntegers) {
  ImageFeatures features = test::SampleImageFeatures();
  features.markers[1].id = -5;
  EXPECT_EQ(Get<std::int64_t>(ContentOf(test::Encoded(features)).fields, "id[1]"), -5);
}

TEST(ContentOf, OfBytesGivesTheirNumber) {
  const auto content = ContentOf(test::Encoded(test::SampleCameraImage()));
  EXPECT_EQ(Get<std::int64_t>(content.fields, "data.size"), 32);
  EXPECT_EQ(Get<std::int64_t>(content.fields, "nmetadata"), 0);
}

TEST(ContentOf, TakesArraysOfStructsApart) {
  const auto content = ContentOf(test::Encoded(test::SampleServoRecord()));
  EXPECT_EQ(Get<std::int64_t>(content.fields, "lost"), 3);
  ASSERT_EQ(content.tables.size(), 2U);
  EXPECT_EQ(content.tables[0].name, "periods");
  ASSERT_EQ(content.tables[0].rows.size(), 2U);
  const auto& taken = content.tables[0].rows[1];
  EXPECT_EQ(Get<std::int64_t>(taken, "seq"), 42);
  EXPECT_EQ(Get<double>(taken, "position[5]"), 1.0);
  EXPECT_EQ(Get<double>(taken, "pose[0].X_WC[1][3]"), -1.25);
  EXPECT_EQ(Get<double>(taken, "image[0].exposure.X_WC[2][3]"), 2.0);
  EXPECT_EQ(content.tables[1].name, "camera_steps");
  EXPECT_EQ(Get<std::int64_t>(content.tables[1].rows.at(0), "step"), 7);
}

TEST(ContentOf, RefusesBytesThatAreNoMessage) {
  Bytes bytes = test::Encoded(test::SampleJointState());
  bytes.pop_back();
  EXPECT_THROW((void)ContentOf(bytes), Error);
}

}  // namespace
}  // namespace vantage
