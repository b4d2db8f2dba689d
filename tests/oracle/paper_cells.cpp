#include "paper_cells.h"

#include <utility>

namespace vantage::test {
namespace {

std::vector<JointLimits> Wide(std::size_t joints) {
  return std::vector<JointLimits>(joints, {-100.0, 100.0, 1.0, 10.0});
}

ArmModel Arm(const char* name, const std::vector<DhRow>& rows, const Eigen::Isometry3d& X_WBase,
             double tool_z) {
  Eigen::Isometry3d X_LastE = Eigen::Isometry3d::Identity();
  X_LastE.translation().z() = tool_z;
  return ArmModel(name, DhConvention::kStandard, rows, Wide(rows.size()), X_WBase, X_LastE);
}

DhRow Revolute(double d, double a, double alpha) {
  return {JointKind::kRevolute, 0.0, d, a, alpha, 0.0};
}

CameraModel Metric(double f) {
  CameraModel camera;
  camera.fx = camera.fy = f;
  camera.u0 = camera.v0 = camera.skew = 0.0;
  return camera;
}

OracleCase Cell(const ArmModel& arm, std::vector<OraclePoint> points, FeatureSet features,
                RigOrientation orientation, double f) {
  OracleSphere sphere;
  sphere.rig.kind = RigKind::kSpherical;
  sphere.rig.orientation = orientation;
  for (const char* name : {"R", "theta", "phi", "roll"}) {
    sphere.rig.axes.push_back({name, -1e6, 1e6, 1.0, 1.0});
  }
  sphere.q_c = RigVector::Zero(4);
  OracleCamera camera;
  camera.model = Metric(f);
  camera.sphere = sphere;
  return {"",     "", arm, JointVector::Zero(arm.size()), std::move(points), std::move(features),
          camera, 6};
}

}  // namespace

ArmModel PlanarArm(double l1, double l2) {
  // theta1 from +Y towards +X: the plane is looked at from below.
  Eigen::Isometry3d X_WBase = Eigen::Isometry3d::Identity();
  X_WBase.linear() << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  return Arm("planar", {Revolute(0, l1, 0), Revolute(0, l2, 0)}, X_WBase, 0.0);
}

ArmModel SimplePuma(double l2, double l3, double h) {
  return Arm("puma", {Revolute(h, 0, kPi / 2), Revolute(0, l2, 0), Revolute(0, l3, 0)},
             Eigen::Isometry3d::Identity(), 0.0);
}

ArmModel Puma560ToWrist(double a2, double a3, double d3, double d4) {
  return Arm("puma560", {Revolute(0, 0, kPi / 2), Revolute(0, a2, 0), Revolute(d3, a3, -kPi / 2)},
             Eigen::Isometry3d::Identity(), d4);
}

OracleCase PointCell(const ArmModel& arm, RigOrientation orientation, double f) {
  return Cell(arm, {{true, Eigen::Vector3d::Zero()}}, FeatureSet::AllPoints(1), orientation, f);
}

OracleCase TwoPointCell(const ArmModel& arm, const Eigen::Vector3d& p_EP2, double f,
                        bool all_four) {
  const FeatureSet three(
      {{FeatureKind::kPointX, {0}}, {FeatureKind::kPointY, {0}}, {FeatureKind::kPointX, {1}}}, 2);
  return Cell(arm, {{true, Eigen::Vector3d::Zero()}, {true, p_EP2}},
              all_four ? FeatureSet::AllPoints(2) : three, RigOrientation::kLookAt, f);
}

Evaluated At(OracleCase cell, const JointVector& q, const Sphere& camera) {
  cell.q = q;
  OracleSphere& sphere = *cell.camera.sphere;
  sphere.q_c << camera.R, camera.theta, camera.phi, camera.roll;
  cell.camera.X = RigPose(sphere.rig, sphere.q_c);
  return Evaluate(std::move(cell));
}

JointVector Joints(std::initializer_list<double> values) {
  JointVector q(static_cast<Eigen::Index>(values.size()));
  Eigen::Index i = 0;
  for (const double value : values) q(i++) = value;
  return q;
}

std::vector<double> Linspace(double a, double b, int n) {
  std::vector<double> values;
  for (int i = 0; i < n; ++i) values.push_back(i == n - 1 ? b : a + i * ((b - a) / (n - 1)));
  return values;
}

double Trapezoid(const std::vector<double>& values, double step) {
  double sum = 0.5 * (values.front() + values.back());
  for (std::size_t i = 1; i + 1 < values.size(); ++i) sum += values[i];
  return sum * step;
}

PaperProduct ProductOf(const Evaluated& e, int dimension) {
  return ComputePaperProduct(e.J_v, e.kinematics.J_WE_W, dimension);
}

}  // namespace vantage::test
