#include "measure_evaluate.h"

#include <algorithm>
#include <limits>

#include "vantage/camera/pinhole.h"

namespace vantage {
namespace {

using Eigen::Vector3d;

// Nothing but what the lens and the scene themselves rule out.
ViewLimits LeastLimits() {
  ViewLimits limits;
  limits.margin = 0.0;
  limits.min_depth = kMinDepth;
  limits.max_depth = std::numeric_limits<double>::infinity();
  limits.max_incidence = M_PI / 2.0;
  return limits;
}

ViewFault FaultOf(const MeasureSetup& setup, const MeasuredPoint& point,
                  const Eigen::Isometry3d& X_WP, const Eigen::Isometry3d& X_WC,
                  const std::vector<PlacedCapsule>& capsules) {
  const Vector3d p_WP = X_WP * point.marker.p;
  if (point.one_sided) {
    const PlacedMarker marker{p_WP, X_WP.linear() * point.marker.normal, point.marker.radius};
    return CheckMarker(setup.camera, LeastLimits(), X_WC, marker, capsules);
  }
  const std::optional<ImagePoint> image = Project(X_WC.inverse() * p_WP);
  if (!image) return ViewFault::kBehind;
  if (setup.pixels && !InImage(setup.camera, ToPixel(setup.camera, image->n))) {
    return ViewFault::kOutOfImage;
  }
  return ViewFault::kNone;
}

// Fills faults, uv and depth, and returns the points as features are computed from them.
PointViews ViewPoints(const MeasureSetup& setup, const JointVector& q, Measurement* m) {
  std::vector<PlacedCapsule> capsules;
  PlaceCapsules(setup.arm, q, &capsules);
  const Eigen::Isometry3d X_CW = m->X_WC.inverse();
  const Eigen::Matrix2d K = CalibrationJacobian(setup.camera);
  PointViews views;
  for (const MeasuredPoint& point : setup.points) {
    const Eigen::Isometry3d X_WP =
        point.on_body ? m->kinematics.X_WE : Eigen::Isometry3d::Identity();
    const Vector3d p_CP = X_CW * (X_WP * point.marker.p);
    const std::optional<ImagePoint> image = Project(p_CP);
    m->faults.push_back(FaultOf(setup, point, X_WP, m->X_WC, capsules));
    m->depth.push_back(p_CP.z());
    m->uv.emplace_back(0.0, 0.0);
    if (image) m->uv.back() = K * image->n + Eigen::Vector2d(setup.camera.u0, setup.camera.v0);
    views.push_back(
        {image.value_or(ImagePoint{}), m->faults.back() == ViewFault::kNone, point.on_body});
  }
  return views;
}

std::optional<double> HiddenMotion(const MeasureSetup& setup, const Measurement& m) {
  if (!setup.pixels || setup.eye_in_hand) return std::nullopt;
  for (const Feature& feature : setup.features.features()) {
    if (UnitOf(feature, true) != "px") return std::nullopt;
  }
  std::vector<PointJacobian> points;
  for (std::size_t i = 0; i < setup.points.size(); ++i) {
    if (!setup.points[i].on_body) continue;
    points.push_back(PointJacobianOf(m.J_r, m.kinematics.X_WE.linear() * setup.points[i].marker.p));
  }
  return WorstMillimetresPerPixel(m.composite, points);
}

}  // namespace

Measurement Evaluate(const MeasureSetup& setup, const JointVector& q, const RigVector& q_c) {
  Measurement m;
  m.kinematics = ComputeKinematics(setup.arm, q);
  m.X_WC = setup.eye_in_hand ? m.kinematics.X_WE * setup.X_EC : RigPose(setup.rig, q_c);
  setup.features.Evaluate(setup.camera, ViewPoints(setup, q, &m), &m.rows);
  const Vector3d p_WE = m.kinematics.X_WE.translation();
  m.J_v = setup.eye_in_hand ? ImageJacobianEyeInHand(m.rows, m.X_WC, p_WE)
                            : ImageJacobian(m.rows.L_body, m.X_WC, p_WE);
  m.J_r = m.kinematics.J_WE_W;
  m.J_c = m.J_v * m.J_r;
  m.view = Decompose(m.J_v);
  m.arm = Decompose(m.J_r);
  m.composite = Decompose(m.J_c);
  m.coupling = CouplingOf(m.view.measure, m.arm.measure, m.composite.measure);
  const int rows = static_cast<int>(setup.features.features().size());
  const int needed = std::min({rows, setup.arm.size(), kTaskDimension});
  const Measure& composite = m.composite.measure;
  m.low = composite.rank < needed || composite.geometric_mean() < setup.threshold;
  m.cause = DiagnoseLowMeasure(m.composite, m.arm.measure.rank, m.J_r, needed, m.low);
  m.mm_per_px = HiddenMotion(setup, m);
  if (setup.translation_task > 0) {
    m.translation = ComputePaperProduct(m.J_v, m.J_r, setup.translation_task);
  }
  return m;
}

}  // namespace vantage
