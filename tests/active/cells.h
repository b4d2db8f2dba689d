#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/active_camera.h"
#include "vantage/active/view.h"
#include "vantage/active/view_planner.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/camera/pinhole.h"
#include "vantage/math/angles.h"

/// @file
/// Arms with markers and a rig, and random tasks for them, for the tests of the active camera.

namespace vantage::test {

struct Cell {
  const char* name;
  ViewModel model;
  CameraRig rig;
  JointVector q_lower, q_upper;  // where tests draw joints from
};

inline std::vector<JointLimits> WideLimits(int n) {
  return std::vector<JointLimits>(static_cast<std::size_t>(n), JointLimits{-3.1, 3.1, 1.0, 5.0});
}

inline CameraRig Sphere(const Eigen::Vector3d& target, double theta_upper = 1.5) {
  CameraRig rig;
  rig.kind = RigKind::kSpherical;
  rig.target_W = target;
  rig.axes = {{"R", 0.8, 2.5, 0.4, 0.8},
              {"theta", 0.0, theta_upper, 0.6, 1.2},
              {"phi", -2.0 * kPi, 2.0 * kPi, 0.6, 1.2},
              {"roll", -kPi, kPi, 0.8, 1.6}};
  rig.max_linear_speed = 0.4;
  return rig;
}

inline Eigen::Isometry3d Translation(double x, double y, double z) {
  return Eigen::Isometry3d(Eigen::Translation3d(x, y, z));
}

/// The planar arm of the paper's section 6, in half metres, one marker on its tip.
inline Cell Planar2() {
  DhRow row;
  row.a = 0.5;
  const ArmModel arm("planar2", DhConvention::kStandard, {row, row}, WideLimits(2),
                     Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(),
                     {{0, {-0.5, 0, 0}, {0, 0, 0}, 0.04}, {1, {-0.5, 0, 0}, {0, 0, 0}, 0.03}});
  return {"planar2",
          {arm, CameraModel{}, FeatureSet::AllPoints(1), {{1, {0, 0, 0.04}, {0, 0, 1}, 0.015}}},
          Sphere({0.4, 0.0, 0.0}),
          Eigen::Vector2d(-1.2, 0.5),
          Eigen::Vector2d(1.2, 2.2)};
}

inline ArmModel Puma3Arm() {
  DhRow base, upper, fore;
  base.d = 0.6;
  base.alpha = kPi / 2.0;
  upper.a = 0.45;
  fore.a = 0.4;
  return ArmModel("puma3", DhConvention::kStandard, {base, upper, fore}, WideLimits(3),
                  Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity(),
                  {{-1, {0, 0, 0}, {0, 0, 0.55}, 0.08},
                   {1, {-0.45, 0, 0}, {0, 0, 0}, 0.05},
                   {2, {-0.4, 0, 0}, {-0.03, 0, 0}, 0.04}});
}

/// The paper's 3-DOF arm with its features x1, y1, x2.
inline Cell Puma3Xyx() {
  const FeatureSet features(
      {{FeatureKind::kPointX, {0}}, {FeatureKind::kPointY, {0}}, {FeatureKind::kPointX, {1}}}, 2);
  return {"puma3_xyx",
          {Puma3Arm(),
           CameraModel{},
           features,
           {{1, {0.02, 0.06, 0.05}, {0, 0, 1}, 0.012}, {2, {0.02, -0.06, 0.05}, {0, 0, 1}, 0.012}}},
          Sphere({0.4, 0.0, 0.7}, 2.2),
          Eigen::Vector3d(-0.6, 0.2, -1.9),
          Eigen::Vector3d(0.6, 1.2, -0.7)};
}

/// The same with both coordinates of both points.
inline Cell Puma3Points() {
  Cell cell = Puma3Xyx();
  cell.name = "puma3_points";
  cell.model.features = FeatureSet::AllPoints(2);
  return cell;
}

/// The PUMA 560 with four markers on a plate.
inline Cell Puma560() {
  const auto row = [](double a, double d, double alpha) {
    DhRow r;
    r.a = a;
    r.d = d;
    r.alpha = alpha;
    return r;
  };
  const ArmModel arm(
      "puma560", DhConvention::kStandard,
      {row(0.0, 0.0, kPi / 2.0), row(0.4318, 0.0, 0.0), row(0.0203, 0.15005, -kPi / 2.0),
       row(0.0, 0.4318, kPi / 2.0), row(0.0, 0.0, -kPi / 2.0), row(0.0, 0.0, 0.0)},
      WideLimits(6), Translation(0, 0, 0.67), Translation(0, 0, 0.12),
      {{-1, {0, 0, -0.67}, {0, 0, 0.0}, 0.09},
       {1, {-0.4318, 0, 0.15}, {0, 0, 0.15}, 0.07},
       {2, {0, 0, 0}, {0, 0, 0.36}, 0.05},
       {4, {0, 0, 0}, {0, 0, 0.06}, 0.04}});
  std::vector<Marker> markers;
  for (int i = 0; i < 4; ++i) {
    const double x = i % 2 == 0 ? 0.06 : -0.06;
    const double y = i < 2 ? 0.06 : -0.06;
    markers.push_back({i + 1, {x, y, 0.0}, {0, 0, 1}, 0.012});
  }
  JointVector lower(6), upper(6);
  lower << -0.6, 0.3, -0.6, -0.7, 0.3, -1.0;
  upper << 0.6, 1.0, 0.4, 0.7, 1.2, 1.0;
  return {"puma560",
          {arm, CameraModel{}, FeatureSet::AllPoints(4), markers},
          Sphere({0.4, -0.15, 0.9}, 2.6),
          lower,
          upper};
}

/// Rigs of every kind for one cell, as each would stand about it.
inline CameraRig SphereWithHead(const CameraRig& sphere) {
  CameraRig rig = sphere;
  rig.axes.push_back({"pan", -0.6, 0.6, 1.0, 3.0});
  rig.axes.push_back({"tilt", -0.6, 0.6, 1.0, 3.0});
  return rig;
}

inline CameraRig Sector(const CameraRig& sphere) {
  CameraRig rig = sphere;
  rig.axes[1].lower = 0.5;
  rig.axes[1].upper = 1.5;
  rig.axes[2].lower = -kPi / 6.0 - kPi / 2.0;  // sixty degrees at the arm's right hand
  rig.axes[2].upper = kPi / 6.0 - kPi / 2.0;
  return rig;
}

inline Eigen::Isometry3d LookingFrom(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  const Eigen::Vector3d z = (at - from).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.linear() << x, z.cross(x), z;
  X.translation() = from;
  return X;
}

inline CameraRig RailBeside(const Eigen::Vector3d& target) {
  CameraRig rig;
  rig.kind = RigKind::kRail;
  rig.X_WC_fixed = LookingFrom(target + Eigen::Vector3d(0.0, -1.1, 0.5), target);
  rig.rail_W = Eigen::Vector3d::UnitX();
  rig.axes = {
      {"s", -1.5, 1.5, 0.4, 0.8}, {"pan", -1.5, 1.5, 1.2, 3.0}, {"tilt", -1.2, 1.2, 1.2, 3.0}};
  return rig;
}

inline CameraRig FreeAbout(const Eigen::Vector3d& target) {
  CameraRig rig;
  rig.kind = RigKind::kFree;
  rig.X_WC_fixed = LookingFrom(target + Eigen::Vector3d(0.1, -0.9, 0.6), target);
  rig.axes = {{"x", -1.2, 1.2, 0.4, 0.8},    {"y", -0.4, 0.8, 0.4, 0.8},
              {"z", -0.6, 0.8, 0.4, 0.8},    {"pan", -3.0, 3.0, 1.2, 3.0},
              {"tilt", -1.5, 1.5, 1.2, 3.0}, {"roll", -2.0, 2.0, 1.2, 3.0}};
  return rig;
}

inline std::vector<Cell> AllCells() {
  return {Planar2(), Puma3Xyx(), Puma3Points(), Puma560()};
}

inline JointVector RandomJoints(const Cell& cell, std::mt19937* random) {
  JointVector q(cell.model.arm.size());
  for (int i = 0; i < q.size(); ++i) {
    q(i) = std::uniform_real_distribution<double>(cell.q_lower(i), cell.q_upper(i))(*random);
  }
  return q;
}

inline RigVector RandomRig(const CameraRig& rig, std::mt19937* random) {
  RigVector q_c(rig.size());
  for (int i = 0; i < rig.size(); ++i) {
    q_c(i) = std::uniform_real_distribution<double>(rig.axes[i].lower, rig.axes[i].upper)(*random);
  }
  return q_c;
}

/// Composite Jacobian by central differences of the pixels' forward map: nothing of the code under test
/// but forward kinematics. Rows (u_0, v_0, u_1, v_1, ...).
inline Eigen::MatrixXd PixelsByDifferences(const ViewModel& model, const JointVector& q,
                                           const Eigen::Isometry3d& X_WC) {
  const auto pixels = [&](const JointVector& at) {
    Eigen::VectorXd uv(2 * model.markers.size());
    const Eigen::Isometry3d X_WE = EndEffectorPose(model.arm, at);
    for (std::size_t i = 0; i < model.markers.size(); ++i) {
      const Eigen::Vector3d p = X_WC.inverse() * (X_WE * model.markers[i].p);
      uv(2 * i) = model.camera.fx * p.x() / p.z();
      uv(2 * i + 1) = model.camera.fy * p.y() / p.z();
    }
    return uv;
  };
  Eigen::MatrixXd J(2 * model.markers.size(), q.size());
  for (int j = 0; j < q.size(); ++j) {
    JointVector ahead = q, behind = q;
    ahead(j) += 1e-5;
    behind(j) -= 1e-5;
    J.col(j) = (pixels(ahead) - pixels(behind)) / 2e-5;
  }
  return J;
}

/// True when the marker is on the picture (at least `margin` inside), faces the camera and no capsule is
/// in the way: by marching along the ray, apart from the code under test. Capsules that the marker lies
/// on do not count.
inline bool SeenByMarching(const CameraModel& camera, const Eigen::Isometry3d& X_WC,
                           const PlacedMarker& marker, const std::vector<PlacedCapsule>& capsules,
                           double margin) {
  const Eigen::Vector3d p_C = X_WC.inverse() * marker.p_W;
  if (p_C.z() <= 0.0) return false;
  const double u = camera.fx * p_C.x() / p_C.z() + camera.u0;
  const double v = camera.fy * p_C.y() / p_C.z() + camera.v0;
  if (u < margin || v < margin || u > camera.width - 1 - margin || v > camera.height - 1 - margin) {
    return false;
  }
  const Eigen::Vector3d ray = X_WC.translation() - marker.p_W;
  if (ray.dot(marker.normal_W) <= 0.0) return false;
  const auto inside = [](const Eigen::Vector3d& p, const PlacedCapsule& capsule, double radius) {
    const Eigen::Vector3d axis = capsule.p_WB - capsule.p_WA;
    const double along = (p - capsule.p_WA).dot(axis) / axis.squaredNorm();
    return (p - capsule.p_WA - std::clamp(along, 0.0, 1.0) * axis).norm() < radius;
  };
  for (const PlacedCapsule& capsule : capsules) {
    if (inside(marker.p_W, capsule, capsule.radius + 2e-3)) continue;
    for (int i = 1; i <= 200; ++i) {
      if (inside(marker.p_W + (i / 200.0) * ray, capsule, capsule.radius)) return false;
    }
  }
  return true;
}

inline bool SeesAllByMarching(const ViewModel& model, const ArmSample& sample,
                              const Eigen::Isometry3d& X_WC, double margin) {
  for (const PlacedMarker& marker : sample.markers) {
    if (!SeenByMarching(model.camera, X_WC, marker, sample.capsules, margin)) return false;
  }
  return true;
}

/// The trigger's measure by Eigen's SVD.
inline double GeometricMean(const Eigen::MatrixXd& J) {
  const Eigen::VectorXd sigma = J.jacobiSvd().singularValues();
  const int s = std::min<int>(6, static_cast<int>(sigma.size()));
  return std::exp(sigma.head(s).array().log().mean());
}

/// A task: an arm that has some way to go, seen by a camera from where it sees every marker.
struct Task {
  JointVector q, q_goal;
  RigVector q_c;
  double value;  // of the measure, now
};

/// Draws tasks until one starts in a view with the measure below `below`.
inline Task DrawTask(const Cell& cell, double below, std::mt19937* random) {
  const ViewLimits limits;
  for (;;) {
    Task task;
    task.q = RandomJoints(cell, random);
    task.q_goal = RandomJoints(cell, random);
    const ArmSample sample = SampleArm(cell.model, task.q);
    for (int tries = 0; tries < 50; ++tries) {
      task.q_c = RandomRig(cell.rig, random);
      const Eigen::Isometry3d X_WC = RigPose(cell.rig, task.q_c);
      bool seen = true;
      for (const PlacedMarker& marker : sample.markers) {
        seen = seen && CheckMarker(cell.model.camera, limits, X_WC, marker, sample.capsules) ==
                           ViewFault::kNone;
      }
      if (!seen) continue;
      task.value = GeometricMean(CompositeJacobian(cell.model, sample, X_WC));
      if (task.value < below) return task;
    }
  }
}

}  // namespace vantage::test
