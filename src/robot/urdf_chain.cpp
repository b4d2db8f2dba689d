#include "urdf_chain.h"

#include <algorithm>
#include <set>

#include "message_text.h"
#include "vantage/math/sizes.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using urdf::JointConstSharedPtr;
using urdf::LinkConstSharedPtr;

bool IsFixed(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::FIXED;
}

bool Moves(const urdf::Joint& joint) {
  return joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS ||
         joint.type == urdf::Joint::PRISMATIC;
}

LinkConstSharedPtr RequireLink(const UrdfDocument& document, const std::string& name,
                               const char* role) {
  LinkConstSharedPtr link = document.model().getLink(name);
  if (link == nullptr) {
    constexpr std::size_t kMost = 12;
    std::vector<std::string> names;
    for (const auto& entry : document.model().links_) names.push_back(entry.first);
    document.Fail(std::string(role) + " '" + name +
                  "' is no link of this file; its links: " + Listed(names, kMost));
  }
  return link;
}

std::vector<JointConstSharedPtr> JointsDownTo(const UrdfDocument& document,
                                              const LinkConstSharedPtr& base,
                                              const LinkConstSharedPtr& tip) {
  std::vector<JointConstSharedPtr> joints;
  for (LinkConstSharedPtr link = tip; link != base; link = link->getParent()) {
    if (link->parent_joint == nullptr) {
      document.FailLink(tip->name, "the tip link is not below the base link '" + base->name + "'");
    }
    joints.push_back(link->parent_joint);
  }
  std::reverse(joints.begin(), joints.end());
  return joints;
}

// One link below the base, as a possible end of the arm.
struct End {
  LinkConstSharedPtr link;
  std::string body;  // Link behind the last moving joint: ends of one body differ by fixed joints.
  int moving{0};     // Moving joints from the base.
  int joints{0};     // All joints from the base.
};

// Every link that a chain may reach: not through joints that mimic, are mimicked (they are one
// degree of freedom with others) or are no joints of an arm.
std::vector<End> ReachableEnds(const urdf::ModelInterface& model, const LinkConstSharedPtr& base) {
  std::set<std::string> mimicked;
  for (const auto& entry : model.joints_) {
    if (entry.second->mimic != nullptr) mimicked.insert(entry.second->mimic->joint_name);
  }
  std::vector<End> ends{{base, base->name, 0, 0}};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const End end = ends[i];
    for (const auto& joint : end.link->child_joints) {
      const bool moves = Moves(*joint);
      if (!moves && !IsFixed(*joint)) continue;
      if (joint->mimic != nullptr || mimicked.count(joint->name) != 0) continue;
      ends.push_back({model.getLink(joint->child_link_name),
                      moves ? joint->child_link_name : end.body, end.moving + (moves ? 1 : 0),
                      end.joints + 1});
    }
  }
  return ends;
}

// Names that say "the tool sits here", the clearest first: ROS-Industrial's, and common ones.
int NameRank(const std::string& link) {
  const auto has = [&](const char* part) { return link.find(part) != std::string::npos; };
  if (has("tool0")) return 0;
  if (has("tcp")) return 1;
  if (has("end_effector") || has("ee_link")) return 2;
  return 3;
}

// The link where the ways to two links part.
std::string Fork(const LinkConstSharedPtr& a, const LinkConstSharedPtr& b) {
  std::set<std::string> above_a;
  for (LinkConstSharedPtr link = a; link != nullptr; link = link->getParent()) {
    above_a.insert(link->name);
  }
  for (LinkConstSharedPtr link = b; link != nullptr; link = link->getParent()) {
    if (above_a.count(link->name) != 0) return link->name;
  }
  return "";
}

void FindDefaultTip(const UrdfDocument& document, const LinkConstSharedPtr& base,
                    UrdfChain* chain) {
  std::vector<End> ends = ReachableEnds(document.model(), base);
  const auto more = [](const End& a, const End& b) {
    if (a.moving != b.moving) return a.moving > b.moving;
    const int rank_a = NameRank(a.link->name);
    const int rank_b = NameRank(b.link->name);
    return rank_a != rank_b ? rank_a < rank_b : a.joints > b.joints;
  };
  std::stable_sort(ends.begin(), ends.end(), more);
  const End& best = ends.front();
  if (best.moving == 0) {
    document.FailLink(base->name, "no joint of an arm moves below this base link");
  }
  for (const End& end : ends) {
    if (end.moving == best.moving && end.body != best.body) {
      document.FailLink(Fork(best.link, end.link),
                        "the arm branches here, and no branch is longer than the others: name the "
                        "tip link, for instance '" +
                            best.link->name + "' or '" + end.link->name + "'");
    }
  }
  chain->tip_link = best.link->name;
  for (const End& end : ends) {
    if (end.body == best.body && end.link != best.link) chain->other_tips.push_back(end.link->name);
  }
}

// Value that a joint off the chain is frozen at [rad or m].
double FrozenValue(const urdf::Joint& joint) {
  if (joint.limits == nullptr || joint.type == urdf::Joint::CONTINUOUS) return 0.0;
  if (!(joint.limits->lower <= joint.limits->upper)) return 0.0;
  return std::clamp(0.0, joint.limits->lower, joint.limits->upper);
}

// The child link in the parent link's frame, with the joint at a value.
Isometry3d JointPose(const urdf::Joint& joint, double value) {
  Isometry3d X = ToEigen(joint.parent_to_joint_origin_transform);
  const Eigen::Vector3d axis = ToEigen(joint.axis);
  if (!Moves(joint) || value == 0.0 || !(axis.norm() > 0.0)) return X;
  if (joint.type == urdf::Joint::PRISMATIC) {
    X.translate(value * axis.normalized());
  } else {
    X.rotate(Eigen::AngleAxisd(value, axis.normalized()));
  }
  return X;
}

}  // namespace

Eigen::Vector3d ToEigen(const urdf::Vector3& v) {
  return {v.x, v.y, v.z};
}

Isometry3d ToEigen(const urdf::Pose& pose) {
  Isometry3d X = Isometry3d::Identity();
  X.translation() = ToEigen(pose.position);
  const urdf::Rotation& r = pose.rotation;
  X.linear() = Eigen::Quaterniond(r.w, r.x, r.y, r.z).toRotationMatrix();
  return X;
}

UrdfChain FindChain(const UrdfDocument& document, const std::string& base_link,
                    const std::string& tip_link) {
  UrdfChain chain;
  const LinkConstSharedPtr base = base_link.empty() ? document.model().getRoot()
                                                    : RequireLink(document, base_link, "base link");
  chain.base_link = base->name;
  if (tip_link.empty()) {
    FindDefaultTip(document, base, &chain);
  } else {
    chain.tip_link = RequireLink(document, tip_link, "tip link")->name;
  }
  chain.joints = JointsDownTo(document, base, document.model().getLink(chain.tip_link));
  return chain;
}

std::vector<JointConstSharedPtr> MovingJoints(const UrdfDocument& document,
                                              const UrdfChain& chain) {
  std::vector<JointConstSharedPtr> moving;
  for (const JointConstSharedPtr& joint : chain.joints) {
    if (IsFixed(*joint)) continue;
    if (!Moves(*joint)) {
      document.FailJoint(joint->name,
                         joint->type == urdf::Joint::FLOATING
                             ? "is floating: an arm has revolute, continuous, prismatic "
                               "and fixed joints"
                         : joint->type == urdf::Joint::PLANAR
                             ? "is planar: an arm has revolute, continuous, prismatic "
                               "and fixed joints"
                             : "is of no known type");
    }
    if (joint->mimic != nullptr) {
      document.FailJoint(joint->name, "mimics '" + joint->mimic->joint_name +
                                          "': an arm's joints move on their own");
    }
    moving.push_back(joint);
  }
  if (moving.empty()) {
    document.FailLink(chain.tip_link,
                      "no joint moves between it and the base link '" + chain.base_link + "'");
  }
  if (moving.size() > kMaxJoints) {
    document.FailLink(chain.tip_link, std::to_string(moving.size()) +
                                          " joints move between it and the base link '" +
                                          chain.base_link + "'; at most " +
                                          std::to_string(kMaxJoints) + " are taken");
  }
  return moving;
}

std::map<std::string, Attachment> AttachLinks(const UrdfDocument& document, const UrdfChain& chain,
                                              std::vector<std::string>* frozen) {
  std::map<std::string, int> moved_by;  // Joint name to index among the arm's.
  std::set<std::string> on_chain;
  for (const JointConstSharedPtr& joint : chain.joints) {
    on_chain.insert(joint->name);
    if (Moves(*joint)) moved_by.emplace(joint->name, static_cast<int>(moved_by.size()));
  }
  std::map<std::string, Attachment> attachments{{chain.base_link, {}}};
  std::vector<LinkConstSharedPtr> open{document.model().getLink(chain.base_link)};
  const auto attach = [&](const std::string& link, int to, const Isometry3d& X) {
    if (!attachments.emplace(link, Attachment{to, X}).second) return;
    open.push_back(document.model().getLink(link));
  };
  const auto frozen_pose = [&](const urdf::Joint& joint) {
    if (!IsFixed(joint) && on_chain.count(joint.name) == 0) frozen->push_back(joint.name);
    return JointPose(joint, FrozenValue(joint));
  };
  for (std::size_t i = 0; i < open.size(); ++i) {
    const LinkConstSharedPtr link = open[i];
    const Attachment here = attachments.at(link->name);
    for (const auto& joint : link->child_joints) {
      if (attachments.count(joint->child_link_name) != 0) continue;
      const auto moving = moved_by.find(joint->name);
      if (moving != moved_by.end()) {
        attach(joint->child_link_name, moving->second, Isometry3d::Identity());
      } else {
        attach(joint->child_link_name, here.link, here.X_LU * frozen_pose(*joint));
      }
    }
    // What stands above the base: a table, a torso.
    const auto& above = link->parent_joint;
    if (above != nullptr && attachments.count(above->parent_link_name) == 0) {
      attach(above->parent_link_name, here.link, here.X_LU * frozen_pose(*above).inverse());
    }
  }
  return attachments;
}

}  // namespace vantage
