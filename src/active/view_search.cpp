#include "view_search.h"

#include "vantage/math/spatial.h"
#include "view_candidates.h"

namespace vantage {

using Eigen::Vector3d;

ViewSearch::ViewSearch(const ViewScene& scene, const CameraRig& rig, const PlannerOptions& options,
                       const RigVector& from)
    : scene_(scene), rig_(rig), options_(options), from_(from), X_WFrom_(RigPose(rig, from)) {}

ViewCandidate ViewSearch::Open(const RigVector& q_c) {
  ++scored_;
  ViewCandidate c;
  c.q_c = q_c;
  c.X_WC = RigPose(rig_, q_c);
  c.travel = (c.X_WC.translation() - X_WFrom_.translation()).norm() +
             AngleBetween(X_WFrom_.linear(), c.X_WC.linear());
  c.view.seen = scene_.CountUnobstructed(c.X_WC, &c.view.fault);
  for (int i = 0; i < c.view.seen; ++i) c.values[i] = scene_.ValueAt(i, c.X_WC);
  if (c.view.seen == scene_.size()) c.uncertified = scene_.Uncertified(c.X_WC);
  Rate(&c);
  return c;
}

void ViewSearch::Close(ViewCandidate* c) const {
  c->checked = true;
  const int seen = scene_.CountNotHidden(c->X_WC, c->view.seen);
  if (seen == c->view.seen) return;
  c->view.seen = seen;
  c->view.fault = ViewFault::kHidden;
  Rate(c);
}

void ViewSearch::Rate(ViewCandidate* c) const {
  c->view.score = scene_.Score(c->values, c->view.seen);
  if (c->view.seen == scene_.size()) c->view.score -= c->uncertified;
  c->worth = c->view.score - options_.travel_cost * c->travel;
}

std::vector<ViewCandidate> ViewSearch::OpenWorkspace(const Vector3d& aim_W, int count,
                                                     bool roll_matters) {
  std::vector<ViewCandidate> open;
  open.reserve(static_cast<std::size_t>(count) + 1);
  const std::vector<double> rolls = OtherRolls(rig_, from_);
  const int roll_axis = HeadOf(rig_).roll;
  for (const RigVector& position : CandidatePositions(rig_, from_, aim_W, count)) {
    ViewCandidate best = Open(position);
    // A roll also turns the frame of the image round the markers.
    if (roll_matters || best.view.seen < scene_.size()) {
      for (const double roll : rolls) {
        RigVector rolled = position;
        rolled(roll_axis) = roll;
        const ViewCandidate other = Open(rolled);
        if (other.worth > best.worth) best = other;
      }
    }
    open.push_back(best);
  }
  return open;
}

ViewCandidate ViewSearch::Refine(const Vector3d& aim_W, ViewCandidate best) {
  for (const double scale : {1.0, 1.0, 0.5, 0.5, 0.25, 0.25}) {
    ViewCandidate better = best;
    for (const RigVector& q_c : Neighbours(rig_, best.q_c, aim_W, scale)) {
      ViewCandidate neighbour = Open(q_c);
      if (neighbour.worth <= better.worth) continue;
      Close(&neighbour);
      if (neighbour.worth > better.worth) better = neighbour;
    }
    best = better;
  }
  return best;
}

}  // namespace vantage
