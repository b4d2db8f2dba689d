// One's own arm, camera and loop around the modules that bring KDL and ViSP: the planar arm servoed to an
// image goal, with the measures of the view on the way.

#include <cstdio>
#include <vector>

#include <vantage/control/servo_law.h>
#include <vantage/features/feature_set.h>
#include <vantage/robot/kinematics.h>

using namespace vantage;

namespace {

// The tip of the arm in the image, and J_c = J_v J_r.
struct View {
  FeatureRows rows;
  TaskJacobian J_c;
};

View Look(const ArmModel& arm, const CameraModel& camera, const Eigen::Isometry3d& X_WC,
          const JointVector& q) {
  View view;
  const Kinematics kinematics = ComputeKinematics(arm, q);
  const Eigen::Vector3d p_WE = kinematics.X_WE.translation();
  const FeatureSet features = FeatureSet::AllPoints(1);
  features.Evaluate(camera, {ViewOf(X_WC.inverse() * p_WE, true)}, &view.rows);
  view.J_c = ImageJacobian(view.rows.L_body, X_WC, p_WE) * kinematics.J_WE_W;
  return view;
}

}  // namespace

int main() {
  const ArmModel arm(
      "planar", DhConvention::kStandard,
      {{JointKind::kRevolute, 0, 0, 0.4, 0, 0}, {JointKind::kRevolute, 0, 0, 0.3, 0, 0}},
      std::vector<JointLimits>(2), Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity());
  CameraModel camera;
  Eigen::Isometry3d X_WC = Eigen::Isometry3d::Identity();  // above the plane, looking down
  X_WC.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  X_WC.translation() = Eigen::Vector3d(0.3, 0.3, 1.5);

  const double period = 0.01;  // [s]
  const FeatureRows goal = Look(arm, camera, X_WC, Eigen::Vector2d(0.2, 1.3)).rows;
  JointVector q = Eigen::Vector2d(0.9, 0.5), qdot = Eigen::Vector2d::Zero();
  double error = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const View view = Look(arm, camera, X_WC, q);
    const FeatureVector e = view.rows.s - goal.s;
    error = e.norm();
    if (i % 200 == 0)
      std::printf("%4.1f s  error %8.4f px  w_c %.4g\n", i * period, error, MeasureOf(view.J_c).w);
    const FeatureVector still = FeatureVector::Zero(e.size());
    const ServoLawResult law = ServoLaw({}, e, view.J_c, Decompose(view.J_c), still,
                                        ComputeVelocityBounds(arm.limits(), q, qdot, period));
    qdot = law.qdot;
    q += period * qdot;
  }
  std::printf("error %.3g px\n", error);
  return error < 1e-3 ? 0 : 1;
}
