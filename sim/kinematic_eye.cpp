#include "sim/kinematic_eye.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "vantage/vision/disc_blob.h"

namespace vantage::sim {
namespace {

using Eigen::Isometry3d;

}  // namespace

KinematicEye::KinematicEye(ArmModel arm, const CameraModel& camera,
                           std::vector<Marker> tool_markers, std::vector<Marker> goal_markers,
                           double sigma_px, std::uint64_t seed)
    : arm_(std::move(arm)),
      camera_(camera),
      tool_markers_(std::move(tool_markers)),
      goal_markers_(std::move(goal_markers)),
      random_(seed),
      noise_(0.0, sigma_px) {}

bool KinematicEye::Sees(const Isometry3d& X_WC, const Isometry3d& X_WF, const Marker& marker,
                        Eigen::Vector2d* pixel) const {
  const std::optional<DiscImage> image = ProjectDisc(camera_, X_WC.inverse() * X_WF, marker);
  if (!image || image->cos_incidence <= 0.0) return false;
  const DiscOptions detectable;
  const auto squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(image->shape).eigenvalues();
  const double least = detectable.min_semi_axis * detectable.min_semi_axis;
  const double most = detectable.max_semi_axis * detectable.max_semi_axis;
  if (!(squares(0) >= least && squares(1) <= most)) return false;
  // The ring, twice as wide as the disc, must be in the image too.
  const Eigen::Vector2d reach = 2.0 * image->shape.diagonal().cwiseSqrt();
  const Eigen::Vector2d p = image->centroid;
  if (!InImage(camera_, p - reach, detectable.border) ||
      !InImage(camera_, p + reach, detectable.border)) {
    return false;
  }
  const PlacedMarker placed{X_WF * marker.p, X_WF.linear() * marker.normal, marker.radius};
  const Eigen::Vector3d p_WC = X_WC.translation();
  if (IsHidden(p_WC, placed, capsules_) || IsCovered(p_WC, placed, plates_)) return false;
  *pixel = image->centre;
  return true;
}

void KinematicEye::See(Time /*now*/, const Isometry3d& X_WC_true, const JointVector& q_true,
                       const Isometry3d& X_WG, const std::vector<MarkerPrediction>& predictions,
                       ImageFeatures* features) {
  PlaceCapsules(arm_, q_true, &capsules_);
  const Isometry3d X_WE = EndEffectorPose(arm_, q_true);
  plates_.clear();
  const auto place = [&](const std::vector<Marker>& markers, const Isometry3d& X_WF) {
    for (const Marker& marker : markers) {
      plates_.push_back({X_WF * marker.p, X_WF.linear() * marker.normal, marker.radius});
    }
  };
  place(tool_markers_, X_WE);
  place(goal_markers_, X_WG);
  features->count = 0;
  for (const MarkerPrediction& prediction : predictions) {
    if (features->count == kMaxMarkers) break;
    MarkerMeasurement& measured = features->markers[features->count++];
    measured = {prediction.id, Eigen::Vector2d::Zero(), false};
    const auto look = [&](const std::vector<Marker>& markers, const Isometry3d& X_WF) {
      for (const Marker& marker : markers) {
        if (marker.id == prediction.id) {
          measured.valid = Sees(X_WC_true, X_WF, marker, &measured.pixel);
        }
      }
    };
    look(tool_markers_, X_WE);
    look(goal_markers_, X_WG);
    // Drawn whether seen or not: the noise of one marker does not depend on the others.
    const double u = noise_(random_);
    const double v = noise_(random_);
    measured.pixel += Eigen::Vector2d(u, v);
  }
}

}  // namespace vantage::sim
