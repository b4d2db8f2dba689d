#include "vantage/robot/arm_model.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <utility>

#include <kdl/frames.hpp>

#include "arm_data.h"
#include "message_text.h"
#include "vantage/math/error.h"

namespace vantage {
namespace {

std::string Element(const char* list, std::size_t index) {
  return std::string(list) + "[" + std::to_string(index) + "]";
}

void RequireJointCount(std::size_t count) {
  if (count < 1 || count > kMaxJoints) {
    throw ConfigError(
        "", "joints",
        "must be 1 to " + std::to_string(kMaxJoints) + ", are " + std::to_string(count));
  }
}

void RequirePose(const Eigen::Isometry3d& X, const std::string& key) {
  if (!IsPose(X)) throw ConfigError("", key, "must be a finite rigid motion");
}

void RequireLimits(const std::vector<JointLimits>& limits, std::size_t joints) {
  if (limits.size() != joints) {
    throw ConfigError("", "limits",
                      "must be given for each of " + std::to_string(joints) + " joints, are " +
                          std::to_string(limits.size()));
  }
  for (std::size_t i = 0; i < limits.size(); ++i) {
    const JointLimits& limit = limits[i];
    std::string reason;
    if (!std::isfinite(limit.lower) || !std::isfinite(limit.upper) ||
        !(limit.upper > limit.lower)) {
      reason = "range must be finite with upper > lower, is [" + Text({limit.lower}) + ", " +
               Text({limit.upper}) + "]";
    } else if (!std::isfinite(limit.velocity) || !(limit.velocity > 0.0)) {
      reason = "velocity must be finite and > 0, is " + Text({limit.velocity});
    } else if (!std::isfinite(limit.acceleration) || !(limit.acceleration > 0.0)) {
      reason = "acceleration must be finite and > 0, is " + Text({limit.acceleration});
    } else {
      continue;
    }
    throw ConfigError("", Element("limits", i), reason);
  }
}

void RequireLink(int link, const std::string& key, std::size_t joints) {
  if (link >= -1 && link < static_cast<int>(joints)) return;
  throw ConfigError(
      "", key,
      "link must be -1 (base) to " + std::to_string(joints - 1) + ", is " + std::to_string(link));
}

void RequireCapsules(const std::vector<Capsule>& capsules, std::size_t joints) {
  for (std::size_t i = 0; i < capsules.size(); ++i) {
    const Capsule& capsule = capsules[i];
    const std::string key = Element("capsules", i);
    RequireLink(capsule.link, key, joints);
    if (!capsule.p_LA.allFinite() || !capsule.p_LB.allFinite()) {
      throw ConfigError("", key, "ends must be finite");
    }
    if (!std::isfinite(capsule.radius) || !(capsule.radius > 0.0)) {
      throw ConfigError("", key, "radius must be finite and > 0, is " + Text({capsule.radius}));
    }
  }
}

bool HasSize(const Shape& shape) {
  const auto positive = [](double value) { return std::isfinite(value) && value > 0.0; };
  struct Visitor {
    decltype(positive)& is;
    bool operator()(const BoxShape& box) const {
      return is(box.size.x()) && is(box.size.y()) && is(box.size.z());
    }
    bool operator()(const CylinderShape& c) const { return is(c.radius) && is(c.length); }
    bool operator()(const SphereShape& sphere) const { return is(sphere.radius); }
    bool operator()(const CapsuleShape& c) const {
      return is(c.radius) && c.p_A.allFinite() && c.p_B.allFinite();
    }
    bool operator()(const MeshShape& mesh) const {
      return !mesh.path.empty() && mesh.scale.allFinite() && mesh.scale.cwiseAbs().minCoeff() > 0.0;
    }
  };
  return std::visit(Visitor{positive}, shape);
}

void RequireVisuals(const std::vector<ArmVisual>& visuals, std::size_t joints) {
  for (std::size_t i = 0; i < visuals.size(); ++i) {
    const std::string key = Element("visuals", i);
    RequireLink(visuals[i].link, key, joints);
    RequirePose(visuals[i].X_LV, key);
    if (!HasSize(visuals[i].shape)) {
      throw ConfigError("", key, "sizes must be finite and > 0, and a mesh must have a path");
    }
  }
}

std::vector<std::string> NamesOrDefaults(std::vector<std::string> names, std::size_t joints) {
  if (names.empty()) {
    for (std::size_t i = 0; i < joints; ++i) names.push_back("joint" + std::to_string(i + 1));
  }
  if (names.size() != joints) {
    throw ConfigError("", "joint_names",
                      "must be given for each of " + std::to_string(joints) + " joints, are " +
                          std::to_string(names.size()));
  }
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.empty()) throw ConfigError("", "joint_names", "must not be empty");
    if (!seen.insert(name).second) {
      throw ConfigError("", "joint_names", "'" + name + "' names two joints");
    }
  }
  return names;
}

ArmJoint MakeJoint(const Eigen::Isometry3d& X_before, const Eigen::Isometry3d& X_after) {
  const bool has_before = X_before.matrix() != Eigen::Isometry3d::Identity().matrix();
  return {has_before, X_before, X_after};
}

// KDL knows the conventions of Denavit and Hartenberg.
Eigen::Isometry3d FromKdl(const KDL::Frame& X) {
  Eigen::Isometry3d result = Eigen::Isometry3d::Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result.linear()(i, j) = X.M(i, j);
    result.translation()(i) = X.p(i);
  }
  return result;
}

ArmJoint DhJoint(DhConvention convention, const DhRow& row) {
  const bool revolute = row.kind == JointKind::kRevolute;
  const double theta = revolute ? row.offset : row.theta;
  const double d = revolute ? row.d : row.offset;
  if (convention == DhConvention::kStandard) {
    return MakeJoint(Eigen::Isometry3d::Identity(),
                     FromKdl(KDL::Frame::DH(row.a, row.alpha, d, theta)));
  }
  return MakeJoint(FromKdl(KDL::Frame::DH_Craig1989(row.a, row.alpha, 0.0, 0.0)),
                   FromKdl(KDL::Frame::DH_Craig1989(0.0, 0.0, d, theta)));
}

bool IsFinite(const DhRow& row) {
  return std::isfinite(row.theta) && std::isfinite(row.d) && std::isfinite(row.a) &&
         std::isfinite(row.alpha) && std::isfinite(row.offset);
}

// Everything but joints and kinds, checked.
std::shared_ptr<ArmModel::Data> CommonData(std::string name, std::size_t joints,
                                           std::vector<JointLimits> limits,
                                           const Eigen::Isometry3d& X_WBase,
                                           const Eigen::Isometry3d& X_LastE,
                                           std::vector<Capsule> capsules,
                                           std::vector<std::string> joint_names) {
  RequireJointCount(joints);
  RequireLimits(limits, joints);
  RequirePose(X_WBase, "base");
  RequirePose(X_LastE, "tool");
  RequireCapsules(capsules, joints);
  auto data = std::make_shared<ArmModel::Data>();
  data->name = std::move(name);
  data->joint_names = NamesOrDefaults(std::move(joint_names), joints);
  data->limits = std::move(limits);
  data->capsules = std::move(capsules);
  data->X_WBase = X_WBase;
  data->X_LastE = X_LastE;
  return data;
}

}  // namespace

ArmModel::ArmModel(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

ArmModel::ArmModel(std::string name, DhConvention convention, const std::vector<DhRow>& rows,
                   std::vector<JointLimits> limits, const Eigen::Isometry3d& X_WBase,
                   const Eigen::Isometry3d& X_LastE, std::vector<Capsule> capsules,
                   std::vector<std::string> joint_names) {
  auto data = CommonData(std::move(name), rows.size(), std::move(limits), X_WBase, X_LastE,
                         std::move(capsules), std::move(joint_names));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!IsFinite(rows[i])) throw ConfigError("", Element("joints", i), "must be finite");
    data->joint_kinds.push_back(rows[i].kind);
    data->joints.push_back(DhJoint(convention, rows[i]));
  }
  data->UpdateChain();
  data_ = std::move(data);
}

ArmModel::ArmModel(std::string name, const std::vector<JointTransform>& joints,
                   std::vector<JointLimits> limits, const Eigen::Isometry3d& X_WBase,
                   const Eigen::Isometry3d& X_LastE, std::vector<Capsule> capsules,
                   std::vector<std::string> joint_names) {
  auto data = CommonData(std::move(name), joints.size(), std::move(limits), X_WBase, X_LastE,
                         std::move(capsules), std::move(joint_names));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    RequirePose(joints[i].X_before, Element("joints", i));
    RequirePose(joints[i].X_after, Element("joints", i));
    data->joint_kinds.push_back(joints[i].kind);
    data->joints.push_back(MakeJoint(joints[i].X_before, joints[i].X_after));
  }
  data->UpdateChain();
  data_ = std::move(data);
}

const std::string& ArmModel::name() const noexcept {
  return data_->name;
}
int ArmModel::size() const noexcept {
  return data_->size();
}
const std::vector<std::string>& ArmModel::joint_names() const noexcept {
  return data_->joint_names;
}
const std::vector<JointKind>& ArmModel::joint_kinds() const noexcept {
  return data_->joint_kinds;
}
const std::vector<JointLimits>& ArmModel::limits() const noexcept {
  return data_->limits;
}
const std::vector<Capsule>& ArmModel::capsules() const noexcept {
  return data_->capsules;
}
const std::vector<ArmVisual>& ArmModel::visuals() const noexcept {
  return data_->visuals;
}
const Eigen::Isometry3d& ArmModel::X_WBase() const noexcept {
  return data_->X_WBase;
}
const Eigen::Isometry3d& ArmModel::X_LastE() const noexcept {
  return data_->X_LastE;
}

ArmModel ArmModel::WithLimits(std::vector<JointLimits> limits) const {
  RequireLimits(limits, data_->joints.size());
  auto data = std::make_shared<Data>(*data_);
  data->limits = std::move(limits);
  return ArmModel(std::move(data));
}

ArmModel ArmModel::WithTool(const Eigen::Isometry3d& X_LastE) const {
  RequirePose(X_LastE, "tool");
  auto data = std::make_shared<Data>(*data_);
  data->X_LastE = X_LastE;
  data->UpdateChain();
  return ArmModel(std::move(data));
}

ArmModel ArmModel::WithBase(const Eigen::Isometry3d& X_WBase) const {
  RequirePose(X_WBase, "base");
  auto data = std::make_shared<Data>(*data_);
  data->X_WBase = X_WBase;
  data->UpdateChain();
  return ArmModel(std::move(data));
}

ArmModel ArmModel::WithVisuals(std::vector<ArmVisual> visuals) const {
  RequireVisuals(visuals, data_->joints.size());
  auto data = std::make_shared<Data>(*data_);
  data->visuals = std::move(visuals);
  return ArmModel(std::move(data));
}

bool WithinLimits(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const std::vector<JointLimits>& limits = arm.limits();
  for (int i = 0; i < arm.size(); ++i) {
    if (!(q(i) >= limits[i].lower && q(i) <= limits[i].upper)) return false;
  }
  return true;
}

JointVector ClampToLimits(const ArmModel& arm, const JointVector& q) noexcept {
  assert(q.size() == arm.size());
  const std::vector<JointLimits>& limits = arm.limits();
  JointVector clamped = q;
  for (int i = 0; i < arm.size(); ++i) {
    clamped(i) = std::clamp(q(i), limits[i].lower, limits[i].upper);
  }
  return clamped;
}

}  // namespace vantage
