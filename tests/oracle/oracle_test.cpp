// The configurations of the oracle file, each to the tolerances of its meta.
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "oracle_file.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/features/feature_gradient.h"
#include "vantage/observability/paper_product.h"

namespace vantage::test {
namespace {

TEST(OracleFile, CanBeRead) {
  EXPECT_EQ(ReadError(), "");
  EXPECT_FALSE(Oracles().raw().empty());
}

// A section that no test below knows would be passed over in silence.
TEST(OracleFile, HasNoSectionsNotJudged) {
  const std::set<std::string> known{"meta",   "cases", "algebra",  "composite_algebra",
                                    "planar", "puma",  "placement"};
  for (const auto& [section, value] : Oracles().items())
    EXPECT_EQ(known.count(section), 1U) << section;
}

TEST(OracleFile, NamesEachEntryOnce) {
  for (const char* section : {"cases", "algebra", "composite_algebra"}) {
    std::set<std::string> ids;
    const Json entries = Oracles().raw().value(section, Json::array());
    ASSERT_TRUE(entries.is_array()) << section;
    for (const Json& entry : entries) {
      EXPECT_TRUE(ids.insert(entry.at("id").get<std::string>()).second)
          << section << " " << entry["id"];
    }
  }
}

// The tolerances written into these tests are those the file asks for.
TEST(OracleFile, AsksForTheTolerancesUsed) {
  if (!Oracles().contains("meta")) return;
  const Json& tolerances = Oracles().raw().at("meta").at("tolerances");
  EXPECT_EQ(tolerances.at("feature_abs"), "1e-12*max(1,|v|)");
  EXPECT_EQ(tolerances.at("jacobian"), "max|dJ| <= 1e-11*max|J|");
  EXPECT_EQ(tolerances.at("singular_values"), "|d sigma_i| <= 1e-12*sigma_1");
  EXPECT_EQ(tolerances.at("w"),
            "relative 1e-9 if expected>0; |w| <= 1e-9*sigma_1^s if expected==0");
  EXPECT_EQ(tolerances.at("gradient_analytic"), "max|dg| <= 1e-7*max|g|");
}

class Case : public ::testing::TestWithParam<Entry> {
 protected:
  void SetUp() override {
    evaluated_ = std::make_unique<Evaluated>(Evaluate(ParseOracleCase(GetParam().node.raw())));
  }
  [[nodiscard]] const Evaluated& e() const { return *evaluated_; }
  [[nodiscard]] static Node expected() { return GetParam().node.at("expected"); }

 private:
  std::unique_ptr<Evaluated> evaluated_;
};

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Case);
INSTANTIATE_TEST_SUITE_P(Oracle, Case, ::testing::ValuesIn(Entries("/cases")), NameOf);

TEST_P(Case, ExpectsNothingNotJudged) {
  const std::set<std::string> known{"T_ee",
                                    "T_wc",
                                    "v",
                                    "uv",
                                    "depth",
                                    "J_v",
                                    "J_r",
                                    "J_c",
                                    "L_cam",
                                    "sv_v",
                                    "sv_r",
                                    "sv_c",
                                    "s_v",
                                    "s_r",
                                    "s_c",
                                    "w_v",
                                    "w_r",
                                    "w_c",
                                    "rank_v",
                                    "rank_r",
                                    "rank_c",
                                    "sigma_min_c",
                                    "cond_c",
                                    "task",
                                    "grad_wc_cam_twist",
                                    "grad_wv_cam_twist",
                                    "grad_wc_spherical",
                                    "grad_wc_q"};
  for (const auto& [key, value] : expected().items()) {
    EXPECT_TRUE(known.count(key) == 1 || value.raw().is_string()) << key;
  }
}

TEST_P(Case, Poses) {
  EXPECT_TRUE(JacobianNear(e().kinematics.X_WE.matrix(), Matrix(expected().at("T_ee"))));
  EXPECT_TRUE(JacobianNear(e().X_WC.matrix(), Matrix(expected().at("T_wc"))));
}

TEST_P(Case, ImagePoints) {
  const Eigen::VectorXd depth = Vector(expected().at("depth"));
  const Eigen::MatrixXd uv = Matrix(expected().at("uv"));
  ASSERT_EQ(depth.size(), static_cast<Eigen::Index>(e().views.size()));
  for (Eigen::Index i = 0; i < depth.size(); ++i) {
    const PointView& view = e().views[i];
    ASSERT_EQ(view.visible, depth(i) >= kMinDepth) << "point " << i;
    if (!view.visible) continue;
    EXPECT_NEAR(view.image.depth, depth(i), kFeatureTolerance * std::max(1.0, depth(i)));
    const Eigen::Vector2d pixel = ToPixel(e().input.camera.model, view.image.n);
    for (int axis = 0; axis < 2; ++axis) {
      EXPECT_NEAR(pixel(axis), uv(i, axis),
                  kFeatureTolerance * std::max(1.0, std::abs(uv(i, axis))));
    }
  }
}

TEST_P(Case, Features) {
  const Eigen::VectorXd v = Vector(expected().at("v"));
  ASSERT_EQ(e().rows.size(), v.size());
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    EXPECT_NEAR(e().rows.s(i), v(i), kFeatureTolerance * std::max(1.0, std::abs(v(i)))) << i;
  }
}

TEST_P(Case, Jacobians) {
  EXPECT_TRUE(JacobianNear(e().rows.L, Matrix(expected().at("L_cam"))));
  EXPECT_TRUE(JacobianNear(e().J_v, Matrix(expected().at("J_v"))));
  EXPECT_TRUE(JacobianNear(e().kinematics.J_WE_W, Matrix(expected().at("J_r"))));
  EXPECT_TRUE(JacobianNear(e().J_c, Matrix(expected().at("J_c"))));
}

TEST_P(Case, SingularValues) {
  EXPECT_EQ(e().view.size(), expected().at("s_v").get<int>());
  EXPECT_EQ(e().arm.size(), expected().at("s_r").get<int>());
  EXPECT_EQ(e().composite.size(), expected().at("s_c").get<int>());
  // The file lists all min(rows, columns), of which s count.
  EXPECT_TRUE(SigmaNear(MeasureOf(e().J_v, kMaxRows), expected().at("sv_v")));
  EXPECT_TRUE(SigmaNear(MeasureOf(e().kinematics.J_WE_W, kMaxRows), expected().at("sv_r")));
  EXPECT_TRUE(SigmaNear(MeasureOf(e().J_c, kMaxRows), expected().at("sv_c")));
  EXPECT_EQ(e().view.rank, expected().at("rank_v").get<int>());
  EXPECT_EQ(e().arm.rank, expected().at("rank_r").get<int>());
  EXPECT_EQ(e().composite.rank, expected().at("rank_c").get<int>());
}

TEST_P(Case, Measures) {
  EXPECT_TRUE(WNear(e().view, expected().at("w_v").get<double>()));
  EXPECT_TRUE(WNear(e().arm, expected().at("w_r").get<double>()));
  EXPECT_TRUE(WNear(e().composite, expected().at("w_c").get<double>()));
  for (const Measure* measure : {&e().view, &e().arm, &e().composite}) {
    if (measure->rank < measure->size()) continue;
    EXPECT_NEAR(measure->log_w, std::log(measure->w), 1e-12 * std::abs(measure->log_w) + 1e-12);
  }
  const Measure& c = e().composite;
  EXPECT_NEAR(c.sigma_min, expected().at("sigma_min_c").get<double>(),
              kSigmaTolerance * c.sigma(0));
  const Node condition = expected().at("cond_c");
  if (condition.is_null()) {  // no finite one
    EXPECT_LT(c.rank, c.size());
    EXPECT_GT(c.condition, 1.0 / kRankTolerance);
  } else {
    // What the tolerance of σ_s leaves of a quotient by it.
    const auto value = condition.get<double>();
    EXPECT_TRUE(RelativelyNear(c.condition, value, 2.0 * kSigmaTolerance * value));
  }
}

// Analytic gradients: of w_c by the camera's displacement, by spherical coordinates and focal length and by
// the joints, of w_v by the camera's displacement. Each to kGradientTolerance of its largest entry.
TEST_P(Case, Gradients) {
  const ViewGeometry geometry{e().X_WC, e().kinematics.X_WE.translation(), e().kinematics.J_WE_W,
                              e().input.camera.eye_in_hand};
  const int m = e().input.task_dimension;
  const OracleCamera& camera = e().input.camera;

  const LogGradient by_J_c = GradientOfLog(Decompose(e().J_c, m));
  if (e().composite.rank < e().composite.size()) {
    EXPECT_EQ(by_J_c.status, GradientStatus::kSingular);
    for (const char* name : {"grad_wc_cam_twist", "grad_wc_q", "grad_wc_spherical"}) {
      EXPECT_FALSE(expected().contains(name)) << name << " of a w_c that is 0";
    }
  } else {
    ASSERT_EQ(by_J_c.status, GradientStatus::kOk);
    const ViewGradient log_w = GradientThroughComposite(e().input.features, camera.model, e().views,
                                                        e().rows, geometry, by_J_c.by_J);
    const double w = e().composite.w;
    EXPECT_TRUE(GradientNear(w * log_w.camera, Vector(expected().at("grad_wc_cam_twist")), w));
    EXPECT_TRUE(GradientNear(w * log_w.joints, Vector(expected().at("grad_wc_q")), w));
    if (expected().contains("grad_wc_spherical")) {
      ASSERT_TRUE(camera.sphere.has_value());
      const RigVector by_rig =
          RigJacobian(camera.sphere->rig, camera.sphere->q_c).transpose() * log_w.camera;
      const Node sphere = expected().at("grad_wc_spherical");
      Eigen::VectorXd actual(5), given(5);
      actual << by_rig, log_w.calibration.trace();
      given << sphere.at("R"), sphere.at("theta"), sphere.at("phi"), sphere.at("roll"), 0.0;
      if (sphere.contains("f")) {
        given(4) = sphere.at("f");
      } else {  // no common focal length
        EXPECT_NE(camera.model.fx, camera.model.fy);
        actual(4) = 0.0;
      }
      EXPECT_TRUE(GradientNear(w * actual, given, w));
    }
  }

  const LogGradient by_J_v = GradientOfLog(Decompose(e().J_v, m));
  if (by_J_v.status != GradientStatus::kOk) {
    EXPECT_LT(e().view.rank, e().view.size());
    EXPECT_FALSE(expected().contains("grad_wv_cam_twist"));
  } else if (by_J_c.status == GradientStatus::kOk || expected().contains("grad_wv_cam_twist")) {
    const ViewGradient log_w = GradientThroughView(e().input.features, camera.model, e().views,
                                                   e().rows, geometry, by_J_v.by_J);
    EXPECT_TRUE(GradientNear(e().view.w * log_w.camera, Vector(expected().at("grad_wv_cam_twist")),
                             e().view.w));
  }
}

// The paper's 3-DOF and planar arms: translation of E's origin alone.
TEST_P(Case, TaskBlock) {
  if (!expected().contains("task")) return;
  const Node task = expected().at("task");
  const auto rows = task.at("rows").get<std::vector<int>>();
  const auto m = static_cast<int>(rows.size());
  ASSERT_EQ(task.at("m").get<int>(), m);
  for (int i = 0; i < m; ++i) ASSERT_EQ(rows[i], i) << "axes other than the first m";

  const PaperProduct paper = ComputePaperProduct(e().J_v, e().kinematics.J_WE_W, m);
  EXPECT_TRUE(JacobianNear(paper.J_v, Matrix(task.at("J_v"))));
  EXPECT_TRUE(JacobianNear(e().kinematics.J_WE_W.topRows(m), Matrix(task.at("J_r"))));
  EXPECT_TRUE(WNear(paper.view, task.at("w_v").get<double>()));
  EXPECT_TRUE(WNear(paper.arm, task.at("w_r").get<double>()));
  const auto product = task.at("product").get<double>();
  if (product > 0.0) {
    EXPECT_TRUE(RelativelyNear(paper.product, product, kMeasureTolerance));
  } else {
    EXPECT_LE(paper.product, kZeroTolerance * std::pow(paper.view.sigma(0), paper.view.size()) *
                                 std::pow(paper.arm.sigma(0), paper.arm.size()));
  }
  EXPECT_EQ(paper.exact, task.at("J_v_times_J_r_equals_J_c").get<bool>());

  const AlongArm along = ImageJacobianAlongArm(e().J_v, e().kinematics.J_WE_W, m);
  if (!task.contains("J_v_square")) {
    EXPECT_TRUE(along.status != AlongArmStatus::kOk || e().rows.size() != m)
        << "the file gives no J_v_square where there is one";
    return;
  }
  ASSERT_EQ(along.status, AlongArmStatus::kOk);
  EXPECT_TRUE(JacobianNear(along.J_v, Matrix(task.at("J_v_square"))));
  const auto w_v_square = task.at("w_v_square").get<double>();
  if (along.view.rank == along.view.size()) {
    EXPECT_TRUE(WNear(along.view, w_v_square));
  } else {  // what rounding leaves of 0, there and here
    const double zero = kZeroTolerance * std::pow(along.view.sigma(0), along.view.size());
    EXPECT_LE(w_v_square, zero);
    EXPECT_LE(along.view.w, zero);
  }
  const bool full = e().composite.rank == e().composite.size();
  EXPECT_NEAR(along.view.w * paper.arm.w, e().composite.w,
              full ? kMeasureTolerance * e().composite.w
                   : kZeroTolerance * std::pow(e().composite.sigma(0), e().composite.size()));
}

}  // namespace
}  // namespace vantage::test
