#include "vantage/active/view.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "vantage/camera/pinhole.h"
#include "vantage/features/pixel_feature.h"
#include "vantage/features/point_feature.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Rays start this far before a marker's face: a capsule whose skin the face lies on is no obstacle.
constexpr double kFaceOffset = 1e-3;  // [m]

// A pixel's derivative by the joints.
using PixelByJoints = Eigen::Matrix<double, 2, Eigen::Dynamic, Eigen::ColMajor, 2, kMaxJoints>;
using RowByJoints = Eigen::Matrix<double, 1, Eigen::Dynamic, Eigen::RowMajor, 1, kMaxJoints>;

// The model's markers in one image.
struct ImageOfMarkers {
  std::array<bool, kMaxPoints> in_front{};
  PixelArray pixel;  // undistorted, from the principal point
  std::array<PixelByJoints, kMaxPoints> J;
};

double DistanceToSegment(const Vector3d& p, const Vector3d& from, const Vector3d& to) noexcept {
  const Vector3d axis = to - from;
  const double length2 = axis.squaredNorm();
  const double t = length2 > 0.0 ? (p - from).dot(axis) / length2 : 0.0;
  return (p - from - std::min(1.0, std::max(0.0, t)) * axis).norm();
}

// Derivative of one feature. False when it has none here.
bool FeatureRow(const Feature& feature, const ImageOfMarkers& image, double focal,
                RowByJoints* row) noexcept {
  for (const int i : feature.points) {
    if (!image.in_front[i]) return false;
  }
  if (feature.kind == FeatureKind::kPointX || feature.kind == FeatureKind::kPointY) {
    *row = image.J[feature.points[0]].row(feature.kind == FeatureKind::kPointX ? 0 : 1);
    return true;
  }
  PixelRow by_pixel;
  if (EvaluatePixels(feature, image.pixel, focal, &by_pixel) != RowStatus::kOk) return false;
  row->setZero(image.J[feature.points[0]].cols());
  for (std::size_t i = 0; i < feature.points.size(); ++i) {
    *row += by_pixel.gradient[i].transpose() * image.J[feature.points[i]];
  }
  return true;
}

// Where a marker's ring is looked at, as (cos, sin).
const std::array<Eigen::Vector2d, 12>& RimDirections() {
  static const auto directions = [] {
    std::array<Eigen::Vector2d, 12> result;
    for (std::size_t i = 0; i < result.size(); ++i) {
      const double angle = 2.0 * kPi * static_cast<double>(i) / static_cast<double>(result.size());
      result[i] = {std::cos(angle), std::sin(angle)};
    }
    return result;
  }();
  return directions;
}

}  // namespace

void Validate(const ViewModel& model) {
  const auto count = static_cast<int>(model.markers.size());
  if (count != model.features.num_points()) {
    throw ConfigError("", "markers",
                      "must be as many as the features' points, are " + std::to_string(count) +
                          " for " + std::to_string(model.features.num_points()));
  }
  for (const Marker& marker : model.markers) {
    const std::string key = "markers[" + std::to_string(marker.id) + "]";
    if (!(marker.radius > 0.0) || !std::isfinite(marker.radius)) {
      throw ConfigError("", key + ".radius", "must be > 0 m, is " + std::to_string(marker.radius));
    }
    if (!(std::abs(marker.normal.norm() - 1.0) < 1e-6)) {
      throw ConfigError("", key + ".normal", "must be a unit vector");
    }
    if (!marker.p.allFinite()) throw ConfigError("", key + ".position", "must be finite");
  }
}

ArmSample SampleArm(const ViewModel& model, const JointVector& q) {
  ArmSample sample;
  SampleArm(model, q, &sample);
  return sample;
}

void SampleArm(const ViewModel& model, const JointVector& q, ArmSample* sample) {
  assert(q.size() == model.arm.size());
  sample->q = q;
  sample->kinematics = ComputeKinematics(model.arm, q);
  const Isometry3d& X_WE = sample->kinematics.X_WE;
  const ArmJacobian& J_WE_W = sample->kinematics.J_WE_W;
  const std::size_t count = model.markers.size();
  sample->markers.resize(count);
  sample->J_marker_W.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Marker& marker = model.markers[i];
    const Vector3d arm_W = X_WE.linear() * marker.p;
    sample->markers[i] = {X_WE.translation() + arm_W, X_WE.linear() * marker.normal, marker.radius};
    sample->J_marker_W[i] = PointJacobianOf(J_WE_W, arm_W);
  }
  PlaceCapsules(model.arm, q, &sample->capsules);
}

ViewFault CheckMarkerUnobstructed(const CameraModel& camera, const ViewLimits& limits,
                                  const Isometry3d& X_WC, const PlacedMarker& marker) noexcept {
  const Vector3d ray_W = X_WC.translation() - marker.p_W;  // from the marker to the camera
  const Vector3d p_CP = X_WC.linear().transpose() * -ray_W;
  const std::optional<ImagePoint> image = Project(p_CP);
  if (!image) return ViewFault::kBehind;
  if (image->depth < limits.min_depth) return ViewFault::kTooNear;
  if (image->depth > limits.max_depth) return ViewFault::kTooFar;
  if (!InImage(camera, ToPixel(camera, image->n), limits.margin)) return ViewFault::kOutOfImage;
  const double distance = ray_W.norm();
  const double cos_incidence = ray_W.dot(marker.normal_W) / distance;
  if (!(cos_incidence > std::cos(limits.max_incidence))) return ViewFault::kFacesAway;
  const double focal = std::min(camera.fx, camera.fy);
  if (focal * marker.radius * cos_incidence < limits.min_semi_axis * distance) {
    return ViewFault::kTooSmall;
  }
  return ViewFault::kNone;
}

Vector3d SightOf(const PlacedMarker& marker) noexcept {
  return marker.p_W + kFaceOffset * marker.normal_W;
}

std::optional<PlacedCapsule> ObstacleTo(const PlacedMarker& marker,
                                        const PlacedCapsule& capsule) noexcept {
  const double distance = DistanceToSegment(marker.p_W, capsule.p_WA, capsule.p_WB);
  if (distance <= capsule.radius + kFaceOffset) return std::nullopt;
  // Nearer than the ring is wide, the ring's own width would count as an obstacle everywhere.
  const double ring = kRingRadii * marker.radius;
  PlacedCapsule body = capsule;
  body.radius += std::min(ring, std::max(0.0, 0.5 * (distance - capsule.radius)));
  return body;
}

bool IsHidden(const Vector3d& p_WC, const PlacedMarker& marker,
              const std::vector<PlacedCapsule>& capsules) noexcept {
  const Vector3d start = SightOf(marker);
  for (const PlacedCapsule& capsule : capsules) {
    const std::optional<PlacedCapsule> body = ObstacleTo(marker, capsule);
    if (body && SegmentHitsCapsule(start, p_WC, *body)) return true;
  }
  return false;
}

bool IsCovered(const Vector3d& p_WC, const PlacedMarker& marker,
               const std::vector<PlacedMarker>& others) noexcept {
  constexpr double kInPlane = 5e-4;  // [m]
  const double ring = kRingRadii * marker.radius;
  const Vector3d& n = marker.normal_W;
  const Vector3d e1 = n.unitOrthogonal();
  const Vector3d e2 = n.cross(e1);
  for (const PlacedMarker& other : others) {
    const double plate = kPlateRadii * other.radius;
    const double camera_above = other.normal_W.dot(p_WC - other.p_W);
    // Whether the ray from the camera to a point meets the plate before it meets the point.
    const auto covers = [&](const Vector3d& p_W) {
      const double above = other.normal_W.dot(p_W - other.p_W);
      // A point on the camera's side of the plate's plane, or in it, is not behind it.
      if (std::copysign(above, above * camera_above) > -kInPlane) return false;
      const double share = above / (above - camera_above);  // of the way to the camera
      return (p_W + share * (p_WC - p_W) - other.p_W).squaredNorm() < plate * plate;
    };
    if (covers(marker.p_W)) return true;
    // All rays from the ring are within its radius of the middle one: most plates are far from it.
    if (DistanceToSegment(other.p_W, marker.p_W, p_WC) > plate + ring) continue;
    for (const Eigen::Vector2d& rim : RimDirections()) {
      if (covers(marker.p_W + ring * (rim.x() * e1 + rim.y() * e2))) return true;
    }
  }
  return false;
}

ViewFault CheckMarker(const CameraModel& camera, const ViewLimits& limits, const Isometry3d& X_WC,
                      const PlacedMarker& marker,
                      const std::vector<PlacedCapsule>& capsules) noexcept {
  const ViewFault fault = CheckMarkerUnobstructed(camera, limits, X_WC, marker);
  if (fault != ViewFault::kNone) return fault;
  return IsHidden(X_WC.translation(), marker, capsules) ? ViewFault::kHidden : ViewFault::kNone;
}

ViewFault CheckMarkerAmong(const CameraModel& camera, const ViewLimits& limits,
                           const Isometry3d& X_WC, const PlacedMarker& marker, const ArmSample& arm,
                           const std::vector<PlacedMarker>& scene_markers) noexcept {
  const ViewFault fault = CheckMarker(camera, limits, X_WC, marker, arm.capsules);
  if (fault != ViewFault::kNone) return fault;
  const Vector3d p_WC = X_WC.translation();
  const bool covered =
      IsCovered(p_WC, marker, arm.markers) || IsCovered(p_WC, marker, scene_markers);
  return covered ? ViewFault::kHidden : ViewFault::kNone;
}

TaskJacobian CompositeJacobian(const ViewModel& model, const ArmSample& sample,
                               const Isometry3d& X_WC) noexcept {
  assert(sample.markers.size() <= static_cast<std::size_t>(kMaxPoints));
  const Matrix3d R_CW = X_WC.linear().transpose();
  const Eigen::Matrix2d K = CalibrationJacobian(model.camera);
  const double focal = std::min(model.camera.fx, model.camera.fy);
  ImageOfMarkers image;
  for (std::size_t i = 0; i < sample.markers.size(); ++i) {
    const std::optional<ImagePoint> point =
        Project(R_CW * (sample.markers[i].p_W - X_WC.translation()));
    image.in_front[i] = point.has_value();
    if (!point) continue;
    image.pixel[i] = K * point->n;
    // A point that moves by d is seen as if the camera moved by -d: the translation columns of L.
    const Eigen::Matrix<double, 2, 3> by_point =
        -(K * PointInteraction(*point).leftCols<3>()) * R_CW;
    image.J[i].noalias() = by_point * sample.J_marker_W[i];
  }
  const std::vector<Feature>& features = model.features.features();
  const int n = model.arm.size();
  TaskJacobian J(static_cast<Eigen::Index>(features.size()), n);
  Eigen::Index rows = 0;
  RowByJoints row(n);
  for (const Feature& feature : features) {
    if (FeatureRow(feature, image, focal, &row)) J.row(rows++) = row;
  }
  J.conservativeResize(rows, n);
  return J;
}

const char* Name(ViewFault fault) noexcept {
  switch (fault) {
    case ViewFault::kNone:
      return "NONE";
    case ViewFault::kBehind:
      return "BEHIND";
    case ViewFault::kTooNear:
      return "TOO_NEAR";
    case ViewFault::kTooFar:
      return "TOO_FAR";
    case ViewFault::kOutOfImage:
      return "OUT_OF_IMAGE";
    case ViewFault::kFacesAway:
      return "FACES_AWAY";
    case ViewFault::kHidden:
      return "HIDDEN";
    case ViewFault::kTooSmall:
      return "TOO_SMALL";
  }
  return "?";
}

}  // namespace vantage
