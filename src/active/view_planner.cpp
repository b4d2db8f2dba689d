#include "vantage/active/view_planner.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <queue>
#include <string>

#include "vantage/math/angles.h"
#include "vantage/math/error.h"
#include "vantage/math/spatial.h"
#include "view_candidates.h"
#include "view_scene.h"
#include "view_search.h"
#include "view_way.h"

namespace vantage {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

// A view that is spoilt for a reason unknown is not mended nearer to it than this [m or rad].
constexpr double kElsewhere = 0.2;
// Better views whose ways are tried before giving up.
constexpr int kMaxWays = 12;

struct LessWorth {
  bool operator()(const ViewCandidate* a, const ViewCandidate* b) const noexcept {
    return a->worth < b->worth;
  }
};

// True when every feature row is a coordinate of a point and both coordinates of each point are in:
// then w_c does not depend on the roll, with square pixels.
bool IgnoresRoll(const ViewModel& model) {
  if (model.camera.fx != model.camera.fy || model.camera.skew != 0.0) return false;
  std::array<int, kMaxPoints> axes{};
  for (const Feature& feature : model.features.features()) {
    if (feature.kind == FeatureKind::kPointX) {
      axes[feature.points[0]] |= 1;
    } else if (feature.kind == FeatureKind::kPointY) {
      axes[feature.points[0]] |= 2;
    } else {
      return false;
    }
  }
  return std::all_of(axes.begin(), axes.end(), [](int both) { return both == 0 || both == 3; });
}

}  // namespace

void Validate(const PlannerOptions& options) {
  const auto refuse = [](const char* key, const std::string& reason) {
    throw ConfigError("", std::string("active.planner.") + key, reason);
  };
  if (options.candidates < 8) {
    refuse("candidates", "must be >= 8, is " + std::to_string(options.candidates));
  }
  if (options.path_samples < 1 || options.path_samples > kMaxPathSamples) {
    refuse("path_samples", "must be in [1, " + std::to_string(kMaxPathSamples) + "], is " +
                               std::to_string(options.path_samples));
  }
  if (!(options.travel_cost >= 0.0) || !std::isfinite(options.travel_cost)) {
    refuse("travel_cost", "must be >= 0 per m or rad, is " + std::to_string(options.travel_cost));
  }
  if (!(options.cap > 1.0) || !std::isfinite(options.cap)) {
    refuse("cap", "must be > 1, is " + std::to_string(options.cap));
  }
  if (!(options.min_gain >= 0.0) || !std::isfinite(options.min_gain)) {
    refuse("min_gain", "must be >= 0, is " + std::to_string(options.min_gain));
  }
  if (!(options.max_mm_per_px > 0.0)) {
    refuse("max_mm_per_px", "must be > 0 mm/px, is " + std::to_string(options.max_mm_per_px));
  }
  const ViewLimits& limits = options.limits;
  if (!(limits.margin >= 0.0) || !std::isfinite(limits.margin)) {
    refuse("limits.margin", "must be >= 0 px, is " + std::to_string(limits.margin));
  }
  if (!(limits.min_depth > 0.0) || !std::isfinite(limits.min_depth)) {
    refuse("limits.min_depth", "must be > 0 m, is " + std::to_string(limits.min_depth));
  }
  if (!(limits.max_depth > limits.min_depth)) {
    refuse("limits.max_depth", "must be > min_depth, is " + std::to_string(limits.max_depth));
  }
  if (!(limits.max_incidence > 0.0 && limits.max_incidence < kPi / 2.0)) {
    refuse("limits.max_incidence",
           "must be in (0, pi/2) rad, is " + std::to_string(limits.max_incidence));
  }
  if (!(limits.min_semi_axis >= 0.0) || !std::isfinite(limits.min_semi_axis)) {
    refuse("limits.min_semi_axis", "must be >= 0 px, is " + std::to_string(limits.min_semi_axis));
  }
}

std::vector<ArmSample> SampleMotion(const ViewModel& model, const JointVector& q,
                                    const JointVector& q_goal, int samples) {
  const bool still = samples == 1 || (q_goal - q).cwiseAbs().maxCoeff() < 1e-6;
  const int count = still ? 1 : samples;
  std::vector<ArmSample> motion(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const double share = count == 1 ? 0.0 : static_cast<double>(i) / (count - 1);
    SampleArm(model, q + share * (q_goal - q), &motion[i]);
  }
  return motion;
}

ViewScore ScoreView(const ViewModel& model, const TriggerOptions& trigger,
                    const PlannerOptions& options, const std::vector<ArmSample>& motion,
                    const std::vector<PlacedMarker>& goal_markers, const Isometry3d& X_WC) {
  return ViewScene(model, trigger, options, motion, goal_markers).Evaluate(X_WC);
}

bool CanWatch(const ViewModel& model, const CameraRig& rig, const PlannerOptions& options,
              const std::vector<ArmSample>& motion, const std::vector<PlacedMarker>& goal_markers,
              const RigVector& q_c) {
  const TriggerOptions trigger;
  const ViewScene scene(model, trigger, options, motion, goal_markers);
  const auto watches = [&](const RigVector& view) {
    const Isometry3d X_WC = RigPose(rig, view);
    return std::all_of(motion.begin(), motion.end(),
                       [&](const ArmSample& sample) { return scene.Sees(sample, X_WC); });
  };
  if (watches(q_c)) return true;
  const std::vector<RigVector> views =
      CandidatePositions(rig, q_c, scene.Aim(), options.candidates);
  return std::any_of(views.begin(), views.end(), watches);
}

ViewPlan PlanView(const ViewModel& model, const CameraRig& rig, const TriggerOptions& trigger,
                  const PlannerOptions& options, const PlanRequest& request) {
  assert(request.q.size() == model.arm.size() && request.q_goal.size() == model.arm.size());
  assert(request.q_c.size() == rig.size() && request.q_c_stay.size() == rig.size());
  const std::vector<ArmSample> motion =
      SampleMotion(model, request.q, request.q_goal, options.path_samples);
  ViewScene scene(model, trigger, options, motion, request.goal_markers);
  ArmSample soon;
  if (request.q_soon.size() == model.arm.size()) {
    SampleArm(model, request.q_soon, &soon);
    scene.AlsoSee(soon);
  }
  if (request.certify) scene.Certify();
  if (request.goal_optional) scene.NeglectGoal();
  scene.Spare(request.spare_markers);

  ViewPlan plan;
  const Isometry3d X_WStay = RigPose(rig, request.q_c_stay);
  plan.stay = scene.Evaluate(X_WStay);
  if (!CanMove(rig)) {
    plan.verdict = PlanVerdict::kRigCannotMove;
    return plan;
  }
  const double stay_score = request.stay_is_spoiled ? scene.lowest() : plan.stay.score;
  const double wanted = stay_score + std::log1p(options.min_gain);
  const MarkerSet seen_at_start = scene.Seen(motion[0], RigPose(rig, request.q_c));

  const Vector3d aim_W = scene.Aim();
  ViewSearch search(scene, rig, options, request.q_c);
  std::vector<ViewCandidate> open =
      search.OpenWorkspace(aim_W, options.candidates, !IgnoresRoll(model));
  const auto spoils = [](const ViewCandidate& c, const Isometry3d& X_WSpoiled) {
    return (c.X_WC.translation() - X_WSpoiled.translation()).norm() +
               AngleBetween(X_WSpoiled.linear(), c.X_WC.linear()) <
           kElsewhere;
  };
  const auto far_enough = [&](const ViewCandidate& c) {
    if (request.stay_is_spoiled && spoils(c, X_WStay)) return false;
    return std::none_of(request.X_WSpoiled.begin(), request.X_WSpoiled.end(),
                        [&](const Isometry3d& X_WSpoiled) { return spoils(c, X_WSpoiled); });
  };
  std::priority_queue<ViewCandidate*, std::vector<ViewCandidate*>, LessWorth> queue;
  for (ViewCandidate& c : open) {
    if (c.view.seen > 0 && far_enough(c)) queue.push(&c);
  }

  // Best first; occlusion is checked only of what would be taken.
  bool any_view = plan.stay.seen > 0 && !request.stay_is_spoiled;
  bool any_better = false;
  ViewCandidate refined;
  for (int ways = 0; !queue.empty() && ways < kMaxWays;) {
    ViewCandidate* best = queue.top();
    queue.pop();
    if (!best->checked) {
      search.Close(best);
      if (best->view.seen > 0) queue.push(best);
      continue;
    }
    any_view = true;
    if (ways == 0) {
      refined = search.Refine(aim_W, *best);
      if (refined.worth > best->worth && far_enough(refined)) {
        queue.push(best);
        best = &refined;
      }
    }
    if (best->worth < wanted) break;
    any_better = true;
    ++ways;
    const ViewWay way = FindWay(scene, rig, request, aim_W, *best, seen_at_start);
    if (!way.found) continue;
    plan.verdict = PlanVerdict::kMove;
    plan.path = way.path;
    plan.duration = way.duration;
    plan.loses = way.losses > 0;
    plan.move = best->view;
    plan.gain = std::expm1(best->view.score - stay_score);
    plan.views_scored = search.scored();
    return plan;
  }
  plan.views_scored = search.scored();
  plan.verdict =
      any_better ? PlanVerdict::kNoPath : (any_view ? PlanVerdict::kNoGain : PlanVerdict::kNoView);
  return plan;
}

}  // namespace vantage
