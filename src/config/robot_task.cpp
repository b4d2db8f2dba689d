#include "vantage/config/robot_task.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iomanip>
#include <limits>
#include <optional>
#include <random>
#include <sstream>

#include "vantage/active/view_planner.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/observability/measures.h"
#include "vantage/robot/kinematics.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// Of the arm's reach.
constexpr double kMarkerRadius = 0.014;
constexpr double kMarkerSpread = 0.055;  // From the middle of four dots, along each axis.
constexpr double kLeastTravel = 0.12;    // From start to goal.
constexpr double kMostTravel = 0.45;

constexpr double kUsualAxisWorth = 0.7;  // Of dots on the likeliest side of the tool, in log w / s.
constexpr int kPathSamples = 5;
constexpr double kLargestTurn = 45.0 * kDegree;  // Of the markers from start to goal.
constexpr double kLowestNormal = -0.35;          // z: rigs look from above.

// --- the arm ---------------------------------------------------------------------------------------

// Range of a joint that starts and goals are taken from: inside the limits, within a turn.
std::pair<double, double> UsedRange(const JointLimits& limit, JointKind kind) {
  const double margin = 0.05 * (limit.upper - limit.lower);
  double lower = limit.lower + margin;
  double upper = limit.upper - margin;
  if (kind == JointKind::kRevolute && upper - lower > 2.0 * kPi) {
    const double middle = std::clamp(0.0, lower + kPi, upper - kPi);
    lower = middle - kPi;
    upper = middle + kPi;
  }
  return {lower, upper};
}

// One arm at many configurations: what is usual for it.
class Workspace {
 public:
  explicit Workspace(const ArmModel& arm) : arm_(arm) {
    constexpr int kSamples = 600;
    std::mt19937 random(1);
    std::vector<double> distances;
    for (int i = 0; i < kSamples; ++i) {
      const JointVector q = Random(&random);
      const Vector3d p_WE = EndEffectorPose(arm_, q).translation();
      mean_ += p_WE / kSamples;
      samples_.push_back(q);
    }
    for (const JointVector& q : samples_) {
      distances.push_back((EndEffectorPose(arm_, q).translation() - mean_).norm());
    }
    std::sort(distances.begin(), distances.end());
    reach_ = std::max(distances[distances.size() * 95 / 100], 0.02);
    FindUsualContacts();
    FindUsualFloor();
    std::vector<double> dexterities;
    for (const JointVector& q : samples_) dexterities.push_back(Dexterity(q));
    std::sort(dexterities.begin(), dexterities.end());
    usual_dexterity_ = dexterities[dexterities.size() / 2];
  }

  [[nodiscard]] double reach() const { return reach_; }
  [[nodiscard]] double usual_dexterity() const { return usual_dexterity_; }

  [[nodiscard]] JointVector Random(std::mt19937* random) const {
    JointVector q(arm_.size());
    for (int i = 0; i < arm_.size(); ++i) {
      const auto [lower, upper] = UsedRange(arm_.limits()[i], arm_.joint_kinds()[i]);
      q(i) = std::uniform_real_distribution<double>(lower, upper)(*random);
    }
    return q;
  }

  // Not far from q; within the used range.
  [[nodiscard]] JointVector Near(const JointVector& q, std::mt19937* random) const {
    JointVector near(arm_.size());
    for (int i = 0; i < arm_.size(); ++i) {
      const auto [lower, upper] = UsedRange(arm_.limits()[i], arm_.joint_kinds()[i]);
      const double most = arm_.joint_kinds()[i] == JointKind::kRevolute
                              ? std::min(0.6, 0.35 * (upper - lower))
                              : 0.35 * (upper - lower);
      near(i) = std::clamp(q(i) + std::uniform_real_distribution<double>(-most, most)(*random),
                           lower, upper);
    }
    return near;
  }

  // How far the arm is from a singularity: inverse condition of its Jacobian, lengths by the reach.
  [[nodiscard]] double Dexterity(const JointVector& q) const {
    return MeasureOf(ScaleTwistOfArm(ComputeKinematics(arm_, q).J_WE_W, reach_))
        .inverse_condition();
  }

  // Clear of itself and of the floor, as far as it usually is.
  [[nodiscard]] bool IsClear(const std::vector<PlacedCapsule>& capsules) const {
    for (const PlacedCapsule& c : capsules) {
      if (minds_floor_ && c.link >= 1 && Lowest(c) < floor_) return false;
    }
    for (std::size_t i = 0; i < capsules.size(); ++i) {
      for (std::size_t j = i + 1; j < capsules.size(); ++j) {
        if (!usual_contact_[i * capsules.size() + j] && Touch(capsules[i], capsules[j])) {
          return false;
        }
      }
    }
    return true;
  }

 private:
  static double Lowest(const PlacedCapsule& c) {
    return std::min(c.p_WA.z(), c.p_WB.z()) - c.radius;
  }
  static bool Touch(const PlacedCapsule& a, const PlacedCapsule& b) {
    PlacedCapsule both = b;
    both.radius += a.radius;
    return SegmentHitsCapsule(a.p_WA, a.p_WB, both);
  }

  // Bodies that touch in a good part of all configurations are built so.
  void FindUsualContacts() {
    const std::size_t n = arm_.capsules().size();
    std::vector<int> contacts(n * n, 0);
    std::vector<PlacedCapsule> placed;
    for (const JointVector& q : samples_) {
      PlaceCapsules(arm_, q, &placed);
      for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = i + 1; j < n; ++j) {
          contacts[i * n + j] += Touch(placed[i], placed[j]) ? 1 : 0;
        }
      }
    }
    usual_contact_.assign(n * n, false);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = i + 1; j < n; ++j) {
        const bool neighbours = std::abs(arm_.capsules()[i].link - arm_.capsules()[j].link) <= 1;
        usual_contact_[i * n + j] =
            neighbours || contacts[i * n + j] > 0.4 * static_cast<double>(samples_.size());
      }
    }
  }

  // The floor is z = 0 for an arm that stands on it; one that hangs or lies below has none.
  void FindUsualFloor() {
    std::vector<PlacedCapsule> placed;
    int above = 0;
    for (const JointVector& q : samples_) {
      PlaceCapsules(arm_, q, &placed);
      above += std::all_of(placed.begin(), placed.end(), [&](const PlacedCapsule& c) {
        return c.link < 1 || Lowest(c) > floor_;
      });
    }
    minds_floor_ = above > 0.1 * static_cast<double>(samples_.size());
  }

  const ArmModel& arm_;
  std::vector<JointVector> samples_;
  Vector3d mean_{Vector3d::Zero()};
  double reach_{1.0};
  std::vector<bool> usual_contact_;
  bool minds_floor_{false};
  double floor_{0.0};
  double usual_dexterity_{0.0};
};

// --- markers ---------------------------------------------------------------------------------------

int MarkersFor(int joints) {
  return joints <= 2 ? 1 : joints <= 4 ? 2 : joints == 5 ? 3 : 4;
}

// Dots in a square (up to four) or on a circle, in the plane across `normal` at `distance` from E.
std::vector<Marker> LayOut(int count, double reach, const Vector3d& normal, double distance) {
  const Vector3d e1 = normal.unitOrthogonal();
  const Vector3d e2 = normal.cross(e1);
  const double radius = kMarkerRadius * reach;
  // Rings, of twice the dots' radius, must not touch on a circle.
  const double needed = count <= 1 ? 0.0 : 2.6 * radius / std::sin(kPi / count);
  const double circle = count <= 1 ? 0.0 : std::max(std::sqrt(2.0) * kMarkerSpread * reach, needed);
  std::vector<Marker> markers;
  for (int i = 0; i < count; ++i) {
    const double angle = 2.0 * kPi * (i + 0.5) / count;
    Marker marker;
    marker.id = i;
    marker.p = distance * normal + circle * (std::cos(angle) * e1 + std::sin(angle) * e2);
    marker.normal = normal;
    marker.radius = radius;
    markers.push_back(marker);
  }
  return markers;
}

// The least distance from E along `normal` at which the dots stand free before the last link's body;
// nullopt when there is none within the arm's reach.
std::optional<double> FreeDistance(const ArmModel& arm, int count, double reach,
                                   const Vector3d& normal) {
  const std::vector<Marker> markers = LayOut(count, reach, normal, 0.0);
  const double step = 0.5 * kMarkerRadius * reach;
  const Isometry3d X_EL = arm.X_LastE().inverse();
  const auto is_free = [&](double distance) {
    for (const Marker& marker : markers) {
      const Vector3d p = marker.p + distance * normal;
      for (const Capsule& c : arm.capsules()) {
        if (c.link != arm.size() - 1) continue;
        const PlacedCapsule wide{X_EL * c.p_LA, X_EL * c.p_LB, c.radius + 2.5 * marker.radius, 0};
        if (SegmentHitsCapsule(p, p + 2.0 * reach * normal, wide)) return false;
      }
    }
    return true;
  };
  for (double distance = step; distance < reach; distance += step) {
    if (is_free(distance)) return distance;
  }
  return std::nullopt;
}

// Sets of markers to try, the likeliest first: E's z axis points out of most tools.
std::vector<std::vector<Marker>> MarkerChoices(const ArmModel& arm, double reach, int count) {
  struct Choice {
    double cost;
    std::vector<Marker> markers;
  };
  std::vector<Choice> choices;
  for (int axis = 2; axis >= 0; --axis) {
    for (const double sign : {1.0, -1.0}) {
      const Vector3d normal = sign * Vector3d::Unit(axis);
      const std::optional<double> distance = FreeDistance(arm, count, reach, normal);
      if (!distance) continue;
      const bool usual = axis == 2 && sign > 0.0;
      choices.push_back(
          {*distance + (usual ? 0.0 : 0.15 * reach), LayOut(count, reach, normal, *distance)});
    }
  }
  std::stable_sort(choices.begin(), choices.end(),
                   [](const Choice& a, const Choice& b) { return a.cost < b.cost; });
  std::vector<std::vector<Marker>> markers;
  for (Choice& choice : choices) markers.push_back(std::move(choice.markers));
  return markers;
}

std::vector<Marker> ReadMarkers(const std::string& path) {
  const Section root = ParseConfig(ReadConfigFile(path));
  std::vector<Marker> markers =
      LoadMarkers(root, "markers", 1, kMaxPoints, "Dots on the end effector, in its frame.");
  root.RejectUnknownKeys();
  return markers;
}

ViewModel MakeView(const ArmModel& arm, const std::vector<Marker>& markers) {
  return {arm, CameraModel(), FeatureSet::AllPoints(static_cast<int>(markers.size())), markers};
}

// --- start, goal and camera ------------------------------------------------------------------------

struct Motion {
  std::vector<ArmSample> samples;  // From start to goal.
  double worth{0.0};
};

struct Task {
  std::vector<Marker> markers;
  JointVector q_start, q_goal;
  Vector3d target;
  Eigen::Vector4d q_c;  // R, theta, phi, roll.
  double score{0.0};
};

Vector3d MeanMarker(const ArmSample& sample) {
  Vector3d mean = Vector3d::Zero();
  for (const PlacedMarker& marker : sample.markers) mean += marker.p_W;
  return mean / static_cast<double>(sample.markers.size());
}

std::optional<Motion> TryMotion(const ViewModel& view, const Workspace& workspace,
                                const JointVector& q_start, const JointVector& q_goal,
                                bool from_above) {
  Motion motion{SampleMotion(view, q_start, q_goal, kPathSamples), 0.0};
  const ArmSample& first = motion.samples.front();
  const ArmSample& last = motion.samples.back();
  const double travel = (MeanMarker(last) - MeanMarker(first)).norm() / workspace.reach();
  if (travel < kLeastTravel || travel > kMostTravel) return std::nullopt;
  const Eigen::AngleAxisd turn(first.kinematics.X_WE.linear().transpose() *
                               last.kinematics.X_WE.linear());
  if (std::abs(turn.angle()) > kLargestTurn) return std::nullopt;
  double dexterity = std::numeric_limits<double>::infinity();
  for (const ArmSample& sample : motion.samples) {
    if (!workspace.IsClear(sample.capsules)) return std::nullopt;
    for (const PlacedMarker& marker : sample.markers) {
      if (from_above && marker.normal_W.z() < kLowestNormal) return std::nullopt;
    }
    dexterity = std::min(dexterity, workspace.Dexterity(sample.q));
  }
  if (dexterity < 0.5 * workspace.usual_dexterity()) return std::nullopt;
  motion.worth = dexterity;
  return motion;
}

// The best motions among many, those that stay farthest from singularities first.
std::vector<Motion> FindMotions(const ViewModel& view, const Workspace& workspace,
                                bool from_above) {
  constexpr int kStarts = 500;
  constexpr int kGoalsPerStart = 6;
  constexpr std::size_t kKept = 30;
  std::mt19937 random(2);
  std::vector<Motion> motions;
  for (int i = 0; i < kStarts; ++i) {
    const JointVector q_start = workspace.Random(&random);
    std::vector<PlacedCapsule> placed;
    PlaceCapsules(view.arm, q_start, &placed);
    if (!workspace.IsClear(placed)) continue;
    for (int j = 0; j < kGoalsPerStart; ++j) {
      auto motion =
          TryMotion(view, workspace, q_start, workspace.Near(q_start, &random), from_above);
      if (motion) motions.push_back(std::move(*motion));
    }
  }
  std::stable_sort(motions.begin(), motions.end(),
                   [](const Motion& a, const Motion& b) { return a.worth > b.worth; });
  if (motions.size() > kKept) motions.resize(kKept);
  return motions;
}

ViewLimits LimitsFor(double reach) {
  ViewLimits limits;
  limits.min_depth = std::min(limits.min_depth, 0.3 * reach);
  limits.max_depth = std::max(limits.max_depth, 8.0 * reach);
  return limits;
}

// The best camera for a motion, among those round it; nullopt when none sees all of it.
std::optional<Task> FindCamera(const ViewModel& view, double reach, const Motion& motion) {
  Task task;
  task.markers = view.markers;
  task.q_start = motion.samples.front().q;
  task.q_goal = motion.samples.back().q;
  task.target = 0.5 * (MeanMarker(motion.samples.front()) + MeanMarker(motion.samples.back()));
  task.score = -std::numeric_limits<double>::infinity();
  PlannerOptions options;
  options.limits = LimitsFor(reach);
  for (const double distance : {1.4, 1.8, 2.3}) {
    for (const double theta : {30.0, 45.0, 60.0, 75.0}) {
      for (int k = 0; k < 24; ++k) {
        const Eigen::Vector4d q_c(distance * reach, theta * kDegree, (15.0 * k - 180.0) * kDegree,
                                  0.0);
        const ViewScore score = ScoreView(view, TriggerOptions(), options, motion.samples, {},
                                          SphericalPose(RigOrientation::kLookAt, task.target, q_c));
        if (score.seen < static_cast<int>(motion.samples.size()) || score.score <= task.score) {
          continue;
        }
        task.score = score.score;
        task.q_c = q_c;
      }
    }
  }
  if (!std::isfinite(task.score)) return std::nullopt;
  return task;
}

std::optional<Task> FindTask(const ArmModel& arm, const Workspace& workspace,
                             const std::vector<std::vector<Marker>>& choices) {
  std::optional<Task> best;
  const double good_enough = std::log(2.0 * TriggerOptions().threshold);
  for (const bool from_above : {true, false}) {
    for (const std::vector<Marker>& markers : choices) {
      // Dots that look along the tool's usual axis are what a person would glue on.
      const double advantage = &markers == &choices.front() ? 0.0 : kUsualAxisWorth;
      const ViewModel view = MakeView(arm, markers);
      Validate(view);
      for (const Motion& motion : FindMotions(view, workspace, from_above)) {
        std::optional<Task> task = FindCamera(view, workspace.reach(), motion);
        if (task && (!best || task->score > best->score + advantage)) best = std::move(task);
      }
      if (best && best->score > good_enough) return best;
    }
    if (best) return best;
  }
  return best;
}

// --- the text --------------------------------------------------------------------------------------

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

template <typename Vector>
std::string List(const Vector& v) {
  std::ostringstream text;
  text << std::setprecision(5) << "[";
  // No "-0", and nothing beyond a hundredth of a millimetre.
  for (int i = 0; i < v.size(); ++i)
    text << (i > 0 ? ", " : "") << std::round(v(i) * 1e5) / 1e5 + 0.0;
  return text.str() + "]";
}

std::string RobotEntry(const RobotTask& task) {
  std::error_code error;
  const bool is_file = std::filesystem::is_regular_file(task.robot, error);
  const std::string robot =
      is_file ? std::filesystem::absolute(task.robot).lexically_normal().string() : task.robot;
  if (task.base_link.empty() && task.tip_link.empty()) return Quoted(robot);
  std::string entry = "{urdf: " + Quoted(robot);
  if (!task.base_link.empty()) entry += ", base_link: " + Quoted(task.base_link);
  if (!task.tip_link.empty()) entry += ", tip_link: " + Quoted(task.tip_link);
  return entry + "}";
}

// Worst motion of a marker that one pixel may hide at the goal, seen by the task's camera [mm/px].
double GoalMillimetresPerPixel(const ArmModel& arm, const Task& task) {
  const ViewModel view = MakeView(arm, task.markers);
  const ArmSample goal = SampleArm(view, task.q_goal);
  const Isometry3d X_WC = SphericalPose(RigOrientation::kLookAt, task.target, task.q_c);
  std::vector<PointJacobian> points;
  for (const Marker& marker : task.markers) {
    points.push_back(
        PointJacobianOf(goal.kinematics.J_WE_W, goal.kinematics.X_WE.linear() * marker.p));
  }
  return WorstMillimetresPerPixel(Decompose(CompositeJacobian(view, goal, X_WC)), points);
}

// What a view must certify: what is usual, but not more than the task's own camera gives.
std::string CertificateEntry(const ArmModel& arm, double reach, const Task& task) {
  const double offered = GoalMillimetresPerPixel(arm, task);
  if (!std::isfinite(offered)) {
    return "  # So few markers do not show every motion of this arm: no view can certify its "
           "goal.\n"
           "  convergence: {max_mm_per_px: 1e6}\n";
  }
  std::ostringstream text;
  text << std::setprecision(3)
       << "  convergence: {max_mm_per_px: " << std::max(8.0 * std::max(1.0, reach), 1.5 * offered)
       << "}\n";
  return text.str();
}

double TriggerThreshold(const Task& task) {
  return std::min(TriggerOptions().threshold, std::floor(0.6 * std::exp(task.score)));
}

std::string Text(const RobotTask& robot, const ArmModel& arm, double reach, const Task& task) {
  const ViewLimits limits = LimitsFor(reach);
  const double speed = std::clamp(0.35 * reach, 0.05, 0.4);
  const double R = task.q_c(0);
  std::ostringstream text;
  text << std::setprecision(5);
  text << "# Written for " << arm.name()
       << ": markers, start, goal and camera were chosen from its reach of\n"
       << "# " << std::setprecision(2) << reach
       << " m, and are yours to change. Lengths in m, joints in rad (and m).\n"
       << std::setprecision(5)
       << "description: " << Quoted(arm.name() + ", markers, goal and camera chosen from its reach")
       << "\n"
       << "robot: " << RobotEntry(robot) << "\n"
       << "# Dots on the end effector, in its frame.\n"
       << "markers:\n";
  for (const Marker& marker : task.markers) {
    text << "  - {id: " << marker.id << ", position: " << List(marker.p)
         << ", normal: " << List(marker.normal) << ", radius: " << marker.radius
         << (marker.dark ? "" : ", dark: false") << "}\n";
  }
  text << "features: all_points\n"
       << "camera_rig:\n"
       << "  kind: spherical\n"
       << "  target: " << List(task.target) << "\n"
       << "  axes:\n"
       << "    R:     {lower: " << 0.7 * R << ", upper: " << 1.6 * R << ", start: " << R
       << ", max_speed: " << speed << ", max_acceleration: " << 3.0 * speed << "}\n"
       << "    theta: {lower_deg: 5, upper_deg: 85, start_deg: " << task.q_c(1) / kDegree
       << ", max_speed_deg_s: 25, max_acceleration_deg_s2: 80}\n"
       << "    phi:   {lower_deg: -180, upper_deg: 180, start_deg: " << task.q_c(2) / kDegree
       << ", max_speed_deg_s: 25, max_acceleration_deg_s2: 80}\n"
       << "    roll:  {lower_deg: -180, upper_deg: 180, start_deg: 0, max_speed_deg_s: 40, "
          "max_acceleration_deg_s2: 120}\n"
       << "active:\n"
       << "  # Below what the views along the way offer: a camera that can do no better shall not "
          "wander.\n"
       << "  trigger: {threshold: " << TriggerThreshold(task) << "}\n"
       << "  view_limits: {min_depth: " << limits.min_depth << ", max_depth: " << limits.max_depth
       << "}\n"
       << "servo:\n"
       << CertificateEntry(arm, reach, task) << "goal:\n"
       << "  joints: " << List(task.q_goal) << "\n"
       << "sim:\n"
       << "  start_joints: " << List(task.q_start) << "\n"
       << "  # A cell as it is: small errors of calibration and encoders, noise, two images of "
          "delay.\n"
       << "  arm: {encoder_bias_deg: 0.2, encoder_noise_deg: 0.005}\n"
       << "  camera: {noise_grey: 2, latency_frames: 2, position_error: "
       << 0.003 * std::min(1.0, reach) << ", rotation_error_deg: 0.3, focal_error: 0.005}\n";
  return text.str();
}

}  // namespace

std::string WriteScenarioFor(const RobotTask& task, RobotRemarks* remarks) {
  if (task.marker_count < 0 || task.marker_count > kMaxPoints) {
    throw ConfigError("", "markers",
                      "must be 1 to " + std::to_string(kMaxPoints) + ", are " +
                          std::to_string(task.marker_count));
  }
  if (!IsUrdfPath(task.robot) && !(task.base_link.empty() && task.tip_link.empty())) {
    throw ConfigError("", "robot", "'" + task.robot + "' is no URDF file: it has no links to name");
  }
  // The same text that the scenario will hold is what the arm is read from.
  const Section section = ParseConfig({task.robot, "", "robot: " + RobotEntry(task)});
  const ArmModel arm = LoadRobotUnder(section, "robot", remarks);
  const Workspace workspace(arm);
  const int count = task.marker_count > 0 ? task.marker_count : MarkersFor(arm.size());
  const std::vector<std::vector<Marker>> choices =
      task.marker_file.empty() ? MarkerChoices(arm, workspace.reach(), count)
                               : std::vector<std::vector<Marker>>{ReadMarkers(task.marker_file)};
  const std::optional<Task> found = FindTask(arm, workspace, choices);
  if (!found) {
    throw ConfigError(
        task.robot, "",
        "found no motion of " + arm.name() +
            " along which a camera above it sees all markers: write a scenario by hand");
  }
  return Text(task, arm, workspace.reach(), *found);
}

}  // namespace vantage
