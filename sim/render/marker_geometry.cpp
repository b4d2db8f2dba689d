#include "sim/render/marker_geometry.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include "vantage/features/marker.h"
#include "vantage/math/segment.h"
#include "vantage/vision/disc_image.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

}  // namespace

std::optional<MarkerQuad> PlaceMarker(const CameraModel& camera, const Isometry3d& X_CF,
                                      const Marker& marker, double radii) {
  const Vector3d p_C = X_CF * marker.p;
  const Vector3d normal_C = X_CF.linear() * marker.normal;
  const std::optional<DiscImage> whole = ProjectDisc(camera, p_C, normal_C, radii * marker.radius);
  if (!whole || whole->cos_incidence <= 1e-3) return std::nullopt;

  MarkerQuad quad;
  quad.depth = whole->depth;
  quad.cos_incidence = whole->cos_incidence;
  // A pixel and a half for the edge's own width and for what the second moments of a bent image leave.
  const Vector2d half = whole->shape.diagonal().cwiseSqrt() + Vector2d::Constant(1.5);
  if (!(half.maxCoeff() < 1e5) || !(whole->centroid.cwiseAbs().maxCoeff() < 1e6))
    return std::nullopt;
  quad.bounds.u = static_cast<int>(std::floor(whole->centroid.x() - half.x()));
  quad.bounds.v = static_cast<int>(std::floor(whole->centroid.y() - half.y()));
  quad.bounds.width =
      static_cast<int>(std::ceil(whole->centroid.x() + half.x())) - quad.bounds.u + 1;
  quad.bounds.height =
      static_cast<int>(std::ceil(whole->centroid.y() + half.y())) - quad.bounds.v + 1;

  const PlaneAxes axes = AxesOfPlane(normal_C);
  Matrix3d from_plane;
  from_plane << marker.radius * axes.e1, marker.radius * axes.e2, p_C;
  if (camera.distortion.none()) {
    quad.reference = whole->centroid.array().round();
    Matrix3d K = Matrix3d::Identity();
    K.topLeftCorner<2, 2>() = CalibrationJacobian(camera);
    K.topRightCorner<2, 1>() = Vector2d(camera.u0, camera.v0) - quad.reference;
    from_plane = K * from_plane;
  } else {
    // A value that single precision holds exactly, as the shader subtracts it.
    quad.reference = ToNormalised(camera, whole->centroid).cast<float>().cast<double>();
    Matrix3d shift = Matrix3d::Identity();
    shift.topRightCorner<2, 1>() = -quad.reference;
    from_plane = shift * from_plane;
  }
  quad.to_plane = from_plane.inverse();
  quad.to_plane /= quad.to_plane.row(2).cwiseAbs().maxCoeff();
  quad.inverse_depth = normal_C / normal_C.dot(p_C);
  return quad;
}

double MarkerLift(const std::vector<Capsule>& capsules, const SceneState& state,
                  const Vector3d& p_WM, const Vector3d& p_WC) {
  const Vector3d to_camera = (p_WC - p_WM).normalized();
  double lift = 0.0;
  for (const Capsule& capsule : capsules) {
    const Isometry3d X_WL = FramePose(state, capsule.link);
    const Vector3d a = X_WL * capsule.p_LA;
    const Vector3d along = X_WL * capsule.p_LB - a;
    const double touch = 1.001 * capsule.radius;
    const auto touches = [&](const Vector3d& p_W) {
      return SquaredDistanceToSegment(p_W, a, along) <= touch * touch;
    };
    if (!touches(p_WM)) continue;
    // The capsule is convex: the ray from inside leaves it once. Bisect for where.
    double inside = 0.0;
    double outside = along.norm() + 2.1 * touch;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (inside + outside);
      (touches(p_WM + middle * to_camera) ? inside : outside) = middle;
    }
    lift = std::max(lift, outside);
  }
  return lift;
}

}  // namespace vantage::sim
