// Section 7: the PUMA-type arms' closed forms, Figs. 6 and 7, and the dolly zoom.
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "paper_cells.h"

namespace vantage::test {
namespace {

class Puma : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!Oracles().contains("puma")) GTEST_SKIP() << "no such section in this file";
  }
  [[nodiscard]] static Node section() { return Oracles().at("puma"); }
};

class Draw {
 public:
  double operator()(double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random_);
  }

 private:
  std::mt19937 random_{41};
};

TEST_F(Puma, SimpleArm) {
  Draw draw;
  for (int trial = 0; trial < 50; ++trial) {
    const double l2 = draw(5, 10);
    const double l3 = draw(5, 10);
    const double h = draw(0, 4);
    const JointVector q = Joints({draw(-3, 3), draw(-3, 3), draw(-3, 3)});
    const Kinematics k = ComputeKinematics(SimplePuma(l2, l3, h), q);
    const double s23 = std::sin(q(1) + q(2));
    const double r = l2 * std::cos(q(1)) + l3 * std::cos(q(1) + q(2));
    const Eigen::Vector3d P(std::cos(q(0)) * r, std::sin(q(0)) * r,
                            h + l2 * std::sin(q(1)) + l3 * s23);
    EXPECT_NEAR((k.X_WE.translation() - P).norm(), 0.0, 1e-13);
    EXPECT_NEAR(k.J_WE_W.topRows<3>().determinant(), -l2 * l3 * std::sin(q(2)) * r, 1e-11 * 2000);
  }
}

TEST_F(Puma, WristCentreOfThePuma560) {
  const Node parameters = section().at("puma560_wrist_centre").at("params");
  const double a2 = parameters.at("a2");
  const double a3 = parameters.at("a3");
  const double d3 = parameters.at("d3");
  const double d4 = parameters.at("d4");
  Draw draw;
  for (int trial = 0; trial < 50; ++trial) {
    const JointVector q = Joints({draw(-3, 3), draw(-3, 3), draw(-3, 3)});
    const Kinematics k = ComputeKinematics(Puma560ToWrist(a2, a3, d3, d4), q);
    const double s1 = std::sin(q(0));
    const double c1 = std::cos(q(0));
    const double s23 = std::sin(q(1) + q(2));
    const double c23 = std::cos(q(1) + q(2));
    const double r = a2 * std::cos(q(1)) + a3 * c23 - d4 * s23;
    const Eigen::Vector3d P(c1 * r + d3 * s1, s1 * r - d3 * c1,
                            a2 * std::sin(q(1)) + a3 * s23 + d4 * c23);
    EXPECT_NEAR((k.X_WE.translation() - P).norm(), 0.0, 1e-15);
    EXPECT_NEAR(k.J_WE_W.topRows<3>().determinant(),
                -a2 * (a3 * std::sin(q(2)) + d4 * std::cos(q(2))) * r, 1e-15);
  }
}

// The notes' formula for the translation-only w_v of (x1, y1, x2).
TEST_F(Puma, TranslationOnlyObservability) {
  Draw draw;
  for (int trial = 0; trial < 50; ++trial) {
    const double f = draw(0.5, 2.0);
    const Evaluated e = At(TwoPointCell(SimplePuma(10, 10, 0), {1.0, 2.0, 1.0}, f),
                           Joints({draw(-1, 1), draw(-1, 1), draw(-1, 1)}),
                           {draw(35, 60), draw(0, 1.5), draw(-3, 3), draw(-3, 3)});
    const ImagePoint& one = e.views[0].image;
    const ImagePoint& two = e.views[1].image;
    const double w_v =
        f * f * f * std::abs(one.n.x() - two.n.x()) / (one.depth * one.depth * two.depth);
    const PaperProduct paper = ProductOf(e, 3);
    EXPECT_NEAR(paper.view.w, w_v, 1e-9 * w_v + 1e-12 * std::pow(paper.view.sigma(0), 3));
  }
}

// w_c(roll) = |A cos(roll) + B sin(roll)| with A = det of (x1, y1, x2), B = det of (x1, y1, y2): for
// each camera position some roll gives 0.
TEST_F(Puma, RollLaw) {
  Draw draw;
  for (int trial = 0; trial < 50; ++trial) {
    const OracleCase three = TwoPointCell(SimplePuma(10, 10, 0), {1.0, 2.0, 1.0}, 1.0);
    const OracleCase four = TwoPointCell(SimplePuma(10, 10, 0), {1.0, 2.0, 1.0}, 1.0, true);
    const JointVector q = Joints({draw(-1, 1), draw(-1, 1), draw(-1, 1)});
    const Sphere level{draw(35, 60), draw(0, 1.5), draw(-3, 3), 0.0};
    const Eigen::MatrixXd J_c = At(four, q, level).J_c;
    const double A = Eigen::Matrix3d(J_c.topRows<3>()).determinant();
    Eigen::Matrix3d last;
    last << J_c.topRows<2>(), J_c.row(3);
    const double B = last.determinant();
    const double scale = std::hypot(A, B);
    for (const double roll : {0.0, 0.7, 2.0, -1.4}) {
      Sphere camera = level;
      camera.roll = roll;
      const double expected = std::abs(A * std::cos(roll) + B * std::sin(roll));
      EXPECT_NEAR(At(three, q, camera).composite.w, expected, 1e-10 * scale);
      EXPECT_TRUE(RelativelyNear(At(four, q, camera).composite.w, At(four, q, level).composite.w,
                                 kMeasureTolerance));
    }
    Sphere blind = level;
    blind.roll = std::atan2(-A, B);
    EXPECT_LE(At(three, q, blind).composite.w, 1e-10 * scale);
  }
}

// A quantity of Figs. 6 and 7, with what rounding may leave of it.
struct Value {
  double w{0.0};
  double floor{0.0};
};

Value Of(const Measure& measure) {
  return {measure.w, kSigmaTolerance * std::pow(measure.sigma(0), measure.size())};
}

// The figure's four surfaces at one node.
Value SurfaceAt(const std::string& name, const ArmModel& arm, const Eigen::Vector3d& p_EP2,
                const JointVector& q, Sphere camera) {
  const OracleCase three = TwoPointCell(arm, p_EP2, 1.0);
  if (name == "wc") return Of(At(three, q, camera).composite);
  if (name == "wc_tr") {
    const PaperProduct paper = ProductOf(At(three, q, camera), 3);
    const Value view = Of(paper.view);
    const Value moved = Of(paper.arm);
    return {paper.product, view.floor * moved.w + view.w * moved.floor +
                               view.floor * moved.floor / kSigmaTolerance};
  }
  if (name == "wc_rollmax") {
    const Value A = Of(At(three, q, camera).composite);
    camera.roll += kPi / 2;
    const Value B = Of(At(three, q, camera).composite);
    return {std::hypot(A.w, B.w), A.floor + B.floor};
  }
  if (name == "w4") return Of(At(TwoPointCell(arm, p_EP2, 1.0, true), q, camera).composite);
  ADD_FAILURE() << "no such surface: " << name;
  return {};
}

struct Surface {
  std::string figure, name;
  ArmModel arm;
  Eigen::Vector3d p_EP2;
  double R;                   // of Figs. 6a and 7
  std::vector<double> radii;  // of Fig. 6b

  [[nodiscard]] std::vector<double> Rows() const {
    return figure == "fig6b" ? radii : Linspace(0.0, kPi / 2, 31);
  }
  [[nodiscard]] std::vector<double> Columns() const {
    if (figure == "fig6a") return Linspace(0.0, 2 * kPi, 49);
    if (figure == "fig6b") return Linspace(0.0, kPi / 2, 31);
    return Linspace(0.0, kPi, 61);
  }
  // At a node of the figure's two axes.
  [[nodiscard]] Value operator()(double row, double column) const {
    constexpr double kPose = kPi / 4;
    constexpr double kPhi = 0.6;
    const JointVector pose = Joints({kPose, kPose, kPose});
    if (figure == "fig6a") return SurfaceAt(name, arm, p_EP2, pose, {R, row, column});
    if (figure == "fig6b") return SurfaceAt(name, arm, p_EP2, pose, {row, column, kPhi});
    return SurfaceAt(name, arm, p_EP2, Joints({column, column, column}), {R, row, kPhi});
  }
  // A node as the file names it.
  [[nodiscard]] Value operator()(const Node& node) const {
    if (figure == "fig6a") return (*this)(node.at("theta"), node.at("phi"));
    if (figure == "fig6b") return (*this)(node.at("R"), node.at("theta"));
    return (*this)(node.at("theta"), node.at("t"));
  }
};

// Extremes over the grid, and the values at the nodes the file names for them.
void ExpectStatistics(const Surface& surface, const Node& expected) {
  Value max;
  Value min{1e300, 0.0};
  for (const double row : surface.Rows()) {
    for (const double column : surface.Columns()) {
      const Value value = surface(row, column);
      ASSERT_TRUE(std::isfinite(value.w));
      if (value.w > max.w) max = value;
      if (value.w < min.w) min = value;
    }
  }
  const auto near = [](const Value& value, double w) {
    EXPECT_NEAR(value.w, w, std::max(kMeasureTolerance * w, value.floor));
  };
  near(max, expected.at("max"));
  near(min, expected.at("min"));
  near(surface(expected.at("argmax")), expected.at("max"));
  near(surface(expected.at("argmin")), expected.at("min"));
}

class PumaFigure : public ::testing::TestWithParam<Entry> {};

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PumaFigure);
INSTANTIATE_TEST_SUITE_P(Oracle, PumaFigure, ::testing::ValuesIn(Entries("/puma/figures")), NameOf);

TEST_P(PumaFigure, Statistics) {
  // As "figure_parameters" of the file has them.
  const std::map<std::string, Eigen::Vector3d> offsets{{"S_inplane", {0, 2, 0}},
                                                       {"S_lateral", {0, 0, 2}},
                                                       {"S_along", {-4, 0, 0}},
                                                       {"P560_inplane", {0.1, 0, 0}},
                                                       {"P560_lateral", {0, 0.1, 0}}};
  const auto offset = offsets.find(GetParam().id);
  ASSERT_NE(offset, offsets.end()) << "an arrangement that this test does not know";
  const bool simple = GetParam().id[0] == 'S';
  const ArmModel arm =
      simple ? SimplePuma(10, 10, 0) : Puma560ToWrist(0.4318, 0.0203, 0.15005, 0.4318);
  for (const auto& [figure, surfaces] : GetParam().node.items()) {
    ASSERT_TRUE(figure == "fig6a" || figure == "fig6b" || figure == "fig7") << figure;
    for (const auto& [name, expected] : surfaces.items()) {
      SCOPED_TRACE(figure + " " + name);
      const std::vector<double> radii = simple ? Linspace(30, 60, 31) : Linspace(1.5, 4, 31);
      ExpectStatistics({figure, name, arm, offset->second, simple ? 40.0 : 2.5, radii}, expected);
    }
  }
}

}  // namespace
}  // namespace vantage::test
