#include "measure_evaluate.h"

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "vantage/camera/pinhole.h"
#include "vantage/math/angles.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Nothing but what the lens and the scene themselves rule out.
ViewLimits LeastLimits() {
  ViewLimits limits;
  limits.margin = 0.0;
  limits.min_depth = kMinDepth;
  limits.max_depth = std::numeric_limits<double>::infinity();
  limits.max_incidence = kPi / 2.0;
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

// Fills faults, uv, depth and views.
void ViewPoints(const MeasureSetup& setup, const JointVector& q, Measurement* m) {
  std::vector<PlacedCapsule> capsules;
  PlaceCapsules(setup.arm, q, &capsules);
  const Eigen::Isometry3d X_CW = m->X_WC.inverse();
  for (const MeasuredPoint& point : setup.points) {
    const Eigen::Isometry3d X_WP =
        point.on_body ? m->kinematics.X_WE : Eigen::Isometry3d::Identity();
    const Vector3d p_CP = X_CW * (X_WP * point.marker.p);
    PointView view = ViewOf(p_CP, point.on_body);
    m->faults.push_back(FaultOf(setup, point, X_WP, m->X_WC, capsules));
    m->depth.push_back(p_CP.z());
    m->uv.emplace_back(0.0, 0.0);
    if (view.visible) {
      m->uv.back() = ToUndistortedPixel(setup.camera, view.image.n);
    }
    view.visible = m->faults.back() == ViewFault::kNone;
    m->views.push_back(view);
  }
}

// ∂P/∂q of the points that features use and that the joints move before the camera.
std::vector<PointJacobian> MovingPoints(const MeasureSetup& setup, const Measurement& m) {
  std::set<int> used;
  for (const Feature& feature : setup.features.features()) {
    used.insert(feature.points.begin(), feature.points.end());
  }
  std::vector<PointJacobian> points;
  for (const int i : used) {
    const MeasuredPoint& point = setup.points[i];
    if (point.on_body == setup.eye_in_hand) continue;
    const Isometry3d& X_WE = m.kinematics.X_WE;
    points.push_back(PointJacobianOf(m.J_r, point.on_body
                                                ? Vector3d(X_WE.linear() * point.marker.p)
                                                : Vector3d(point.marker.p - X_WE.translation())));
  }
  return points;
}

ViewGeometry GeometryOf(const MeasureSetup& setup, const Measurement& m) {
  return {m.X_WC, m.kinematics.X_WE.translation(), m.J_r, setup.eye_in_hand};
}

RigVector ByRig(const MeasureSetup& setup, const ViewGradient& by, const RigVector& q_c) {
  if (setup.eye_in_hand) return RigVector(0);
  return RigJacobian(setup.rig, q_c).transpose() * by.camera;
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
  ViewPoints(setup, q, &m);
  setup.features.Evaluate(setup.camera, m.views, &m.rows);
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
  m.cause = DiagnoseLowMeasure(m.composite, MovingPoints(setup, m), needed, m.low);
  m.mm_per_px = HiddenMotion(setup, m);
  if (setup.translation_task > 0) {
    m.translation = ComputePaperProduct(m.J_v, m.J_r, setup.translation_task);
  }
  return m;
}

MeasureGradients Differentiate(const MeasureSetup& setup, const Measurement& m,
                               const RigVector& q_c) {
  MeasureGradients gradients;
  const ViewGeometry geometry = GeometryOf(setup, m);
  for (const bool composite : {false, true}) {
    LogMeasureGradient& gradient = composite ? gradients.composite : gradients.view;
    gradient.by.joints = JointVector::Zero(setup.arm.size());
    gradient.rig = RigVector::Zero(setup.eye_in_hand ? 0 : setup.rig.size());
    const LogGradient by_J = GradientOfLog(composite ? m.composite : m.view);
    gradient.status = by_J.status;
    if (by_J.status != GradientStatus::kOk) continue;
    gradient.by = composite ? GradientThroughComposite(setup.features, setup.camera, m.views,
                                                       m.rows, geometry, by_J.by_J)
                            : GradientThroughView(setup.features, setup.camera, m.views, m.rows,
                                                  geometry, by_J.by_J);
    gradient.rig = ByRig(setup, gradient.by, q_c);
  }
  return gradients;
}

std::optional<WhitenedMeasures> WhitenedMeasuresOf(const MeasureSetup& setup,
                                                   const Measurement& m) {
  if (setup.covariance.size() == 0) return std::nullopt;
  const int k = m.rows.size();
  Eigen::MatrixXd C(k, k);  // of the rows that are there
  for (int i = 0; i < k; ++i) {
    for (int j = 0; j < k; ++j) {
      C(i, j) = setup.covariance(m.rows.feature[i], m.rows.feature[j]);
    }
  }
  TaskJacobian J_v = m.J_v;
  TaskJacobian J_c = m.J_c;
  if (k > 0 && !(Whiten(C, &J_v) && Whiten(C, &J_c))) return std::nullopt;
  return WhitenedMeasures{MeasureOf(J_v), MeasureOf(J_c)};
}

MeasureReport Report(const MeasureSetup& setup) {
  Measurement m = Evaluate(setup, setup.q, setup.q_c);
  MeasureGradients gradients = Differentiate(setup, m, setup.q_c);
  std::optional<WhitenedMeasures> whitened = WhitenedMeasuresOf(setup, m);
  return {std::move(m), std::move(gradients), std::move(whitened), std::nullopt};
}

FeatureChoice ChooseFeatures(const MeasureSetup& setup, int count, int samples,
                             const SelectionOptions& options) {
  FeatureChoice choice;
  choice.options = options;
  choice.count = count;
  choice.samples = setup.waypoints.empty() ? 1 : std::max(1, samples);
  const auto all = static_cast<Eigen::Index>(setup.features.features().size());
  std::vector<TaskJacobian> J;
  for (int i = 0; i < choice.samples; ++i) {
    const JointVector q =
        setup.waypoints.empty()
            ? setup.q
            : JointsAlong(setup.waypoints, choice.samples == 1 ? 0.0 : i / (choice.samples - 1.0));
    const Measurement m = Evaluate(setup, q, setup.q_c);
    J.emplace_back(TaskJacobian::Zero(all, setup.arm.size()));
    for (int row = 0; row < m.rows.size(); ++row) {
      J.back().row(m.rows.feature[row]) = m.J_c.row(row);
    }
  }
  choice.selection = SelectFeatures(J, count, options);
  return choice;
}

}  // namespace vantage
