// The camera's driver with an eye that sees what it is told: when images are taken, which arrive, and with what stamps.

#include "sim/camera_driver.h"

#include <gtest/gtest.h>

#include "vantage/config/loaders.h"
#include "vantage/robot/kinematics.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;
using std::chrono::milliseconds;

const Time kStart = Time(std::chrono::seconds(5));

// Straight down from 1 m above (x, 0).
Isometry3d At(double x) {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Vector3d(1.0, -1.0, -1.0).asDiagonal();
  X.translation() = Vector3d(x, 0.0, 1.0);
  return X;
}

// Notes what it is shown, and tells images apart by the first marker's column: how many it has seen.
class FakeEye : public Eye {
 public:
  struct Seen {
    int images{0};
    Time last{};
    Isometry3d X_WC{Isometry3d::Identity()}, X_WG{Isometry3d::Identity()};
    JointVector q;
    std::vector<MarkerPrediction> predictions;
  };

  explicit FakeEye(Seen* seen) : seen_(seen) {}

  void See(Time now, const Isometry3d& X_WC_true, const JointVector& q_true, const Isometry3d& X_WG,
           const std::vector<MarkerPrediction>& predictions, ImageFeatures* features) override {
    *seen_ = {seen_->images + 1, now, X_WC_true, X_WG, q_true, predictions};
    features->count = 1;
    features->markers[0] = {7, Eigen::Vector2d(seen_->images, 0.0), true};
  }

 private:
  Seen* seen_;
};

class CameraDriverTest : public ::testing::Test {
 protected:
  // Images every 10 ms.
  static CameraEffects Effects(int latency_frames = 0, double drop_rate = 0.0) {
    CameraEffects effects;
    effects.rate = 100.0;
    effects.latency_frames = latency_frames;
    effects.drop_rate = drop_rate;
    return effects;
  }

  CameraDriver Driver(const CameraEffects& effects, std::uint64_t seed = 1) {
    seen_ = {};
    const CameraKnowledge knowledge{arm_, CameraModel(), {tool_}, {goal_}};
    CameraDriver driver(std::make_unique<FakeEye>(&seen_), knowledge, effects, seed);
    driver.Start(kStart);
    return driver;
  }

  void Expose(CameraDriver* driver, Time now) const {
    driver->Expose(now, At(0.1), q_, Isometry3d::Identity(), At(0.2), q_);
  }

  // Which of 1000 images come, by the numbers that the eye gave them.
  std::vector<int> Arriving(const CameraEffects& effects, std::uint64_t seed) {
    CameraDriver driver = Driver(effects, seed);
    std::vector<int> numbers;
    for (int i = 0; i < 1000; ++i) {
      const Time now = kStart + milliseconds(10 * i);
      Expose(&driver, now);
      const auto features = driver.Deliver(now);
      if (features) numbers.push_back(static_cast<int>(features->markers[0].pixel.x()));
    }
    return numbers;
  }

  ArmModel arm_ = FindRobot("planar2");
  Marker tool_{0, {0.0, 0.0, 0.025}, Vector3d::UnitZ(), 0.014, true};
  Marker goal_{10, {0.3, 0.2, 0.025}, Vector3d::UnitZ(), 0.014, false};
  JointVector q_ = JointVector::Zero(2);
  FakeEye::Seen seen_;
};

TEST_F(CameraDriverTest, HandsFeaturesOutAfterTheLatencyOnce) {
  CameraDriver driver = Driver(Effects(2));
  Expose(&driver, kStart);
  EXPECT_FALSE(driver.Deliver(kStart));
  EXPECT_FALSE(driver.Deliver(kStart + milliseconds(20) - Duration(1)));
  EXPECT_TRUE(driver.Deliver(kStart + milliseconds(20)));
  EXPECT_FALSE(driver.Deliver(kStart + milliseconds(20)));
}

TEST_F(CameraDriverTest, HandsOutTheNewestOfThoseThatAreDue) {
  CameraDriver driver = Driver(Effects(1));
  for (int i = 0; i < 3; ++i) Expose(&driver, kStart + milliseconds(10 * i));
  const auto features = driver.Deliver(kStart + milliseconds(20));
  ASSERT_TRUE(features);
  EXPECT_EQ(features->exposure, kStart + milliseconds(10));
  const auto next = driver.Deliver(kStart + milliseconds(30));
  ASSERT_TRUE(next);
  EXPECT_EQ(next->exposure, kStart + milliseconds(20));
}

TEST_F(CameraDriverTest, StampsWithExposureArrivalAndTheMeasuredPose) {
  CameraDriver driver = Driver(Effects(3));
  const Time exposure = kStart + milliseconds(2);
  driver.Expose(exposure, At(0.1), q_, Isometry3d::Identity(), At(0.2), q_);
  const auto features = driver.Deliver(kStart + milliseconds(100));
  ASSERT_TRUE(features);
  EXPECT_EQ(features->exposure, exposure);
  EXPECT_EQ(features->stamp, exposure + milliseconds(30));
  EXPECT_EQ(features->X_WC.matrix(), At(0.2).matrix());
  ASSERT_EQ(features->count, 1);
  EXPECT_EQ(features->markers[0].id, 7);
}

// The eye sees the truth; what it is told to expect comes from what was measured.
TEST_F(CameraDriverTest, ShowsTheTruthAndPredictsFromMeasurements) {
  CameraDriver driver = Driver(Effects());
  const JointVector q_true = JointVector::Constant(2, 0.3), q_measured = q_;
  const Isometry3d X_WG = At(0.5), X_WC_measured = At(0.4);
  driver.Expose(kStart, At(0.1), q_true, X_WG, X_WC_measured, q_measured);
  EXPECT_EQ(seen_.last, kStart);
  EXPECT_EQ(seen_.X_WC.matrix(), At(0.1).matrix());
  EXPECT_EQ(seen_.X_WG.matrix(), X_WG.matrix());
  EXPECT_EQ(seen_.q, q_true);
  const Isometry3d X_CW = X_WC_measured.inverse();
  std::vector<MarkerPrediction> expected;
  PredictMarkers(CameraModel(), X_CW, X_CW * EndEffectorPose(arm_, q_measured), {tool_}, {goal_},
                 &expected);
  ASSERT_EQ(seen_.predictions.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(seen_.predictions[i].id, expected[i].id);
    EXPECT_TRUE(seen_.predictions[i].expected);
    EXPECT_EQ(seen_.predictions[i].image.centroid, expected[i].image.centroid);
  }
}

// Steps of 3 ms: an image is late by less than a step, and lateness does not add up.
TEST_F(CameraDriverTest, ExposesOnAGridOfItsOwn) {
  CameraDriver driver = Driver(Effects());
  EXPECT_FALSE(driver.Due(kStart - Duration(1)));
  int images = 0;
  for (Time now = kStart; now < kStart + std::chrono::seconds(3); now += milliseconds(3)) {
    if (!driver.Due(now)) continue;
    const Time due = kStart + milliseconds(10 * images);
    EXPECT_GE(now, due);
    EXPECT_LT(now, due + milliseconds(3));
    Expose(&driver, now);
    ++images;
    EXPECT_FALSE(driver.Due(now));
  }
  EXPECT_EQ(images, 300);
}

TEST_F(CameraDriverTest, LosesNothingUnlessToldTo) {
  EXPECT_EQ(Arriving(Effects(), 1).size(), 1000u);
}

// 1000 images lost with 0.3 each: 300 ± 14.5 (one standard deviation).
TEST_F(CameraDriverTest, LosesItsShareOfImagesBySeed) {
  const std::vector<int> first = Arriving(Effects(0, 0.3), 1);
  EXPECT_NEAR(static_cast<double>(first.size()), 700.0, 60.0);
  EXPECT_EQ(seen_.images, 1000);  // The lost ones were taken, too.
  EXPECT_EQ(Arriving(Effects(0, 0.3), 1), first);
  EXPECT_NE(Arriving(Effects(0, 0.3), 2), first);
}

}  // namespace
}  // namespace vantage::sim
