#include "vantage/features/feature_gradient.h"

#include <algorithm>
#include <array>
#include <cassert>

#include "vantage/features/pixel_feature.h"

namespace vantage {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// 3×n: velocity of a point before the camera by each of the Jacobian's n motions, in camera axes.
using PointMotion = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints>;
using Projection = Eigen::Matrix<double, 2, 3>;

// A point that a row needs.
struct ScenePoint {
  bool used{false};
  bool moves{false};  // before the camera, when the joints do
  Vector3d p_C{Vector3d::Zero()};
  Vector3d r_W{Vector3d::Zero()};  // from E's origin, in world axes
  PointMotion by_motion;
};
using ScenePoints = std::array<ScenePoint, kMaxPoints>;

// ∂φ/∂ what J is made of, each with the rest held fixed.
struct Sensitivity {
  std::array<Vector3d, kMaxPoints> by_point;
  std::array<PointMotion, kMaxPoints> by_motion;
  Matrix2d by_calibration{Matrix2d::Zero()};
};

// ∂n/∂p of n = (X/Z, Y/Z).
Projection ProjectionJacobian(const Vector3d& p) noexcept {
  Projection J;
  J << 1.0, 0.0, -p.x() / p.z(), 0.0, 1.0, -p.y() / p.z();
  return J / p.z();
}

// ∂/∂p of a · ∂n/∂p y, a and y held fixed.
Vector3d ProjectionCurvature(const Vector3d& p, const Vector2d& a, const Vector3d& y) noexcept {
  const Vector2d n = p.head<2>() / p.z();
  Vector3d c;
  c.head<2>() = -a * y.z();
  c.z() = -a.dot(y.head<2>() - 2.0 * y.z() * n);
  return c / (p.z() * p.z());
}

// The twists that the columns of `twists` (of E, in world axes) give a point at r_W before the camera.
PointMotion MotionOf(const Matrix3d& R_CW, bool eye_in_hand, const ArmJacobian& twists,
                     const Vector3d& r_W) noexcept {
  PointMotion motion(3, twists.cols());
  for (Eigen::Index j = 0; j < twists.cols(); ++j) {
    const Vector3d v = twists.col(j).head<3>() + twists.col(j).tail<3>().cross(r_W);
    // Before a camera that moves, the scene moves the other way.
    motion.col(j) = eye_in_hand ? Vector3d(R_CW * -v) : Vector3d(R_CW * v);
  }
  return motion;
}

ScenePoints PlacePoints(const FeatureSet& set, const PointViews& views, const FeatureRows& rows,
                        const ViewGeometry& geometry, const ArmJacobian& twists) {
  ScenePoints points;
  const Matrix3d R_CW = geometry.X_WC.linear().transpose();
  for (int row = 0; row < rows.size(); ++row) {
    for (const int i : set.features()[rows.feature[row]].points) {
      ScenePoint& point = points[i];
      if (point.used) continue;
      const ImagePoint& image = views[i].image;
      point.used = true;
      point.moves = views[i].on_body != geometry.eye_in_hand;
      point.p_C = image.depth * Vector3d(image.n.x(), image.n.y(), 1.0);
      point.r_W = geometry.X_WC * point.p_C - geometry.p_WE;
      point.by_motion = point.moves ? MotionOf(R_CW, geometry.eye_in_hand, twists, point.r_W)
                                    : PointMotion(PointMotion::Zero(3, twists.cols()));
    }
  }
  return points;
}

// J's row of a feature s is Σ_i ∂s/∂u_i K ∂n_i/∂p_i M_i over its points, u_i = K n_i and M_i = by_motion.
Sensitivity Differentiate(const FeatureSet& set, const CameraModel& camera, const FeatureRows& rows,
                          const ScenePoints& points, const TaskJacobian& by_J) {
  const Matrix2d K = CalibrationJacobian(camera);
  PixelArray pixels;
  std::array<Projection, kMaxPoints> projection;
  Sensitivity result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].used) continue;
    pixels[i] = K * (points[i].p_C.head<2>() / points[i].p_C.z());
    projection[i] = ProjectionJacobian(points[i].p_C);
    result.by_point[i].setZero();
    result.by_motion[i].setZero(3, by_J.cols());
  }
  const int num_points = set.num_points();
  for (int row = 0; row < rows.size(); ++row) {
    const Feature& feature = set.features()[rows.feature[row]];
    PixelRow by_pixel;
    const RowStatus status =
        EvaluatePixels(feature, pixels, std::min(camera.fx, camera.fy), &by_pixel);
    assert(status == RowStatus::kOk);
    if (status != RowStatus::kOk) continue;
    // All pixels' velocity under the row's own share of by_J.
    Eigen::VectorXd pixel_motion = Eigen::VectorXd::Zero(2 * num_points);
    for (std::size_t k = 0; k < feature.points.size(); ++k) {
      const int i = feature.points[k];
      const Vector2d by_n = K.transpose() * by_pixel.gradient[k];
      const Vector3d y = points[i].by_motion * by_J.row(row).transpose();
      const Vector2d n_motion = projection[i] * y;
      result.by_motion[i] += (projection[i].transpose() * by_n) * by_J.row(row);
      result.by_point[i] += ProjectionCurvature(points[i].p_C, by_n, y);
      result.by_calibration += by_pixel.gradient[k] * n_motion.transpose();
      pixel_motion.segment<2>(2 * i) = K * n_motion;
    }
    const Eigen::MatrixXd H = PixelHessian(feature, pixels, num_points);
    if (H.size() == 0) continue;
    const Eigen::VectorXd by_pixels = H * pixel_motion;
    for (int i = 0; i < num_points; ++i) {
      if (!points[i].used) continue;
      const Vector2d by_u = by_pixels.segment<2>(2 * i);
      result.by_point[i] += projection[i].transpose() * (K.transpose() * by_u);
      result.by_calibration += by_u * (points[i].p_C.head<2>() / points[i].p_C.z()).transpose();
    }
  }
  result.by_calibration(1, 0) = 0.0;
  return result;
}

// A displacement δ = (v, ω) of the camera moves p by -(v + ω × p) before it, and turns every motion by -ω.
Twist ByCamera(const ScenePoints& points, const Sensitivity& by) noexcept {
  Twist gradient = Twist::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].used) continue;
    gradient.head<3>() -= by.by_point[i];
    gradient.tail<3>() -= points[i].p_C.cross(by.by_point[i]);
    for (Eigen::Index m = 0; m < points[i].by_motion.cols(); ++m) {
      gradient.tail<3>() -= points[i].by_motion.col(m).cross(by.by_motion[i].col(m));
    }
  }
  return gradient;
}

// Second derivative of a point on the arm by joints l and m: the joint nearer to the base turns what the
// other one does. Seen from a carried camera the base is the far end.
JointVector ByJoints(const ScenePoints& points, const Sensitivity& by,
                     const ViewGeometry& geometry) noexcept {
  const Matrix3d R_CW = geometry.X_WC.linear().transpose();
  const Eigen::Index n = geometry.J_r.cols();
  const double sign = geometry.eye_in_hand ? -1.0 : 1.0;
  const PointMotion turn = sign * (R_CW * geometry.J_r.bottomRows<3>());
  JointVector gradient = JointVector::Zero(n);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].used || !points[i].moves) continue;
    const PointMotion& motion = points[i].by_motion;
    for (Eigen::Index l = 0; l < n; ++l) {
      gradient(l) += by.by_point[i].dot(motion.col(l));
      for (Eigen::Index m = 0; m < n; ++m) {
        const Eigen::Index near = geometry.eye_in_hand ? std::max(l, m) : std::min(l, m);
        const Eigen::Index far = l + m - near;
        gradient(l) += by.by_motion[i].col(m).dot(turn.col(near).cross(motion.col(far)));
      }
    }
  }
  return gradient;
}

// The same for the six unit twists of E in world axes in place of the joints: they are what J_v tells of,
// and do not turn with the arm.
JointVector UnitTwistsByJoints(const ScenePoints& points, const Sensitivity& by,
                               const ViewGeometry& geometry) noexcept {
  const Matrix3d R_CW = geometry.X_WC.linear().transpose();
  const Eigen::Index n = geometry.J_r.cols();
  JointVector gradient = JointVector::Zero(n);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].used || !points[i].moves) continue;
    const Vector3d& r = points[i].r_W;
    const PointMotion by_motion_W = R_CW.transpose() * by.by_motion[i];
    const PointMotion motion = MotionOf(R_CW, geometry.eye_in_hand, geometry.J_r, r);
    for (Eigen::Index l = 0; l < n; ++l) {
      const Vector3d v = geometry.J_r.col(l).head<3>();
      const Vector3d w = geometry.J_r.col(l).tail<3>();
      gradient(l) += by.by_point[i].dot(motion.col(l));
      for (int axis = 0; axis < 3; ++axis) {
        const Vector3d e = Vector3d::Unit(axis);
        const auto by_translation = by_motion_W.col(axis);
        const auto by_rotation = by_motion_W.col(3 + axis);
        if (geometry.eye_in_hand) {  // -R_CW e and -R_CW (e × r): R_CW turns, and r is left behind
          gradient(l) +=
              by_translation.dot(w.cross(e)) + by_rotation.dot(w.cross(e.cross(r)) + e.cross(v));
        } else {  // R_CW e and R_CW (e × r): r turns
          gradient(l) += by_rotation.dot(e.cross(w.cross(r)));
        }
      }
    }
  }
  return gradient;
}

}  // namespace

ViewGradient GradientThroughComposite(const FeatureSet& set, const CameraModel& camera,
                                      const PointViews& views, const FeatureRows& rows,
                                      const ViewGeometry& geometry, const TaskJacobian& by_J_c) {
  assert(by_J_c.rows() == rows.size() && by_J_c.cols() == geometry.J_r.cols());
  const ScenePoints points = PlacePoints(set, views, rows, geometry, geometry.J_r);
  const Sensitivity by = Differentiate(set, camera, rows, points, by_J_c);
  return {ByCamera(points, by), by.by_calibration, ByJoints(points, by, geometry)};
}

ViewGradient GradientThroughView(const FeatureSet& set, const CameraModel& camera,
                                 const PointViews& views, const FeatureRows& rows,
                                 const ViewGeometry& geometry, const TaskJacobian& by_J_v) {
  assert(by_J_v.rows() == rows.size() && by_J_v.cols() == 6);
  const ScenePoints points =
      PlacePoints(set, views, rows, geometry, ArmJacobian(Matrix6d::Identity()));
  const Sensitivity by = Differentiate(set, camera, rows, points, by_J_v);
  return {ByCamera(points, by), by.by_calibration, UnitTwistsByJoints(points, by, geometry)};
}

}  // namespace vantage
