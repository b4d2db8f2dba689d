// Section 6: the planar arm's closed forms, Figs. 3 and 4.
#include <algorithm>
#include <cmath>
#include <random>

#include "paper_cells.h"

namespace vantage::test {
namespace {

constexpr double kTableTolerance = 1e-12;  // of the figures' values

// One value of a figure's table.
void ExpectTableValue(double actual, double expected) {
  EXPECT_NEAR(actual, expected, kTableTolerance * std::max(expected, 1e-3));
}

class Planar : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!Oracles().contains("planar")) GTEST_SKIP() << "no such section in this file";
  }
  [[nodiscard]] static Node section() { return Oracles().at("planar"); }

  // Random pose, links, camera; the test of a closed form.
  template <typename F>
  static void ForRandomCells(RigOrientation orientation, F&& f) {
    std::mt19937 random(31);
    std::uniform_real_distribution<double> unit(0.0, 1.0);
    for (int trial = 0; trial < 50; ++trial) {
      const double l1 = 5.0 + 5.0 * unit(random);
      const double l2 = 5.0 + 5.0 * unit(random);
      const double focal = 0.5 + 2.0 * unit(random);
      const JointVector q = Joints({6.0 * unit(random) - 3.0, 6.0 * unit(random) - 3.0});
      const Sphere camera{30.0 + 20.0 * unit(random), unit(random), 6.0 * unit(random)};
      f(l1, l2, focal, q, camera, At(PointCell(PlanarArm(l1, l2), orientation, focal), q, camera));
    }
  }
};

TEST_F(Planar, ArmInThePapersConvention) {
  ForRandomCells(RigOrientation::kFixedDown, [](double l1, double l2, double, const JointVector& q,
                                                const Sphere&, const Evaluated& e) {
    const double s1 = std::sin(q(0));
    const double c1 = std::cos(q(0));
    const double s12 = std::sin(q(0) + q(1));
    const double c12 = std::cos(q(0) + q(1));
    const Eigen::Vector3d P(l1 * s1 + l2 * s12, l1 * c1 + l2 * c12, 0.0);
    EXPECT_NEAR((e.kinematics.X_WE.translation() - P).norm(), 0.0, 1e-13);
    Eigen::Matrix2d J_r;
    J_r << l1 * c1 + l2 * c12, l2 * c12, -l1 * s1 - l2 * s12, -l2 * s12;
    EXPECT_TRUE(JacobianNear(e.kinematics.J_WE_W.topRows<2>(), J_r));
    EXPECT_NEAR(J_r.determinant(), -l1 * l2 * std::sin(q(1)), 1e-12 * l1 * l2);
    EXPECT_NEAR(ProductOf(e, 2).arm.w, l1 * l2 * std::abs(std::sin(q(1))), 1e-12 * l1 * l2);
  });
}

TEST_F(Planar, FixedOrientationHasTheDiagonalImageJacobian) {
  ForRandomCells(RigOrientation::kFixedDown, [](double, double, double f, const JointVector&,
                                                const Sphere& camera, const Evaluated& e) {
    const double share = f / (camera.R * std::cos(camera.theta));
    const PaperProduct paper = ProductOf(e, 2);
    EXPECT_TRUE(
        JacobianNear(paper.J_v, Eigen::Vector2d(share, -share).asDiagonal().toDenseMatrix()));
    EXPECT_TRUE(RelativelyNear(paper.view.w, share * share, 1e-12));
    EXPECT_TRUE(paper.exact);
    EXPECT_TRUE(RelativelyNear(e.composite.w, paper.product, kMeasureTolerance));
  });
}

TEST_F(Planar, LookingAtTheOrigin) {
  ForRandomCells(RigOrientation::kLookAt, [](double, double, double f, const JointVector&,
                                             const Sphere& camera, const Evaluated& e) {
    const Eigen::Vector3d P = e.kinematics.X_WE.translation();
    const double depth = camera.R - std::sin(camera.theta) * (P.x() * std::cos(camera.phi) +
                                                              P.y() * std::sin(camera.phi));
    const double w_v = f * f * camera.R * std::cos(camera.theta) / std::pow(depth, 3);
    EXPECT_TRUE(RelativelyNear(ProductOf(e, 2).view.w, w_v, 1e-12));
    // f² d / Z³ of any camera: d its distance from the plane of the motion.
    EXPECT_TRUE(RelativelyNear(
        w_v, f * f * e.X_WC.translation().z() / std::pow(e.views[0].image.depth, 3), 1e-12));
  });
}

TEST_F(Planar, Fig3) {
  const Node fig = section().at("fig3");
  const OracleCase cell =
      PointCell(PlanarArm(fig.at("l1"), fig.at("l2")), RigOrientation::kFixedDown, fig.at("f"));
  // w_c does not depend on theta1 or phi: the figure leaves them open.
  const auto w_c = [&](double R, double theta) {
    const double expected = At(cell, Joints({0.0, fig.at("theta2")}), {R, theta, 0.0}).composite.w;
    const double other = At(cell, Joints({1.3, fig.at("theta2")}), {R, theta, 2.0}).composite.w;
    EXPECT_TRUE(RelativelyNear(other, expected, kMeasureTolerance));
    return expected;
  };
  for (const Node& sample : fig.at("samples").elements()) {
    ExpectTableValue(w_c(sample.at("R"), sample.at("theta")), sample.at("w_c"));
  }
  ExpectTableValue(w_c(fig.at("argmax").at("R"), fig.at("argmax").at("theta")), fig.at("max"));
  ExpectTableValue(w_c(fig.at("argmin").at("R"), fig.at("argmin").at("theta")), fig.at("min"));
  double max = 0.0;
  double min = 1e9;
  for (const double R : Linspace(30.0, 40.0, 21)) {
    for (const double theta : Linspace(0.0, kPi / 3, 21)) {
      max = std::max(max, w_c(R, theta));
      min = std::min(min, w_c(R, theta));
    }
  }
  ExpectTableValue(max, fig.at("max"));
  ExpectTableValue(min, fig.at("min"));
}

TEST_F(Planar, Fig4) {
  const Node fig = section().at("fig4");
  const OracleCase cell =
      PointCell(PlanarArm(fig.at("l1"), fig.at("l2")), RigOrientation::kFixedDown, fig.at("f"));
  const auto w_c = [&](double theta, double theta2) {
    return At(cell, Joints({0.4, theta2}), {fig.at("R"), theta, 0.7}).composite.w;
  };
  for (const Node& sample : fig.at("samples").elements()) {
    ExpectTableValue(w_c(sample.at("theta"), sample.at("theta2")), sample.at("w_c"));
  }
  ExpectTableValue(w_c(fig.at("argmax").at("theta"), fig.at("argmax").at("theta2")), fig.at("max"));
  double max = 0.0;
  double min = 1e9;
  for (const double theta : Linspace(0.0, kPi / 3, 21)) {
    for (const double theta2 : Linspace(0.0, kPi, 25)) {
      max = std::max(max, w_c(theta, theta2));
      min = std::min(min, w_c(theta, theta2));
      // The ridge over theta is the border theta = pi/3.
      EXPECT_LE(w_c(theta, theta2), w_c(kPi / 3, theta2) * (1.0 + kTableTolerance) + 1e-15);
    }
  }
  ExpectTableValue(max, fig.at("max"));
  ExpectTableValue(min, fig.at("min"));
}

}  // namespace
}  // namespace vantage::test
