#include "vantage/servo/reference_path.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace vantage {
namespace {

// Share of the joints' speeds that the reference asks for: the rest is the image's to correct with.
constexpr double kSpeedShare = 0.7;

}  // namespace

PathReference ReferenceAhead(const ReferencePathOptions& options, const ArmModel& arm,
                             const JointVector& q, const JointVector& q_goal,
                             double gain) noexcept {
  assert(q.size() == arm.size() && q_goal.size() == arm.size());
  PathReference reference;
  reference.step = q_goal - q;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const double way = std::abs(reference.step(i));
    const double reach = std::min(
        options.reach, kSpeedShare * arm.limits()[static_cast<std::size_t>(i)].velocity / gain);
    if (way > reach) reference.share = std::min(reference.share, reach / way);
  }
  if (reference.share == 1.0) return reference;
  reference.step *= reference.share;
  reference.X_WE = EndEffectorPose(arm, q + reference.step);
  return reference;
}

}  // namespace vantage
