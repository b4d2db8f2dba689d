#include "vantage/observability/batch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <gtest/gtest.h>

#include "config_error.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;

// Seeded motions and cameras that look at them from 1 to 4 m.
class Generator {
 public:
  explicit Generator(unsigned seed) : random_(seed) {}

  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3d Inside(double size) {
    return {Uniform(-size, size), Uniform(-size, size), Uniform(-size, size)};
  }

  // Points of one body of some 0.1 m, moved by n joints.
  std::vector<BatchSample> RigidMotion(int samples, int points, int joints) {
    std::vector<Vector3d> body;
    for (int i = 0; i < points; ++i) body.push_back(Inside(0.1));
    std::vector<BatchSample> motion(samples);
    for (BatchSample& sample : motion) {
      const Vector3d p_WE = Inside(0.4);
      const Eigen::Matrix3d R_WE =
          Eigen::AngleAxisd(Uniform(-3.0, 3.0), Inside(1.0).normalized()).toRotationMatrix();
      ArmJacobian J_r(6, joints);
      for (int j = 0; j < joints; ++j) {
        J_r.col(j).head<3>() = Inside(0.6);
        J_r.col(j).tail<3>() = Inside(1.0);
      }
      for (const Vector3d& p_E : body) {
        const Vector3d p_EP_W = R_WE * p_E;
        sample.p_W.push_back(p_WE + p_EP_W);
        sample.J_p_W.push_back(PointJacobianOf(J_r, p_EP_W));
      }
      sample.weight = Uniform(0.1, 1.0);
    }
    return motion;
  }

  std::vector<BatchSample> FreeMotion(int samples, int points, int joints) {
    std::vector<BatchSample> motion(samples);
    for (BatchSample& sample : motion) {
      for (int i = 0; i < points; ++i) {
        sample.p_W.push_back(Inside(0.4));
        PointJacobian J(3, joints);
        for (int j = 0; j < joints; ++j) J.col(j) = Inside(0.6);
        sample.J_p_W.push_back(J);
      }
      sample.weight = Uniform(0.1, 1.0);
    }
    return motion;
  }

  Isometry3d Camera() {
    const Vector3d direction = Inside(1.0).normalized();
    Isometry3d X_WC = Isometry3d::Identity();
    X_WC.translation() = Uniform(1.0, 4.0) * direction;
    const Vector3d z = (Inside(0.2) - X_WC.translation()).normalized();
    const Vector3d x = z.unitOrthogonal();
    X_WC.linear() << x, z.cross(x), z;
    X_WC.linear() =
        X_WC.linear() * Eigen::AngleAxisd(Uniform(-3.0, 3.0), Vector3d::UnitZ()).toRotationMatrix();
    return X_WC;
  }

 private:
  std::mt19937 random_;
};

BatchLens PixelLens() {
  BatchLens lens;
  lens.fx = 812.3;
  lens.fy = 798.1;
  lens.skew = 1.7;
  return lens;
}

// The measure of one J_c by the plain route.
double PlainMeasure(BatchMeasure measure, const MatrixXd& J, int s) {
  if (!J.allFinite()) {
    return measure == BatchMeasure::kLogW || measure == BatchMeasure::kNegativeTrace
               ? -std::numeric_limits<double>::infinity()
               : 0.0;
  }
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<MatrixXd>(J).singularValues().head(s);
  switch (measure) {
    case BatchMeasure::kW:
      return sigma.prod();
    case BatchMeasure::kLogW:
      return sigma.array().log().sum();
    case BatchMeasure::kSigmaMin:
      return sigma(s - 1);
    case BatchMeasure::kInverseCondition:
      return sigma(s - 1) / sigma(0);
    case BatchMeasure::kNegativeTrace:
      return -sigma.array().inverse().square().sum();
  }
  return 0.0;
}

struct Shape {
  const char* name;
  int points, joints;
  bool triple;  // rows x1, y1, x2; else both of all
  BatchBody body;
  const char* form;
};

std::ostream& operator<<(std::ostream& out, const Shape& shape) {
  return out << shape.name;
}

std::vector<BatchSample> MotionOf(const Shape& shape, int samples, unsigned seed) {
  Generator generator(seed);
  return shape.body == BatchBody::kRigid
             ? generator.RigidMotion(samples, shape.points, shape.joints)
             : generator.FreeMotion(samples, shape.points, shape.joints);
}

BatchScene SceneOf(const Shape& shape, int samples, unsigned seed) {
  std::vector<BatchRow> rows;
  if (shape.triple) rows = {{0, 0}, {0, 1}, {1, 0}};
  return BatchScene(MotionOf(shape, samples, seed), shape.body, rows, 2.0);
}

const Shape kShapes[] = {
    {"TwoRowsOneJoint", 1, 1, false, BatchBody::kRigid, "generic"},
    {"TwoRowsTwoJoints", 1, 2, false, BatchBody::kRigid, "pair"},
    {"TwoRowsSixJoints", 1, 6, false, BatchBody::kRigid, "pair"},
    {"TripleTwoJoints", 2, 2, true, BatchBody::kRigid, "generic"},
    {"TripleThreeJoints", 2, 3, true, BatchBody::kRigid, "triple"},
    {"TripleFourJoints", 2, 4, true, BatchBody::kRigid, "triple"},
    {"TripleFiveJoints", 2, 5, true, BatchBody::kRigid, "triple"},
    {"TripleSixJoints", 2, 6, true, BatchBody::kRigid, "triple"},
    {"TripleSixteenJoints", 2, 16, true, BatchBody::kRigid, "triple"},
    {"FourRowsThreeJoints", 2, 3, false, BatchBody::kRigid, "generic"},
    {"FourRowsSixJoints", 2, 6, false, BatchBody::kRigid, "generic"},
    {"FourRowsSevenJoints", 2, 7, false, BatchBody::kRigid, "generic"},
    {"SixRowsFiveJoints", 3, 5, false, BatchBody::kRigid, "generic"},
    {"SixRowsSixJoints", 3, 6, false, BatchBody::kRigid, "rigid six"},
    {"EightRowsThreeJoints", 4, 3, false, BatchBody::kRigid, "generic"},
    {"EightRowsSixJoints", 4, 6, false, BatchBody::kRigid, "rigid six"},
    {"EightRowsSevenJoints", 4, 7, false, BatchBody::kRigid, "rigid six"},
    {"TenRowsSixJoints", 5, 6, false, BatchBody::kRigid, "rigid six"},
    {"TwelveRowsSixteenJoints", 6, 16, false, BatchBody::kRigid, "rigid six"},
    {"FourteenRowsSixJoints", 7, 6, false, BatchBody::kRigid, "rigid six"},
    {"SixteenRowsSixJoints", 8, 6, false, BatchBody::kRigid, "rigid six"},
    {"SixteenRowsFourJoints", 8, 4, false, BatchBody::kRigid, "generic"},
    {"FreeFourRowsSevenJoints", 2, 7, false, BatchBody::kFree, "generic"},
    {"FreeEightRowsNineJoints", 4, 9, false, BatchBody::kFree, "generic"},
    {"FreeTripleSixteenJoints", 2, 16, true, BatchBody::kFree, "triple"},
    {"FreeSixteenRowsTwelveJoints", 8, 12, false, BatchBody::kFree, "generic"},
};

class BatchShape : public ::testing::TestWithParam<Shape> {};

INSTANTIATE_TEST_SUITE_P(Shapes, BatchShape, ::testing::ValuesIn(kShapes),
                         [](const auto& test) { return std::string(test.param.name); });

TEST_P(BatchShape, TakesTheExpectedForm) {
  const BatchScene scene = SceneOf(GetParam(), 3, 1);
  EXPECT_EQ(scene.form(), GetParam().form);
  const int rows = static_cast<int>(scene.rows().size());
  const int cap = GetParam().body == BatchBody::kRigid ? 6 : 100;
  EXPECT_EQ(scene.rank(), std::min({rows, GetParam().joints, cap}));
}

// The bound on relative differences: 1e-10 for a matrix whose condition is a thousand; squaring forms
// lose digits with the square of it.
TEST_P(BatchShape, EqualsTheSvdRouteForEveryCameraAndInstructionSet) {
  constexpr int kSamples = 21, kCameras = 37;
  const BatchScene scene = SceneOf(GetParam(), kSamples, 42);
  Generator generator(7);
  BatchCameras cameras;
  cameras.Resize(kCameras);
  std::vector<Isometry3d> poses;
  std::vector<double> zooms;
  for (int i = 0; i < kCameras; ++i) {
    poses.push_back(generator.Camera());
    zooms.push_back(generator.Uniform(0.5, 2.0));
    cameras.Set(i, poses.back(), zooms.back());
  }
  const BatchLens lens = PixelLens();
  for (const BatchIsa isa : AvailableIsas()) {
    const BatchEvaluator evaluator(isa);
    BatchScores with, without;
    evaluator.Score(scene, cameras, 0, kCameras, lens, BatchMeasure::kW, BatchPrecision::kDouble,
                    true, &with);
    evaluator.Score(scene, cameras, 0, kCameras, lens, BatchMeasure::kW, BatchPrecision::kDouble,
                    false, &without);
    for (int i = 0; i < kCameras; ++i) {
      double sum = 0.0, least = std::numeric_limits<double>::infinity();
      for (int k = 0; k < kSamples; ++k) {
        const MatrixXd J = PlainJacobian(scene, k, poses[i], zooms[i], lens);
        const double w = PlainMeasure(BatchMeasure::kW, J, scene.rank());
        sum += scene.samples()[k].weight * w;
        least = std::min(least, w);
      }
      EXPECT_NEAR(with.sum[i], sum, 1e-10 * sum) << Name(isa) << ", camera " << i;
      EXPECT_NEAR(without.sum[i], sum, 1e-10 * sum) << Name(isa) << ", camera " << i;
      EXPECT_NEAR(with.least[i], least, 1e-10 * least + 1e-13 * sum) << Name(isa);
    }
  }
}

TEST_P(BatchShape, MeasuresOfSingularValuesEqualTheSvdRoute) {
  constexpr int kSamples = 5, kCameras = 17;
  const BatchScene scene = SceneOf(GetParam(), kSamples, 43);
  Generator generator(8);
  BatchCameras cameras;
  cameras.Resize(kCameras);
  std::vector<Isometry3d> poses;
  for (int i = 0; i < kCameras; ++i) {
    poses.push_back(generator.Camera());
    cameras.Set(i, poses.back(), 1.3);
  }
  const BatchLens lens = PixelLens();
  for (const BatchIsa isa : AvailableIsas()) {
    for (const BatchMeasure measure :
         {BatchMeasure::kLogW, BatchMeasure::kSigmaMin, BatchMeasure::kInverseCondition,
          BatchMeasure::kNegativeTrace}) {
      BatchScores scores;
      BatchEvaluator(isa).Score(scene, cameras, 0, kCameras, lens, measure, BatchPrecision::kDouble,
                                true, &scores);
      for (int i = 0; i < kCameras; ++i) {
        double sum = 0.0, least = std::numeric_limits<double>::infinity();
        for (int k = 0; k < kSamples; ++k) {
          const MatrixXd J = PlainJacobian(scene, k, poses[i], 1.3, lens);
          const double value = PlainMeasure(measure, J, scene.rank());
          sum += scene.samples()[k].weight * value;
          least = std::min(least, value);
        }
        EXPECT_NEAR(scores.sum[i], sum, 1e-9 * std::abs(sum)) << Name(isa) << ", camera " << i;
        EXPECT_NEAR(scores.least[i], least, 1e-9 * std::abs(least)) << Name(isa);
      }
    }
  }
}

TEST_P(BatchShape, SinglePrecisionOrdersCameras) {
  constexpr int kSamples = 21, kCameras = 64;
  const BatchScene scene = SceneOf(GetParam(), kSamples, 44);
  Generator generator(9);
  BatchCameras cameras;
  cameras.Resize(kCameras);
  for (int i = 0; i < kCameras; ++i) cameras.Set(i, generator.Camera());
  for (const BatchIsa isa : AvailableIsas()) {
    const BatchEvaluator evaluator(isa);
    BatchScores exact, scan;
    evaluator.Score(scene, cameras, 0, kCameras, PixelLens(), BatchMeasure::kW,
                    BatchPrecision::kDouble, false, &exact);
    evaluator.Score(scene, cameras, 0, kCameras, PixelLens(), BatchMeasure::kW,
                    BatchPrecision::kSingle, false, &scan);
    for (int i = 0; i < kCameras; ++i) {
      EXPECT_NEAR(scan.sum[i], exact.sum[i], 2e-3 * exact.sum[i]) << Name(isa);
    }
  }
}

// A batch may start anywhere and have any length.
TEST_P(BatchShape, BlocksDoNotMatter) {
  const BatchScene scene = SceneOf(GetParam(), 9, 45);
  Generator generator(10);
  BatchCameras cameras;
  cameras.Resize(23);
  for (int i = 0; i < 23; ++i) cameras.Set(i, generator.Camera());
  const BatchEvaluator evaluator;
  for (const BatchPrecision precision : {BatchPrecision::kDouble, BatchPrecision::kSingle}) {
    BatchScores whole;
    evaluator.Score(scene, cameras, 0, 23, PixelLens(), BatchMeasure::kW, precision, false, &whole);
    for (int first = 0; first < 23; ++first) {
      BatchScores one;
      evaluator.Score(scene, cameras, first, 1, PixelLens(), BatchMeasure::kW, precision, false,
                      &one);
      ASSERT_EQ(one.sum.size(), 1u);
      EXPECT_EQ(one.sum[0], whole.sum[first]);
    }
  }
}

TEST_P(BatchShape, ProfileEqualsScores) {
  const BatchScene scene = SceneOf(GetParam(), 21, 46);
  Generator generator(11);
  const Isometry3d X_WC = generator.Camera();
  for (const BatchIsa isa : AvailableIsas()) {
    const BatchEvaluator evaluator(isa);
    BatchProfile values, slopes;
    evaluator.Profile(scene, X_WC, 1.2, PixelLens(), false, &values);
    evaluator.Profile(scene, X_WC, 1.2, PixelLens(), true, &slopes);
    ASSERT_EQ(values.w.size(), 21u);
    EXPECT_EQ(values.gradient.cols(), 0);
    ASSERT_EQ(slopes.gradient.cols(), 21);
    for (int i = 0; i < 21; ++i) {
      const MatrixXd J = PlainJacobian(scene, i, X_WC, 1.2, PixelLens());
      const double w = PlainMeasure(BatchMeasure::kW, J, scene.rank());
      EXPECT_NEAR(values.w[i], w, 1e-9 * w) << Name(isa);
      EXPECT_NEAR(slopes.w[i], w, 1e-9 * w) << Name(isa);
    }
  }
}

TEST_P(BatchShape, GradientMatchesCentralDifference) {
  const BatchScene scene = SceneOf(GetParam(), 19, 47);
  Generator generator(12);
  for (int camera = 0; camera < 4; ++camera) {
    const Isometry3d X_WC = generator.Camera();
    for (const BatchIsa isa : AvailableIsas()) {
      const BatchEvaluator evaluator(isa);
      BatchProfile here;
      evaluator.Profile(scene, X_WC, 0.8, PixelLens(), true, &here);
      constexpr double kStep = 1e-5;
      MatrixXd numeric(6, 19);
      for (int j = 0; j < 6; ++j) {
        const Twist step = kStep * Twist::Unit(j);
        BatchProfile ahead, behind;
        evaluator.Profile(scene, Advance(X_WC, step), 0.8, PixelLens(), false, &ahead);
        evaluator.Profile(scene, Advance(X_WC, -step), 0.8, PixelLens(), false, &behind);
        for (int i = 0; i < 19; ++i) numeric(j, i) = (ahead.w[i] - behind.w[i]) / (2.0 * kStep);
      }
      for (int i = 0; i < 19; ++i) {
        // Second-order rest of the differences, and their rounding, both relative to w.
        const double bound = 1e-6 * numeric.col(i).cwiseAbs().maxCoeff() + 1e-6 * here.w[i];
        for (int j = 0; j < 6; ++j) {
          EXPECT_NEAR(here.gradient(j, i), numeric(j, i), bound)
              << Name(isa) << ", sample " << i << ", axis " << j;
        }
      }
    }
  }
}

// |.| would hide a point behind the camera; only the samples that have one count as 0.
TEST_P(BatchShape, SamplesWithAPointBehindCountAsZero) {
  const BatchScene scene = SceneOf(GetParam(), 21, 48);
  Isometry3d X_WC = Isometry3d::Identity();  // in the midst of the points
  for (const BatchIsa isa : AvailableIsas()) {
    const BatchEvaluator evaluator(isa);
    BatchProfile profile;
    evaluator.Profile(scene, X_WC, 1.0, PixelLens(), true, &profile);
    double sum = 0.0;
    int behind = 0;
    for (int i = 0; i < 21; ++i) {
      const MatrixXd J = PlainJacobian(scene, i, X_WC, 1.0, PixelLens());
      const double w = PlainMeasure(BatchMeasure::kW, J, scene.rank());
      if (!J.allFinite()) {
        ++behind;
        EXPECT_EQ(profile.w[i], 0.0);
        EXPECT_TRUE(profile.gradient.col(i).isZero(0.0)) << profile.gradient.col(i).transpose();
      }
      sum += scene.samples()[i].weight * w;
    }
    ASSERT_GT(behind, 0);
    BatchCameras cameras;
    cameras.Resize(1);
    cameras.Set(0, X_WC);
    for (const bool with_least : {false, true}) {
      BatchScores scores;
      evaluator.Score(scene, cameras, 0, 1, PixelLens(), BatchMeasure::kW, BatchPrecision::kDouble,
                      with_least, &scores);
      EXPECT_NEAR(scores.sum[0], sum, 1e-8 * sum) << Name(isa);
      if (with_least) {
        EXPECT_EQ(scores.least[0], 0.0);
      }
    }
    BatchScores logs;
    evaluator.Score(scene, cameras, 0, 1, PixelLens(), BatchMeasure::kLogW, BatchPrecision::kDouble,
                    true, &logs);
    EXPECT_EQ(logs.least[0], -std::numeric_limits<double>::infinity());
  }
}

TEST(BatchScene, OfOnePointThatStandsStillHasNoMotionToSee) {
  Generator generator(3);
  std::vector<BatchSample> motion = generator.RigidMotion(4, 4, 6);
  for (BatchSample& sample : motion) {
    for (PointJacobian& J : sample.J_p_W) J.setZero();
  }
  const BatchScene scene(motion);
  BatchCameras cameras;
  cameras.Resize(1);
  cameras.Set(0, generator.Camera());
  BatchScores scores;
  BatchEvaluator().Score(scene, cameras, 0, 1, PixelLens(), BatchMeasure::kW,
                         BatchPrecision::kDouble, true, &scores);
  EXPECT_EQ(scores.sum[0], 0.0);
}

// A point behind the camera makes log w and the negative trace -inf, which times no weight is nothing.
TEST(BatchScene, SamplesWithoutWeightAddNothing) {
  Generator generator(33);
  std::vector<BatchSample> motion = generator.FreeMotion(2, 2, 3);
  const Isometry3d X_WC = generator.Camera();
  motion[1].weight = 0.0;
  motion[1].p_W[0] = X_WC * Vector3d(0.0, 0.0, -1.0);
  const BatchScene both(motion, BatchBody::kFree, {}, 2.0);
  const BatchScene first({motion[0]}, BatchBody::kFree, {}, 2.0);
  BatchCameras cameras;
  cameras.Resize(1);
  cameras.Set(0, X_WC);
  for (const BatchIsa isa : AvailableIsas()) {
    for (const BatchMeasure measure :
         {BatchMeasure::kW, BatchMeasure::kLogW, BatchMeasure::kSigmaMin,
          BatchMeasure::kInverseCondition, BatchMeasure::kNegativeTrace}) {
      BatchScores of_both, of_first;
      BatchEvaluator(isa).Score(both, cameras, 0, 1, PixelLens(), measure, BatchPrecision::kDouble,
                                true, &of_both);
      BatchEvaluator(isa).Score(first, cameras, 0, 1, PixelLens(), measure, BatchPrecision::kDouble,
                                true, &of_first);
      EXPECT_EQ(of_both.sum[0], of_first.sum[0]) << Name(isa);
      EXPECT_LE(of_both.least[0], 0.0) << Name(isa);
    }
  }
}

// Four points in a line are no body: a turn about the line is not seen.
TEST(BatchScene, OfPointsInALineIsSingular) {
  Generator generator(4);
  std::vector<BatchSample> motion = generator.RigidMotion(3, 4, 6);
  Generator joints(5);
  for (BatchSample& sample : motion) {
    const Vector3d along = joints.Inside(0.1);
    const Vector3d start = joints.Inside(0.3);
    ArmJacobian J_r(6, 6);
    for (int j = 0; j < 6; ++j) J_r.col(j) << joints.Inside(0.5), joints.Inside(1.0);
    for (int i = 0; i < 4; ++i) {
      sample.p_W[i] = start + i * along;
      sample.J_p_W[i] = PointJacobianOf(J_r, i * along);
    }
  }
  const BatchScene scene(motion);
  EXPECT_EQ(scene.form(), "rigid six");
  BatchCameras cameras;
  cameras.Resize(1);
  cameras.Set(0, generator.Camera());
  BatchScores scores;
  BatchEvaluator().Score(scene, cameras, 0, 1, PixelLens(), BatchMeasure::kW,
                         BatchPrecision::kDouble, true, &scores);
  EXPECT_EQ(scores.sum[0], 0.0);
}

std::string RefusalOf(const std::vector<BatchSample>& samples, BatchBody body,
                      const std::vector<BatchRow>& rows) {
  try {
    const BatchScene scene(samples, body, rows);
  } catch (const ConfigError& error) {
    return error.key();
  }
  return "";
}

TEST(BatchScene, RefusesWhatDoesNotFit) {
  Generator generator(6);
  const std::vector<BatchSample> good = generator.RigidMotion(3, 2, 3);
  EXPECT_EQ(RefusalOf(good, BatchBody::kRigid, {}), "");
  EXPECT_EQ(RefusalOf({}, BatchBody::kRigid, {}), "batch.samples");
  EXPECT_EQ(RefusalOf(good, BatchBody::kRigid, {{2, 0}}), "batch.rows[0]");
  EXPECT_EQ(RefusalOf(good, BatchBody::kRigid, {{0, 2}}), "batch.rows[0]");
  EXPECT_EQ(RefusalOf(good, BatchBody::kRigid, {{0, 0}, {0, 0}}), "batch.rows[1]");
  auto bad = good;
  bad[1].p_W.pop_back();
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "batch.samples[1]");
  bad = good;
  bad[2].J_p_W[0](1, 1) = std::nan("");
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "batch.samples[2]");
  bad = good;
  bad[2].J_p_W[0](1, 1) += 0.1;
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "batch.samples[2]");
  EXPECT_EQ(RefusalOf(bad, BatchBody::kFree, {}), "");
  // Two points that turn about the first, each its own way.
  bad = generator.FreeMotion(1, 3, 1);
  bad[0].p_W = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  bad[0].J_p_W = {Vector3d(0, 0, 0), Vector3d(0, 1, 0), Vector3d(1, 0, 0)};
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "batch.samples[0]");
  bad[0].J_p_W[2] = Vector3d(-1, 0, 0);  // the same way
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "");
  bad = good;
  bad[0].weight = -1.0;
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "batch.samples[0].weight");
  for (BatchSample& sample : bad) sample.weight = 0.0;
  EXPECT_EQ(RefusalOf(bad, BatchBody::kRigid, {}), "batch.samples");
}

TEST(BatchEvaluator, RefusesAnInstructionSetThatTheMachineLacks) {
  for (const BatchIsa isa : {BatchIsa::kBaseline, BatchIsa::kAvx2, BatchIsa::kAvx512}) {
    const auto available = AvailableIsas();
    const bool runs = std::find(available.begin(), available.end(), isa) != available.end();
    if (runs) {
      EXPECT_NO_THROW(BatchEvaluator{isa});
    } else {
      EXPECT_THROW(BatchEvaluator{isa}, ConfigError);
    }
  }
}

// ---- Constraints --------------------------------------------------------------------------------

struct Margins {
  double near{1e9}, far{1e9}, image{1e9};
};

// By visiting every point. Coming nearer by d turns (X, Z) into (X, Z - d).
Margins PlainMargins(const std::vector<BatchSample>& motion, const Isometry3d& X_WC, double zoom,
                     const BatchLens& lens, const DepthLimits& limits) {
  Margins worst;
  const double x_mid = 0.5 * (lens.x_min + lens.x_max) / zoom;
  const double y_mid = 0.5 * (lens.y_min + lens.y_max) / zoom;
  const double x_half = 0.5 * (lens.x_max - lens.x_min) / zoom;
  const double y_half = 0.5 * (lens.y_max - lens.y_min) / zoom;
  for (const BatchSample& sample : motion) {
    for (const Vector3d& p_W : sample.p_W) {
      const Vector3d p = X_WC.inverse() * p_W;
      worst.near = std::min(worst.near, p.z() - limits.min);
      worst.far = std::min(worst.far, limits.max - p.z());
      worst.image = std::min(worst.image, p.z() - std::abs(p.x() - x_mid * p.z()) / x_half);
      worst.image = std::min(worst.image, p.z() - std::abs(p.y() - y_mid * p.z()) / y_half);
    }
  }
  return worst;
}

// `given` is exact where negative; where positive it may be too small by `slack`.
void ExpectMargin(double given, double exact, double tolerance, double slack) {
  EXPECT_LE(given, exact + tolerance);
  EXPECT_GE(given, exact - tolerance - (exact > 0.0 ? slack : 0.0));
  if (std::abs(exact) > tolerance) {
    EXPECT_EQ(given > 0.0, exact > 0.0) << given << " and " << exact;
  }
}

// Points that run along smooth curves (bent by at most 2 cm between every eighth) and such that jump about.
TEST(BatchFrustum, MarginsAreThoseOfTheWorstPoint) {
  for (const bool smooth : {true, false}) {
    Generator generator(20);
    std::vector<BatchSample> motion = generator.RigidMotion(100, 3, 6);
    const Vector3d a = generator.Inside(0.3), b = generator.Inside(0.3);
    for (std::size_t i = 0; smooth && i < motion.size(); ++i) {
      const double t = 3.0 * static_cast<double>(i) / 100.0;
      const Vector3d shift = std::cos(t) * a + std::sin(t) * b;
      motion[i].p_W = {shift, shift + Vector3d(0.05, 0.02 * t, 0.0), shift + Vector3d(0, 0, 0.1)};
    }
    const BatchScene scene(motion, BatchBody::kFree);
    EXPECT_LT(scene.hull_size(), 300);
    constexpr int kCameras = 200;
    BatchCameras cameras;
    cameras.Resize(kCameras);
    std::vector<Isometry3d> poses;
    std::vector<double> zooms;
    for (int i = 0; i < kCameras; ++i) {
      poses.push_back(generator.Camera());
      zooms.push_back(generator.Uniform(0.5, 2.0));
      cameras.Set(i, poses.back(), zooms.back());
    }
    BatchLens lens;
    lens.x_min = -0.5;
    lens.x_max = 0.6;
    lens.y_min = -0.4;
    lens.y_max = 0.3;
    const DepthLimits limits{0.9, 3.0};
    const double slack = smooth ? 0.02 : 10.0;
    for (const BatchIsa isa : AvailableIsas()) {
      BatchMargins margins, rough, one;
      const BatchEvaluator evaluator(isa);
      evaluator.CheckFrustum(scene, cameras, 0, kCameras, lens, limits, BatchPrecision::kDouble,
                             &margins);
      evaluator.CheckFrustum(scene, cameras, 0, kCameras, lens, limits, BatchPrecision::kSingle,
                             &rough);
      int near = 0, far = 0, image = 0;
      for (int i = 0; i < kCameras; ++i) {
        SCOPED_TRACE(Name(isa) + ", camera " + std::to_string(i));
        const Margins exact = PlainMargins(motion, poses[i], zooms[i], lens, limits);
        near += exact.near > 0.0 ? 1 : 0;
        far += exact.far > 0.0 ? 1 : 0;
        image += exact.image > 0.0 ? 1 : 0;
        ExpectMargin(margins.near[i], exact.near, 1e-9, slack);
        ExpectMargin(margins.far[i], exact.far, 1e-9, slack);
        ExpectMargin(margins.image[i], exact.image, 1e-8, 6.0 * slack);
        ExpectMargin(rough.near[i], exact.near, 1e-4, slack);
        ExpectMargin(rough.far[i], exact.far, 1e-4, slack);
        ExpectMargin(rough.image[i], exact.image, 1e-3, 6.0 * slack);
        // Neighbours in a batch do not matter.
        evaluator.CheckFrustum(scene, cameras, i, 1, lens, limits, BatchPrecision::kDouble, &one);
        EXPECT_EQ(one.near[0], margins.near[i]);
        EXPECT_EQ(one.far[0], margins.far[i]);
        EXPECT_EQ(one.image[0], margins.image[i]);
        // What a marker's size takes is taken before the margin is judged, not after: exact about 0 all the same.
        const double size = std::max(0.0, exact.image - 0.001 * (i % 3));
        evaluator.CheckFrustum(scene, cameras, i, 1, lens, limits, BatchPrecision::kDouble, &one,
                               size);
        ExpectMargin(one.image[0], exact.image - size, 1e-8, 6.0 * slack);
      }
      for (const int inside : {near, far, image}) {  // of both kinds
        EXPECT_GT(inside, 4);
        EXPECT_LT(inside, kCameras - 4);
      }
    }
  }
}

// The field of view is the pixels' rectangle less the margin.
TEST(BatchFrustum, LensOfACameraIsItsImageLessTheMargin) {
  CameraModel camera;
  camera.u0 = 300.0;
  camera.v0 = 250.0;
  const BatchLens lens = BatchLens::FromCamera(camera, 20.0);
  EXPECT_NEAR(lens.x_min, (20.0 - 300.0) / 600.0, 1e-12);
  EXPECT_NEAR(lens.x_max, (639.0 - 20.0 - 300.0) / 600.0, 1e-12);
  EXPECT_NEAR(lens.y_min, (20.0 - 250.0) / 600.0, 1e-12);
  EXPECT_NEAR(lens.y_max, (479.0 - 20.0 - 250.0) / 600.0, 1e-12);
  EXPECT_EQ(lens.fx, camera.fx);
  EXPECT_EQ(test::ConfigErrorOf([&] { (void)BatchLens::FromCamera(camera, 300.0); }),
            "batch.margin: must leave some of the image, is 300.000000 px");
}

TEST(BatchFrustum, LensWithDistortionStaysInsideTheCurvedBorder) {
  CameraModel camera;
  camera.distortion.k1 = -0.25;
  camera.distortion.k2 = 0.05;
  const BatchLens lens = BatchLens::FromCamera(camera, 10.0);
  for (int i = 0; i <= 40; ++i) {
    const double s = i / 40.0;
    const double x = lens.x_min + s * (lens.x_max - lens.x_min);
    const double y = lens.y_min + s * (lens.y_max - lens.y_min);
    for (const Eigen::Vector2d& n :
         {Eigen::Vector2d(x, lens.y_min), Eigen::Vector2d(x, lens.y_max),
          Eigen::Vector2d(lens.x_min, y), Eigen::Vector2d(lens.x_max, y)}) {
      EXPECT_TRUE(InImage(camera, ToPixel(camera, n), 10.0 - 0.01)) << n.transpose();
    }
  }
}

// Least distance from the segment to the capsule's axis, by brute force.
double AxisDistance(const Vector3d& a, const Vector3d& b, const BatchCapsule& capsule) {
  double best = 1e9;
  for (int i = 0; i <= 2000; ++i) {
    const Vector3d p = a + (i / 2000.0) * (b - a);
    const Vector3d axis = capsule.p_WB - capsule.p_WA;
    const double length2 = axis.squaredNorm();
    const double t = length2 > 0.0 ? (p - capsule.p_WA).dot(axis) / length2 : 0.0;
    best = std::min(best, (p - capsule.p_WA - std::min(1.0, std::max(0.0, t)) * axis).norm());
  }
  return best;
}

TEST(BatchObstacles, CapsuleMarginIsTheDistanceToItsSkin) {
  Generator generator(30);
  constexpr int kCameras = 64;
  BatchCameras cameras;
  cameras.Resize(kCameras);
  std::vector<Vector3d> centres;
  for (int i = 0; i < kCameras; ++i) {
    const Isometry3d X_WC = generator.Camera();
    cameras.Set(i, X_WC);
    centres.push_back(X_WC.translation());
  }
  for (int trial = 0; trial < 40; ++trial) {
    BatchSight sight;
    sight.p_W = generator.Inside(0.3);
    BatchCapsule capsule{generator.Inside(0.8), generator.Inside(0.8),
                         generator.Uniform(0.02, 0.2)};
    if (trial % 8 == 0) capsule.p_WB = capsule.p_WA;                                   // a ball
    if (trial % 8 == 1) capsule.p_WB = capsule.p_WA + 2.0 * (centres[0] - sight.p_W);  // parallel
    sight.capsules = {capsule};
    const BatchObstacles obstacles({sight}, {}, 4.0, 2.0);
    for (const BatchIsa isa : AvailableIsas()) {
      BatchMargins margins, rough;
      BatchEvaluator(isa).CheckObstacles(obstacles, cameras, 0, kCameras, BatchPrecision::kDouble,
                                         &margins);
      BatchEvaluator(isa).CheckObstacles(obstacles, cameras, 0, kCameras, BatchPrecision::kSingle,
                                         &rough);
      for (int i = 0; i < kCameras; ++i) {
        const double d = AxisDistance(sight.p_W, centres[i], capsule);
        const double r = capsule.radius;
        const double expected = (d * d - r * r) / (2.0 * r);
        // The brute force steps along the ray by some 1 mm.
        EXPECT_NEAR(margins.occlusion[i], expected, 2e-3 * (1.0 + d) / (2.0 * r) * 0.01 + 1e-5 / r)
            << Name(isa) << ", trial " << trial << ", camera " << i;
        EXPECT_NEAR(rough.occlusion[i], margins.occlusion[i], 2e-5 / r)
            << Name(isa) << ", trial " << trial << ", camera " << i;
      }
    }
  }
}

// The segment enters the box, by brute force.
bool MeetsBox(const Vector3d& a, const Vector3d& b, const BatchBox& box) {
  for (int i = 0; i <= 4000; ++i) {
    const Vector3d p = box.X_WB.inverse() * (a + (i / 4000.0) * (b - a));
    if ((p.cwiseAbs() - box.half).maxCoeff() <= 0.0) return true;
  }
  return false;
}

TEST(BatchObstacles, BoxMarginIsNegativeExactlyWhereTheRayMeetsTheBox) {
  Generator generator(31);
  constexpr int kCameras = 64;
  BatchCameras cameras;
  cameras.Resize(kCameras);
  std::vector<Vector3d> centres;
  for (int i = 0; i < kCameras; ++i) {
    const Isometry3d X_WC = generator.Camera();
    cameras.Set(i, X_WC);
    centres.push_back(X_WC.translation());
  }
  int met = 0, free = 0;
  for (int trial = 0; trial < 20; ++trial) {
    BatchSight sight;
    sight.p_W = generator.Inside(0.2);
    BatchBox box;
    box.X_WB.translation() = 0.7 * generator.Inside(1.0).normalized();
    box.X_WB.linear() =
        Eigen::AngleAxisd(generator.Uniform(-3.0, 3.0), generator.Inside(1.0).normalized())
            .toRotationMatrix();
    box.half = {generator.Uniform(0.05, 0.4), generator.Uniform(0.05, 0.4),
                generator.Uniform(0.05, 0.4)};
    const BatchObstacles obstacles({sight}, {box}, 4.0, 2.0);
    for (const BatchIsa isa : AvailableIsas()) {
      BatchMargins margins;
      BatchEvaluator(isa).CheckObstacles(obstacles, cameras, 0, kCameras, BatchPrecision::kDouble,
                                         &margins);
      for (int i = 0; i < kCameras; ++i) {
        if (std::abs(margins.occlusion[i]) < 1e-3) continue;  // the brute force steps
        const bool meets = MeetsBox(sight.p_W, centres[i], box);
        (meets ? met : free) += 1;
        EXPECT_EQ(margins.occlusion[i] < 0.0, meets)
            << Name(isa) << ", trial " << trial << ", camera " << i << ", " << margins.occlusion[i];
      }
    }
  }
  EXPECT_GT(met, 50);
  EXPECT_GT(free, 50);
}

TEST(BatchObstacles, RefusesWhatDoesNotFit) {
  const auto refusal = [](const BatchSight& sight, int boxes, double unit) {
    return test::ConfigErrorOf(
        [&] { (void)BatchObstacles({sight}, std::vector<BatchBox>(boxes), 4.0, unit); });
  };
  BatchSight sight;
  EXPECT_EQ(refusal(sight, 16, 1.0), "nothing thrown");
  EXPECT_EQ(refusal(sight, 17, 1.0), "batch.boxes: must be 16 at most, are 17");
  EXPECT_EQ(refusal(sight, 1, 0.0), "batch.unit: must be > 0 m, is 0.000000");
  sight.capsules = {{Vector3d::Zero(), Vector3d::UnitX(), 0.0}};
  EXPECT_EQ(refusal(sight, 1, 1.0), "batch.capsules: must have a radius > 0 m, one has 0.000000");
}

TEST(BatchCameras, TurnedAndMovedIsAsSet) {
  Generator generator(33);
  BatchCameras from, turned, expected;
  const std::vector<Isometry3d> poses{generator.Camera(), generator.Camera()};
  from.Resize(2);
  for (int i = 0; i < 2; ++i) from.Set(i, poses[i], 1.0 + i);
  const std::vector<int> source{1, 0, 1};
  turned.Turn(from, source);
  ASSERT_EQ(turned.size(), 3);
  expected.Resize(3);
  for (int i = 0; i < 3; ++i) {
    Isometry3d X_WC = poses[source[i]];
    X_WC.translation() = generator.Inside(1.0);
    turned.Move(i, X_WC.translation());
    expected.Set(i, X_WC, 1.0 + source[i]);
  }
  for (int f = 0; f <= 12; ++f) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(turned.field(f)[i], expected.field(f)[i]) << f;
  }
}

TEST(BatchObstacles, FacingMarginIsPositiveInsideTheCone) {
  Generator generator(32);
  constexpr int kCameras = 40;
  BatchCameras cameras;
  cameras.Resize(kCameras);
  std::vector<Vector3d> centres;
  for (int i = 0; i < kCameras; ++i) {
    const Isometry3d X_WC = generator.Camera();
    cameras.Set(i, X_WC);
    centres.push_back(X_WC.translation());
  }
  BatchSight one, two;
  one.normal_W = generator.Inside(1.0).normalized();
  two.p_W = generator.Inside(0.3);
  two.normal_W = (one.normal_W + 0.2 * generator.Inside(1.0)).normalized();
  const double limit = 1.2;
  const BatchObstacles obstacles({one, two}, {}, limit);
  for (const BatchIsa isa : AvailableIsas()) {
    BatchMargins margins;
    BatchEvaluator(isa).CheckObstacles(obstacles, cameras, 0, kCameras, BatchPrecision::kDouble,
                                       &margins);
    for (int i = 0; i < kCameras; ++i) {
      double expected = 1e9;
      for (const BatchSight& sight : {one, two}) {
        const Vector3d ray = centres[i] - sight.p_W;
        expected = std::min(expected, sight.normal_W.dot(ray) - std::cos(limit) * ray.norm());
      }
      EXPECT_NEAR(margins.facing[i], expected, 1e-12) << Name(isa);
      EXPECT_GT(margins.occlusion[i], 1e6);  // nothing in the way
    }
  }
}

}  // namespace
}  // namespace vantage
