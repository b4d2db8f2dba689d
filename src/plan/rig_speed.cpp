#include "rig_speed.h"

#include <algorithm>

namespace vantage::plan {

using Eigen::Isometry3d;
using Eigen::Vector3d;

namespace {

// The path as the speeds allow: where it runs ahead, what follows lags behind.
void Lag(const CameraRig& rig, const ArmMotion& motion, std::vector<RigVector>* path) {
  for (int i = 1; i < motion.size(); ++i) {
    const RigVector from = (*path)[i - 1], wanted = (*path)[i];
    const double dt = motion.time[i] - motion.time[i - 1];
    if (MayFollow(rig, from, wanted, dt)) continue;
    double share = 0.0;
    for (double step = 0.5; step > 1e-4; step *= 0.5) {
      const RigVector to = from + (share + step) * (wanted - from);
      if (MayFollow(rig, from, to, dt)) share += step;
    }
    (*path)[i] = from + share * (wanted - from);
  }
}

}  // namespace

bool MayFollow(const CameraRig& rig, const RigVector& from, const RigVector& to, double dt) {
  return Reach(rig, dt).Covers(from, RigPose(rig, from).translation(), to,
                               RigPose(rig, to).translation());
}

void PullNear(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
              std::vector<RigVector>* path) {
  constexpr double kReserve = 0.99;  // of the speeds
  const int axis = space.step_axis();
  if (axis < 0) return;
  const CameraRig& rig = space.rig();
  const ArmMotion& motion = model.problem().motion;
  const int N = motion.size();
  const double lower = rig.axes[axis].lower, upper = rig.axes[axis].upper;
  std::vector<Isometry3d> X_WC;
  for (int i = 0; i < N; ++i) {
    RigVector q = (*path)[i];
    q(axis) = lower;
    X_WC.push_back(RigPose(rig, q));
    (*path)[i](axis) = std::min(upper, lower + judge->BackAt(i, {X_WC[i]})[0]);
  }
  const auto follow = [&](int from, int to) {
    const double dt = std::abs(motion.time[to] - motion.time[from]);
    const double far = kReserve * rig.max_linear_speed * dt;
    const Vector3d back = -X_WC[to].linear().col(2);
    const Vector3d way = X_WC[from].translation() -
                         ((*path)[from](axis) - lower) * X_WC[from].linear().col(2) -
                         X_WC[to].translation();
    const double along = way.dot(back);
    const double across2 = way.squaredNorm() - along * along;
    const double least = lower + along - std::sqrt(std::max(0.0, far * far - across2));
    const double by_axis = (*path)[from](axis) - kReserve * rig.axes[axis].max_speed * dt;
    (*path)[to](axis) = std::min(upper, std::max({(*path)[to](axis), least, by_axis}));
  };
  for (int i = 1; i < N; ++i) follow(i - 1, i);
  for (int i = N - 1; i > 0; --i) follow(i, i - 1);
}

void Obey(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
          std::vector<RigVector>* path) {
  // What lags stands elsewhere, where it may have to be farther away.
  for (int round = 0; round < 2; ++round) {
    PullNear(model, space, judge, path);
    Lag(space.rig(), model.problem().motion, path);
  }
}

}  // namespace vantage::plan
