// Segments, moments, units and named faults: each kind against central differences in every arrangement
// of camera and points, and against ViSP's own classes in its own units.
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <utility>

#include <gtest/gtest.h>
#include <visp3/core/vpMomentAlpha.h>
#include <visp3/core/vpMomentArea.h>
#include <visp3/core/vpMomentAreaNormalized.h>
#include <visp3/core/vpMomentBasic.h>
#include <visp3/core/vpMomentCentered.h>
#include <visp3/core/vpMomentDatabase.h>
#include <visp3/core/vpMomentGravityCenter.h>
#include <visp3/core/vpMomentGravityCenterNormalized.h>
#include <visp3/core/vpMomentObject.h>
#include <visp3/core/vpPoint.h>
#include <visp3/visual_features/vpFeatureMomentAlpha.h>
#include <visp3/visual_features/vpFeatureMomentArea.h>
#include <visp3/visual_features/vpFeatureMomentAreaNormalized.h>
#include <visp3/visual_features/vpFeatureMomentBasic.h>
#include <visp3/visual_features/vpFeatureMomentCentered.h>
#include <visp3/visual_features/vpFeatureMomentDatabase.h>
#include <visp3/visual_features/vpFeatureMomentGravityCenter.h>
#include <visp3/visual_features/vpFeatureMomentGravityCenterNormalized.h>
#include <visp3/visual_features/vpFeatureSegment.h>

#include "eigen_matchers.h"
#include "feature_examples.h"
#include "finite_difference.h"
#include "vantage/features/pixel_feature.h"
#include "vantage/features/point_feature.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::Example;
using test::MovedInWorldAxes;
using test::RandomStep;
using test::SkewedCamera;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kPoints = test::kExamplePoints;

// Where the points are fixed, and how they lie.
struct Arrangement {
  std::string name;
  int on_body;  // of the five, counted from the end of the list
  bool coplanar;
};

std::ostream& operator<<(std::ostream& stream, const Arrangement& arrangement) {
  return stream << arrangement.name;
}

struct Scene {
  Isometry3d X_WC, X_WE;
  std::vector<Vector3d> p;  // in E or in W
  std::vector<bool> on_body;

  [[nodiscard]] PointViews View() const {
    PointViews views;
    for (std::size_t i = 0; i < p.size(); ++i) {
      const Vector3d p_WP = on_body[i] ? Vector3d(X_WE * p[i]) : p[i];
      views.push_back(ViewOf(X_WC.inverse() * p_WP, on_body[i]));
    }
    return views;
  }
};

Scene RandomScene(std::mt19937* random, const Arrangement& arrangement) {
  std::uniform_real_distribution<double> side(-0.4, 0.4);
  std::uniform_real_distribution<double> depth(0.8, 2.0);
  Scene scene;
  scene.X_WC = Advance(Isometry3d::Identity(), RandomStep(random, 1.0));
  scene.X_WE = Advance(Isometry3d::Identity(), RandomStep(random, 1.0));
  const Vector3d plane(side(*random), side(*random), 1.0 / depth(*random));  // A x + B y + C = 1/Z
  const std::vector<Vector3d> rays = test::RandomRays(random);
  for (int i = 0; i < kPoints; ++i) {
    const Vector3d& ray = rays[i];
    const double z = arrangement.coplanar ? 1.0 / plane.dot(ray) : depth(*random);
    const Vector3d p_WP = scene.X_WC * (z * ray);
    const bool on_body = i >= kPoints - arrangement.on_body;
    scene.p.push_back(on_body ? Vector3d(scene.X_WE.inverse() * p_WP) : p_WP);
    scene.on_body.push_back(on_body);
  }
  return scene;
}

FeatureRows Evaluate(const FeatureSet& set, const PointViews& views, const CameraModel& camera) {
  FeatureRows rows;
  set.Evaluate(camera, views, &rows);
  return rows;
}

struct KindAndArrangement {
  FeatureKind kind;
  Arrangement arrangement;
};

std::ostream& operator<<(std::ostream& stream, const KindAndArrangement& value) {
  return stream << NameOf(value.kind) << " " << value.arrangement;
}

class EveryKind : public ::testing::TestWithParam<KindAndArrangement> {
 protected:
  // Jacobian row of the feature by a motion of the scene, by central differences.
  template <typename Move>
  static MatrixXd Numeric(const FeatureSet& set, const Scene& scene, Move&& move) {
    const FeatureRows here = Evaluate(set, scene.View(), SkewedCamera());
    return test::CentralDifference(
        [&](const VectorXd& step) -> VectorXd {
          Scene moved = scene;
          move(Twist(step), &moved);
          return FeatureError(set, Evaluate(set, moved.View(), SkewedCamera()), here);
        },
        1, 6);
  }

  // To the scale of the feature's motion in the image: rows of what stands still there are 0.
  static void ExpectRowNear(const FeatureRows& rows, const MatrixXd& J, const MatrixXd& numeric) {
    ASSERT_EQ(J.rows(), 1);
    EXPECT_TRUE(test::Near(J, numeric, 1e-6 * rows.L.cwiseAbs().maxCoeff()));
  }
};

std::vector<KindAndArrangement> AllArrangements() {
  std::vector<KindAndArrangement> all;
  for (const FeatureKind kind : AllFeatureKinds()) {
    for (const Arrangement& arrangement :
         {Arrangement{"OnBody", kPoints, false}, Arrangement{"OnBodyInAPlane", kPoints, true},
          Arrangement{"InTheWorld", 0, false}, Arrangement{"InTheWorldInAPlane", 0, true},
          Arrangement{"Mixed", 3, false}, Arrangement{"MixedInAPlane", 3, true}}) {
      all.push_back({kind, arrangement});
    }
  }
  return all;
}

INSTANTIATE_TEST_SUITE_P(Features, EveryKind, ::testing::ValuesIn(AllArrangements()),
                         [](const auto& test) {
                           return std::string(NameOf(test.param.kind)) + "_" +
                                  test.param.arrangement.name;
                         });

TEST_P(EveryKind, InteractionMatchesCentralDifference) {
  const FeatureSet set({Example(GetParam().kind)}, kPoints);
  std::mt19937 random(51);
  for (int trial = 0; trial < 10; ++trial) {
    const Scene scene = RandomScene(&random, GetParam().arrangement);
    const MatrixXd numeric = Numeric(set, scene, [&](const Twist& step, Scene* moved) {
      moved->X_WC = Advance(scene.X_WC, step);
    });
    const FeatureRows rows = Evaluate(set, scene.View(), SkewedCamera());
    ExpectRowNear(rows, rows.L, numeric);
  }
}

TEST_P(EveryKind, EyeToHandJacobianMatchesCentralDifference) {
  const FeatureSet set({Example(GetParam().kind)}, kPoints);
  std::mt19937 random(52);
  for (int trial = 0; trial < 10; ++trial) {
    const Scene scene = RandomScene(&random, GetParam().arrangement);
    const MatrixXd numeric = Numeric(set, scene, [&](const Twist& step, Scene* moved) {
      moved->X_WE = MovedInWorldAxes(scene.X_WE, step);
    });
    const FeatureRows rows = Evaluate(set, scene.View(), SkewedCamera());
    ExpectRowNear(rows, ImageJacobian(rows.L_body, scene.X_WC, scene.X_WE.translation()), numeric);
  }
}

TEST_P(EveryKind, EyeInHandJacobianMatchesCentralDifference) {
  const FeatureSet set({Example(GetParam().kind)}, kPoints);
  std::mt19937 random(53);
  for (int trial = 0; trial < 10; ++trial) {
    const Scene scene = RandomScene(&random, GetParam().arrangement);
    const Isometry3d X_EC = scene.X_WE.inverse() * scene.X_WC;
    const MatrixXd numeric = Numeric(set, scene, [&](const Twist& step, Scene* moved) {
      moved->X_WE = MovedInWorldAxes(scene.X_WE, step);
      moved->X_WC = moved->X_WE * X_EC;
    });
    const FeatureRows rows = Evaluate(set, scene.View(), SkewedCamera());
    ExpectRowNear(rows, ImageJacobianEyeInHand(rows, scene.X_WC, scene.X_WE.translation()),
                  numeric);
  }
}

// What FeatureSet takes from ViSP, the closed forms give too.
TEST_P(EveryKind, ClosedFormAgreesWithViSP) {
  const Feature feature = Example(GetParam().kind);
  const CameraModel camera = SkewedCamera();
  std::mt19937 random(54);
  for (int trial = 0; trial < 10; ++trial) {
    const PointViews views = RandomScene(&random, GetParam().arrangement).View();
    const Eigen::Matrix2d K = CalibrationJacobian(camera);
    PixelArray pixels;
    for (int i = 0; i < kPoints; ++i) pixels[i] = K * views[i].image.n;
    PixelRow by_pixel;
    ASSERT_EQ(EvaluatePixels(feature, pixels, camera.fx, &by_pixel), RowStatus::kOk);
    Twist L = Twist::Zero();
    for (std::size_t i = 0; i < feature.points.size(); ++i) {
      L +=
          (K * PointInteraction(views[feature.points[i]].image)).transpose() * by_pixel.gradient[i];
    }
    const FeatureRows rows = Evaluate(FeatureSet({feature}, kPoints), views, camera);
    EXPECT_EQ(rows.s(0), by_pixel.value + PrincipalPointShare(feature, camera));
    EXPECT_TRUE(test::Near(rows.L.row(0), L.transpose(), 1e-10 * L.cwiseAbs().maxCoeff()));

    FeatureRows closed, values;
    FeatureSet({feature}, kPoints).Evaluate(camera, views, &closed, InteractionSource::kClosedForm);
    EXPECT_EQ(closed.s(0), rows.s(0));
    EXPECT_TRUE(test::Near(closed.L, rows.L, 1e-10 * L.cwiseAbs().maxCoeff()));
    EXPECT_TRUE(test::Near(closed.L_body, rows.L_body, 1e-10 * L.cwiseAbs().maxCoeff()));
    FeatureSet({feature}, kPoints).EvaluateValues(camera, views, &values);
    EXPECT_EQ(values.s(0), rows.s(0));
  }
}

TEST_P(EveryKind, HessianMatchesCentralDifference) {
  const Feature feature = Example(GetParam().kind);
  std::mt19937 random(55);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 10; ++trial) {
    PixelArray pixels;
    for (int i = 0; i < kPoints; ++i) pixels[i] = Vector2d(uniform(random), uniform(random));
    const auto gradient_at = [&](const VectorXd& step) -> VectorXd {
      PixelArray moved = pixels;
      for (int i = 0; i < kPoints; ++i) moved[i] += step.segment<2>(2 * i);
      PixelRow row;
      EXPECT_EQ(EvaluatePixels(feature, moved, 1.0, &row), RowStatus::kOk);
      VectorXd gradient = VectorXd::Zero(2 * kPoints);
      for (std::size_t i = 0; i < feature.points.size(); ++i) {
        gradient.segment<2>(2 * feature.points[i]) += row.gradient[i];
      }
      return gradient;
    };
    const MatrixXd numeric = test::CentralDifference(gradient_at, 2 * kPoints, 2 * kPoints);
    MatrixXd H = PixelHessian(feature, pixels, kPoints);
    if (H.size() == 0) H = MatrixXd::Zero(2 * kPoints, 2 * kPoints);  // linear
    const double scale = std::max(1.0, H.cwiseAbs().maxCoeff());
    EXPECT_TRUE(test::Near(H, numeric, 1e-6 * scale));
    EXPECT_TRUE(test::Near(H, MatrixXd(H.transpose()), 1e-14 * scale));
  }
}

// The gradient of the closed form itself.
TEST_P(EveryKind, PixelGradientMatchesCentralDifference) {
  const Feature feature = Example(GetParam().kind);
  std::mt19937 random(56);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int trial = 0; trial < 10; ++trial) {
    PixelArray pixels;
    for (int i = 0; i < kPoints; ++i) pixels[i] = Vector2d(uniform(random), uniform(random));
    const auto value_at = [&](const VectorXd& step) {
      PixelArray moved = pixels;
      for (int i = 0; i < kPoints; ++i) moved[i] += step.segment<2>(2 * i);
      PixelRow row;
      EXPECT_EQ(EvaluatePixels(feature, moved, 1.0, &row), RowStatus::kOk);
      return Vector2d(row.value, 0.0);  // two: gcc 12 warns of vectors of one
    };
    const MatrixXd numeric = test::CentralDifference(value_at, 2, 2 * kPoints);
    PixelRow row;
    ASSERT_EQ(EvaluatePixels(feature, pixels, 1.0, &row), RowStatus::kOk);
    MatrixXd gradient = MatrixXd::Zero(1, 2 * kPoints);
    for (std::size_t i = 0; i < feature.points.size(); ++i) {
      gradient.middleCols<2>(2 * feature.points[i]) += row.gradient[i].transpose();
    }
    EXPECT_TRUE(test::Near(gradient, numeric.topRows<1>(),
                           1e-7 * std::max(1.0, gradient.cwiseAbs().maxCoeff())));
  }
}

using Row6 = Eigen::Matrix<double, 1, 6>;
Row6 FromViSP(const vpMatrix& L) {
  EXPECT_EQ(L.getRows(), 1U);
  EXPECT_EQ(L.getCols(), 6U);
  return Eigen::Map<const Row6>(L.data);
}

CameraModel NormalisedUnits() {
  return InUnits(SkewedCamera(), ImageUnits::kNormalised);
}

// Both parametrisations of ViSP's segment.
TEST(Segment, EqualsViSPsInItsUnits) {
  std::mt19937 random(57);
  for (int trial = 0; trial < 20; ++trial) {
    const PointViews views = RandomScene(&random, {"", kPoints, false}).View();
    const ImagePoint& i = views[0].image;
    const ImagePoint& j = views[2].image;
    for (const bool normalised : {false, true}) {
      vpFeatureSegment segment(normalised);
      segment.buildFrom(j.n.x(), j.n.y(), j.depth, i.n.x(), i.n.y(), i.depth);
      const vpMatrix L = segment.interaction();
      using Kind = FeatureKind;
      const FeatureSet set(
          {{normalised ? Kind::kSegmentXNormalised : Kind::kSegmentX, {0, 2}},
           {normalised ? Kind::kSegmentYNormalised : Kind::kSegmentY, {0, 2}},
           {normalised ? Kind::kSegmentInverseLength : Kind::kSegmentLength, {0, 2}},
           {Kind::kSegmentAngle, {0, 2}}},
          kPoints);
      const FeatureRows rows = Evaluate(set, views, NormalisedUnits());
      ASSERT_EQ(rows.size(), 4);
      for (unsigned row = 0; row < 4; ++row) {
        EXPECT_NEAR(rows.s(row), segment.get_s()[row],
                    1e-12 * std::max(1.0, std::abs(rows.s(row))));
        const Row6 expected = Eigen::Map<const Row6>(L[row]);
        EXPECT_TRUE(test::Near(rows.L.row(row), expected, 1e-11 * expected.cwiseAbs().maxCoeff()));
      }
    }
  }
}

// Every vpFeatureMoment* class that applies to a set of points.
TEST(Moments, EqualViSPsInItsUnits) {
  constexpr double kArea = 0.07;
  constexpr double kDepth = 1.3;
  std::mt19937 random(58);
  for (int trial = 0; trial < 20; ++trial) {
    const PointViews views = RandomScene(&random, {"", kPoints, true}).View();
    Eigen::MatrixX3d coordinates(kPoints, 3);
    VectorXd inverse_depth(kPoints);
    std::vector<vpPoint> vertices(kPoints);
    std::vector<int> all;
    for (int i = 0; i < kPoints; ++i) {
      const ImagePoint& image = views[i].image;
      coordinates.row(i) << image.n.transpose(), 1.0;
      inverse_depth(i) = 1.0 / image.depth;
      vertices[i].set_x(image.n.x());
      vertices[i].set_y(image.n.y());
      all.push_back(i);
    }
    const Vector3d plane = coordinates.colPivHouseholderQr().solve(inverse_depth);

    vpMomentObject object(4);
    object.setType(vpMomentObject::DISCRETE);
    object.fromVector(vertices);
    vpMomentDatabase moments;
    vpMomentBasic basic;
    vpMomentGravityCenter centre;
    vpMomentCentered centred;
    vpMomentArea area;
    vpMomentAlpha alpha;
    vpMomentAreaNormalized area_normalised(kArea, kDepth);
    vpMomentGravityCenterNormalized centre_normalised;
    for (vpMoment* moment : std::initializer_list<vpMoment*>{
             &basic, &centre, &centred, &area, &alpha, &area_normalised, &centre_normalised}) {
      moment->linkTo(moments);
    }
    for (vpMoment* moment : std::initializer_list<vpMoment*>{
             &basic, &centre, &centred, &area, &alpha, &area_normalised, &centre_normalised}) {
      moment->update(object);
      moment->compute();
    }
    vpFeatureMomentDatabase features;
    vpFeatureMomentBasic basic_feature(moments, 0, 0, 1);
    vpFeatureMomentGravityCenter centre_feature(moments, 0, 0, 1);
    vpFeatureMomentCentered centred_feature(moments, 0, 0, 1);
    vpFeatureMomentArea area_feature(moments, 0, 0, 1);
    vpFeatureMomentAlpha alpha_feature(moments, 0, 0, 1);
    vpFeatureMomentAreaNormalized area_normalised_feature(moments, 0, 0, 1);
    vpFeatureMomentGravityCenterNormalized centre_normalised_feature(moments, 0, 0, 1);
    for (vpFeatureMoment* feature : std::initializer_list<vpFeatureMoment*>{
             &basic_feature, &centre_feature, &centred_feature, &area_feature, &alpha_feature,
             &area_normalised_feature, &centre_normalised_feature}) {
      feature->linkTo(features);
      feature->update(plane(0), plane(1), plane(2));  // in the order of their needs
    }

    const auto expect = [&](const Feature& feature, double value, const Row6& L) {
      const FeatureRows rows = Evaluate(FeatureSet({feature}, kPoints), views, NormalisedUnits());
      ASSERT_EQ(rows.size(), 1);
      EXPECT_NEAR(rows.s(0), value, 1e-12 * std::max(1.0, std::abs(value))) << NameOf(feature.kind);
      EXPECT_TRUE(test::Near(rows.L.row(0), L, 1e-10 * L.cwiseAbs().maxCoeff()))
          << NameOf(feature.kind) << feature.order_x << feature.order_y;
    };
    for (unsigned order = 1; order <= 3; ++order) {
      for (unsigned p = 0; p <= order; ++p) {
        const unsigned q = order - p;
        const auto ip = static_cast<int>(p);
        const auto iq = static_cast<int>(q);
        expect({FeatureKind::kMomentBasic, all, ip, iq}, basic.get(p, q),
               FromViSP(basic_feature.interaction(p, q)));
        if (order < 2) continue;
        expect({FeatureKind::kMomentCentred, all, ip, iq}, centred.get(p, q),
               FromViSP(centred_feature.interaction(p, q)));
      }
    }
    using Centre = vpFeatureMomentGravityCenter;
    expect({FeatureKind::kMomentX, all}, centre.getXg(),
           FromViSP(centre_feature.interaction(Centre::selectXg())));
    expect({FeatureKind::kMomentY, all}, centre.getYg(),
           FromViSP(centre_feature.interaction(Centre::selectYg())));
    const unsigned every = vpBasicFeature::FEATURE_ALL;
    expect({FeatureKind::kMomentAlpha, all}, alpha.get(),
           FromViSP(alpha_feature.interaction(every)));
    expect({FeatureKind::kMomentAreaNormalised, all, 0, 0, kArea, kDepth}, area_normalised.get()[0],
           FromViSP(area_normalised_feature.interaction(every)));
    using CentreNormalised = vpFeatureMomentGravityCenterNormalized;
    expect({FeatureKind::kMomentXNormalised, all, 0, 0, kArea, kDepth}, centre_normalised.get()[0],
           FromViSP(centre_normalised_feature.interaction(CentreNormalised::selectXn())));
    expect({FeatureKind::kMomentYNormalised, all, 0, 0, kArea, kDepth}, centre_normalised.get()[1],
           FromViSP(centre_normalised_feature.interaction(CentreNormalised::selectYn())));
    expect({FeatureKind::kMomentArea, all}, area.get()[0],
           FromViSP(area_feature.interaction(every)));
  }
}

// Pixels (0, 0), (6, 0), (0, 2) from the principal point.
TEST(Moments, KnownTriangle) {
  CameraModel camera = NormalisedUnits();
  camera.fx = camera.fy = 2.0;
  camera.u0 = 100.0;
  camera.v0 = 200.0;
  const PointViews views{{{Vector2d(0.0, 0.0), 1.0}, true, true},
                         {{Vector2d(3.0, 0.0), 1.0}, true, true},
                         {{Vector2d(0.0, 1.0), 1.0}, true, true}};
  const std::vector<int> all{0, 1, 2};
  const FeatureSet set({{FeatureKind::kMomentX, all},
                        {FeatureKind::kMomentY, all},
                        {FeatureKind::kMomentBasic, all, 2, 0},
                        {FeatureKind::kMomentBasic, all, 0, 3},
                        {FeatureKind::kMomentCentred, all, 2, 0},
                        {FeatureKind::kMomentCentred, all, 1, 1},
                        {FeatureKind::kMomentArea, all},
                        {FeatureKind::kMomentAreaNormalised, all, 0, 0, 24.0, 3.0},
                        {FeatureKind::kMomentAlpha, all},
                        {FeatureKind::kSegmentXNormalised, {0, 1}},
                        {FeatureKind::kSegmentInverseLength, {0, 2}}},
                       3);
  VectorXd expected(11);
  const double mu20 = 24.0;
  const double mu02 = 8.0 / 3.0;
  expected << 102, 200 + 2.0 / 3.0, 36, 8, mu20, -4.0, mu20 + mu02,
      3.0 * std::sqrt(24.0 / (mu20 + mu02)), 0.5 * std::atan2(-8.0, mu20 - mu02), 0.5, 0.5;
  EXPECT_TRUE(test::Near(Evaluate(set, views, camera).s, expected, 1e-13 * 200));
}

TEST(Moments, OrientationHasNoHead) {
  const FeatureSet set({{FeatureKind::kMomentAlpha, {0, 1}}}, 2);
  FeatureRows current;
  FeatureRows goal;
  current.s.resize(1);
  goal.s.resize(1);
  current.s(0) = 1.5;
  goal.s(0) = -1.5;
  EXPECT_NEAR(FeatureError(set, current, goal)(0), 3.0 - kPi, 1e-15);
}

TEST(Units, OfTheSameView) {
  std::mt19937 random(59);
  const PointViews views = RandomScene(&random, {"", kPoints, false}).View();
  const FeatureSet points = FeatureSet::AllPoints(kPoints);
  const CameraModel camera = SkewedCamera();
  const FeatureRows normalised = Evaluate(points, views, InUnits(camera, ImageUnits::kNormalised));
  const FeatureRows metric = Evaluate(points, views, InUnits(camera, ImageUnits::kMetric, 0.008));
  const FeatureRows pixels = Evaluate(points, views, InUnits(camera, ImageUnits::kPixels));
  const Eigen::Matrix2d K = CalibrationJacobian(camera);
  for (int i = 0; i < kPoints; ++i) {
    EXPECT_EQ(Vector2d(normalised.s.segment<2>(2 * i)), views[i].image.n);
    EXPECT_TRUE(test::Near(metric.s.segment<2>(2 * i), 0.008 * views[i].image.n, 1e-18));
    EXPECT_TRUE(test::Near(pixels.s.segment<2>(2 * i), ToPixel(camera, views[i].image.n), 1e-12));
    EXPECT_TRUE(
        test::Near(normalised.L.middleRows<2>(2 * i), PointInteraction(views[i].image), 1e-14));
    EXPECT_TRUE(
        test::Near(metric.L.middleRows<2>(2 * i), 0.008 * PointInteraction(views[i].image), 1e-16));
    EXPECT_TRUE(test::Near(pixels.L.middleRows<2>(2 * i),
                           MatrixXd(K * PointInteraction(views[i].image)), 1e-11));
  }
}

TEST(Units, OnlyPixelsKnowTheLens) {
  CameraModel bent = SkewedCamera();
  bent.distortion.k1 = -0.3;
  EXPECT_EQ(InUnits(bent, ImageUnits::kPixels).distortion.k1, -0.3);
  EXPECT_TRUE(InUnits(bent, ImageUnits::kNormalised).distortion.none());
}

// One cause each.
struct Fault {
  std::string name;
  Feature feature;
  PointViews views;
  RowStatus status;
};

std::ostream& operator<<(std::ostream& stream, const Fault& fault) {
  return stream << fault.name;
}

PointViews SquareBefore(double depth) {
  PointViews views;
  for (const Vector2d& n :
       {Vector2d(0.1, 0.1), Vector2d(-0.1, 0.1), Vector2d(-0.1, -0.1), Vector2d(0.1, -0.1)}) {
    views.push_back({{n, depth}, true, true});
  }
  return views;
}

PointViews AllAt(const Vector2d& n) {
  PointViews views = SquareBefore(1.0);
  for (PointView& view : views) view.image.n = n;
  return views;
}

PointViews With(int point, const PointView& view) {
  PointViews views = SquareBefore(1.0);
  views[point] = view;
  return views;
}

class NamedFault : public ::testing::TestWithParam<Fault> {};

TEST_P(NamedFault, LeavesTheRowOutAndSaysWhy) {
  const FeatureSet set({GetParam().feature, {FeatureKind::kPointX, {0}}}, 4);
  const FeatureRows rows = Evaluate(set, GetParam().views, SkewedCamera());
  EXPECT_EQ(rows.status[0], GetParam().status);
  EXPECT_EQ(rows.status[1], RowStatus::kOk);
  ASSERT_EQ(rows.size(), 1);
  EXPECT_EQ(rows.feature[0], 1);
  EXPECT_TRUE(rows.s.allFinite());
  EXPECT_TRUE(rows.L.allFinite());
  EXPECT_TRUE(rows.L_body.allFinite());
}

std::vector<Fault> AllFaults() {
  std::vector<Fault> faults;
  const auto add = [&](const char* name, FeatureKind kind, std::vector<int> points,
                       const PointViews& views, RowStatus status) {
    Feature feature;
    feature.kind = kind;
    feature.points = std::move(points);
    faults.push_back({name, feature, views, status});
  };
  using Kind = FeatureKind;
  using Status = RowStatus;
  add("NotSeen", Kind::kPointY, {3}, With(3, {{Vector2d(0, 0), 1.0}, false, true}),
      Status::kNotSeen);
  add("Behind", Kind::kPointY, {3}, With(3, ViewOf({0.1, 0.1, -2.0}, true)), Status::kBehindCamera);
  add("InTheCameraPlane", Kind::kPointY, {3}, With(3, ViewOf({0.1, 0.1, 0.0}, true)),
      Status::kBehindCamera);
  add("NaNPoint", Kind::kPointY, {3}, With(3, ViewOf({kNaN, 0.1, 1.0}, true)), Status::kNotFinite);
  add("InfinitePoint", Kind::kPointY, {3}, With(3, ViewOf({0, 0, kInfinity}, true)),
      Status::kNotFinite);
  const PointViews one_place = AllAt({0.1, 0.2});
  const std::vector<int> all{0, 1, 2, 3};
  add("Distance", Kind::kDistance, {1, 2}, one_place, Status::kCoincident);
  add("Angle", Kind::kAngle, {1, 2}, one_place, Status::kCoincident);
  add("EdgeAngle", Kind::kEdgeAngle, all, one_place, Status::kCoincident);
  add("Segment", Kind::kSegmentInverseLength, {1, 2}, one_place, Status::kCoincident);
  add("AreaNormalised", Kind::kMomentAreaNormalised, all, one_place, Status::kCoincident);
  add("Alpha", Kind::kMomentAlpha, all, one_place, Status::kCoincident);
  return faults;
}

INSTANTIATE_TEST_SUITE_P(Features, NamedFault, ::testing::ValuesIn(AllFaults()),
                         [](const auto& test) { return test.param.name; });

// A square in square pixels has no orientation.
TEST(NamedFaults, AlphaOfASymmetricSet) {
  const FeatureSet set({{FeatureKind::kMomentAlpha, {0, 1, 2, 3}}}, 4);
  const FeatureRows rows = Evaluate(set, SquareBefore(1.0), NormalisedUnits());
  EXPECT_EQ(rows.status[0], RowStatus::kUndefined);
  EXPECT_EQ(rows.size(), 0);
}

// Polynomials of the pixels have derivatives where points coincide.
TEST(NamedFaults, AreasOfOnePlaceAreRows) {
  const FeatureSet set({{FeatureKind::kArea, {0, 1, 2}}, {FeatureKind::kMomentArea, {0, 1, 2}}}, 4);
  const FeatureRows rows = Evaluate(set, AllAt({0.1, 0.2}), SkewedCamera());
  ASSERT_EQ(rows.size(), 2);
  EXPECT_NEAR(rows.s.norm(), 0.0, 1e-20);
  EXPECT_TRUE(rows.L.allFinite());
}

struct BadFeature {
  Feature feature;
  std::string part;  // of the message
};

class MomentRefusal : public ::testing::TestWithParam<BadFeature> {};

TEST_P(MomentRefusal, NamesWhatIsWrong) {
  try {
    const FeatureSet set({GetParam().feature}, 4);
    FAIL() << "accepted";
  } catch (const ConfigError& error) {
    EXPECT_EQ(error.key(), "features[0]");
    EXPECT_NE(std::string(error.what()).find(GetParam().part), std::string::npos) << error.what();
  }
}

std::vector<BadFeature> BadFeatures() {
  std::vector<BadFeature> bad;
  const auto add = [&](const char* part, FeatureKind kind, std::vector<int> points, int order_x = 0,
                       int order_y = 0, double area = 1.0, double depth = 1.0) {
    bad.push_back({{kind, std::move(points), order_x, order_y, area, depth}, part});
  };
  using Kind = FeatureKind;
  add("orders must", Kind::kMomentBasic, {0, 1});
  add("orders must", Kind::kMomentBasic, {0, 1}, 2, 2);
  add("orders must", Kind::kMomentBasic, {0, 1}, 3, -1);
  add("orders must", Kind::kMomentCentred, {0, 1}, 1, 0);
  add("must name 2", Kind::kMomentCentred, {0}, 1, 1);
  add("must name 2", Kind::kMomentAlpha, {0});
  add("must name 1", Kind::kMomentX, {});
  add("must name 2", Kind::kSegmentX, {0});
  add("two different points", Kind::kSegmentX, {1, 1});
  add("area and depth", Kind::kMomentAreaNormalised, {0, 1}, 0, 0, 0.0, 1.0);
  add("area and depth", Kind::kMomentXNormalised, {0, 1}, 0, 0, 1.0, kNaN);
  return bad;
}

INSTANTIATE_TEST_SUITE_P(Features, MomentRefusal, ::testing::ValuesIn(BadFeatures()));

TEST(FeatureKinds, HaveOneNameEach) {
  std::vector<std::string> names;
  for (const FeatureKind kind : AllFeatureKinds()) names.emplace_back(NameOf(kind));
  EXPECT_EQ(names.size(), 24U);
  EXPECT_EQ(std::count(names.begin(), names.end(), ""), 0);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::unique(names.begin(), names.end()), names.end());
  EXPECT_STREQ(NameOf(static_cast<FeatureKind>(99)), "");
}

TEST(FeatureKinds, TakeTheirExamplesPoints) {
  for (const FeatureKind kind : AllFeatureKinds()) {
    const auto count = static_cast<int>(Example(kind).points.size());
    EXPECT_LE(PointsOf(kind).least, count) << NameOf(kind);
    EXPECT_GE(PointsOf(kind).most, count) << NameOf(kind);
  }
  // None fits what is not a kind.
  const PointCount none = PointsOf(static_cast<FeatureKind>(99));
  EXPECT_GT(none.least, none.most);
}

}  // namespace
}  // namespace vantage
