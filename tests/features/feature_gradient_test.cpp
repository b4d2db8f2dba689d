// Every kind of feature, camera beside the arm and on it: the gradients of a number made of J_c or J_v
// against central differences of that number.
#include "vantage/features/feature_gradient.h"

#include <algorithm>
#include <random>

#include <gtest/gtest.h>

#include "eigen_matchers.h"
#include "feature_examples.h"
#include "finite_difference.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

using test::kExamplePoints;

// Three revolute and two prismatic joints in general position.
ArmModel Arm(DhConvention convention) {
  constexpr JointKind kTurn = JointKind::kRevolute;
  constexpr JointKind kShift = JointKind::kPrismatic;
  const std::vector<DhRow> rows{{kTurn, 0.0, 0.3, 0.1, 0.7, 0.2},
                                {kShift, 0.4, 0.0, 0.2, -0.6, 0.1},
                                {kTurn, 0.0, 0.1, 0.3, 1.1, -0.3},
                                {kTurn, 0.0, -0.1, 0.2, -0.8, 0.0},
                                {kShift, -0.5, 0.0, 0.1, 0.4, 0.2}};
  Isometry3d X_WBase = Isometry3d::Identity();
  X_WBase.translate(Vector3d(0.1, -0.2, 0.3)).rotate(Eigen::AngleAxisd(0.4, Vector3d::UnitY()));
  Isometry3d X_LastE = Isometry3d::Identity();
  X_LastE.translate(Vector3d(0.05, 0.1, 0.15)).rotate(Eigen::AngleAxisd(0.6, Vector3d::UnitX()));
  return ArmModel("arm", convention, rows,
                  std::vector<JointLimits>(rows.size(), {-10.0, 10.0, 1.0, 10.0}), X_WBase,
                  X_LastE);
}

// All that J_c and J_v depend on.
struct Cell {
  ArmModel arm;
  FeatureSet set;
  CameraModel camera;
  bool eye_in_hand;
  Isometry3d X;  // camera in W, or in E
  JointVector q;
  std::vector<Vector3d> p;  // in E or in W
  std::vector<bool> on_body;
};

struct Evaluated {
  PointViews views;
  FeatureRows rows;
  ViewGeometry geometry;
  FeatureJacobian J_v;
  TaskJacobian J_c;
};

Evaluated Evaluate(const Cell& cell) {
  Evaluated e;
  const Kinematics k = ComputeKinematics(cell.arm, cell.q);
  e.geometry = {cell.eye_in_hand ? k.X_WE * cell.X : cell.X, k.X_WE.translation(), k.J_WE_W,
                cell.eye_in_hand};
  for (std::size_t i = 0; i < cell.p.size(); ++i) {
    const Vector3d p_WP = cell.on_body[i] ? Vector3d(k.X_WE * cell.p[i]) : cell.p[i];
    e.views.push_back(ViewOf(e.geometry.X_WC.inverse() * p_WP, cell.on_body[i]));
  }
  cell.set.Evaluate(cell.camera, e.views, &e.rows);
  e.J_v = cell.eye_in_hand ? ImageJacobianEyeInHand(e.rows, e.geometry.X_WC, e.geometry.p_WE)
                           : ImageJacobian(e.rows.L_body, e.geometry.X_WC, e.geometry.p_WE);
  e.J_c = e.J_v * k.J_WE_W;
  return e;
}

// The first `moving` points move before the camera when the joints do.
Cell RandomCell(std::mt19937* random, std::vector<Feature> features, bool eye_in_hand,
                int moving = kExamplePoints) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  std::uniform_real_distribution<double> depth(0.8, 2.0);
  Cell cell{Arm(unit(*random) > 0.0 ? DhConvention::kStandard : DhConvention::kModified),
            FeatureSet(std::move(features), kExamplePoints),
            test::SkewedCamera(),
            eye_in_hand,
            Isometry3d::Identity(),
            JointVector(5),
            {},
            {}};
  cell.X = Advance(cell.X, test::RandomStep(random, 1.0));
  for (int i = 0; i < 5; ++i) cell.q(i) = unit(*random);
  const Isometry3d X_WE = EndEffectorPose(cell.arm, cell.q);
  const Isometry3d X_WC = eye_in_hand ? X_WE * cell.X : cell.X;
  int i = 0;
  for (const Vector3d& ray : test::RandomRays(random)) {
    cell.on_body.push_back((i++ < moving) != eye_in_hand);
    const Vector3d p_WP = X_WC * (depth(*random) * ray);
    cell.p.push_back(cell.on_body.back() ? Vector3d(X_WE.inverse() * p_WP) : p_WP);
  }
  return cell;
}

// The cell after steps of everything: camera (6), fx, skew, fy, joints.
Cell Moved(Cell cell, const VectorXd& step) {
  cell.X = Advance(cell.X, step.head<6>());
  cell.camera.fx += step(6);
  cell.camera.skew += step(7);
  cell.camera.fy += step(8);
  cell.q += step.tail(cell.arm.size());
  return cell;
}

VectorXd AsVector(const ViewGradient& g) {
  VectorXd all(9 + g.joints.size());
  all << g.camera, g.calibration(0, 0), g.calibration(0, 1), g.calibration(1, 1), g.joints;
  return all;
}

// φ = <weights, J>: every entry of J counts.
template <typename JacobianOf, typename GradientOf>
void ExpectGradient(const Cell& cell, JacobianOf&& jacobian, GradientOf&& gradient,
                    std::mt19937* random) {
  const Evaluated here = Evaluate(cell);
  ASSERT_EQ(here.rows.size(), static_cast<int>(cell.set.features().size()));
  const MatrixXd J = jacobian(here);
  TaskJacobian weights(J.rows(), J.cols());
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (Eigen::Index i = 0; i < J.size(); ++i) weights(i) = unit(*random);
  const auto all = static_cast<int>(9 + cell.arm.size());
  const auto phi_at = [&](const VectorXd& step) {
    const MatrixXd moved = jacobian(Evaluate(Moved(cell, step)));
    return Eigen::Vector2d(weights.cwiseProduct(moved).sum(), 0.0);  // two: gcc 12 warns of one
  };
  const VectorXd numeric = test::CentralDifference(phi_at, 2, all).row(0);
  const VectorXd actual = AsVector(gradient(here, weights));
  const double scale = std::max(numeric.cwiseAbs().maxCoeff(), J.cwiseAbs().maxCoeff());
  EXPECT_TRUE(test::Near(actual, numeric, 1e-6 * scale));
  EXPECT_GT(J.cwiseAbs().maxCoeff(), 0.0);
}

class EveryKindGradient : public ::testing::TestWithParam<FeatureKind> {};

INSTANTIATE_TEST_SUITE_P(Features, EveryKindGradient, ::testing::ValuesIn(AllFeatureKinds()),
                         [](const auto& test) { return NameOf(test.param); });

TEST_P(EveryKindGradient, ThroughCompositeAndViewMatchCentralDifferences) {
  std::mt19937 random(61);
  for (const bool eye_in_hand : {false, true}) {
    for (const int moving : {kExamplePoints, 2}) {
      for (int trial = 0; trial < 5; ++trial) {
        SCOPED_TRACE(::testing::Message()
                     << (eye_in_hand ? "in hand, " : "beside, ") << moving << " points move");
        const Cell cell = RandomCell(&random, {test::Example(GetParam())}, eye_in_hand, moving);
        ExpectGradient(
            cell, [](const Evaluated& e) -> MatrixXd { return e.J_c; },
            [&](const Evaluated& e, const TaskJacobian& weights) {
              return GradientThroughComposite(cell.set, cell.camera, e.views, e.rows, e.geometry,
                                              weights);
            },
            &random);
        ExpectGradient(
            cell, [](const Evaluated& e) -> MatrixXd { return e.J_v; },
            [&](const Evaluated& e, const TaskJacobian& weights) {
              return GradientThroughView(cell.set, cell.camera, e.views, e.rows, e.geometry,
                                         weights);
            },
            &random);
      }
    }
  }
}

// All kinds at once, over points on both sides.
TEST(ViewGradient, OfManyRowsMatchesCentralDifferences) {
  std::mt19937 random(62);
  std::vector<Feature> features;
  for (const FeatureKind kind : AllFeatureKinds()) features.push_back(test::Example(kind));
  for (const bool eye_in_hand : {false, true}) {
    const Cell cell = RandomCell(&random, features, eye_in_hand, 3);
    ExpectGradient(
        cell, [](const Evaluated& e) -> MatrixXd { return e.J_c; },
        [&](const Evaluated& e, const TaskJacobian& weights) {
          return GradientThroughComposite(cell.set, cell.camera, e.views, e.rows, e.geometry,
                                          weights);
        },
        &random);
  }
}

// Rows that are not there have no share: a point behind the camera takes only its own away.
TEST(ViewGradient, OfTheRowsThatAreThere) {
  std::mt19937 random(63);
  const std::vector<Feature> both{{FeatureKind::kPointX, {0}}, {FeatureKind::kDistance, {1, 2}}};
  Cell cell = RandomCell(&random, both, false);
  const Evaluated all = Evaluate(cell);
  const TaskJacobian weights = TaskJacobian::Ones(2, 5);
  const TaskJacobian last = TaskJacobian::Ones(1, 5);
  TaskJacobian only_last = weights;
  only_last.row(0).setZero();
  PointViews views = all.views;
  views[0] = ViewOf(Vector3d(0.0, 0.0, -1.0), true);
  FeatureRows rows;
  cell.set.Evaluate(cell.camera, views, &rows);
  ASSERT_EQ(rows.size(), 1);
  EXPECT_EQ(rows.status[0], RowStatus::kBehindCamera);
  const ViewGradient fewer =
      GradientThroughComposite(cell.set, cell.camera, views, rows, all.geometry, last);
  const ViewGradient expected =
      GradientThroughComposite(cell.set, cell.camera, all.views, all.rows, all.geometry, only_last);
  EXPECT_TRUE(test::Near(AsVector(fewer), AsVector(expected), 1e-9));
  EXPECT_GT(fewer.camera.norm(), 0.0);
}

TEST(ViewGradient, OfNoRowsIsZero) {
  std::mt19937 random(64);
  Cell cell = RandomCell(&random, {{FeatureKind::kPointX, {0}}}, false);
  const Evaluated all = Evaluate(cell);
  PointViews views = all.views;
  for (PointView& view : views) view.visible = false;
  FeatureRows rows;
  cell.set.Evaluate(cell.camera, views, &rows);
  const ViewGradient none = GradientThroughComposite(cell.set, cell.camera, views, rows,
                                                     all.geometry, TaskJacobian(0, 5));
  EXPECT_TRUE(AsVector(none).isZero(0.0));
  EXPECT_EQ(none.joints.size(), 5);
}

}  // namespace
}  // namespace vantage
