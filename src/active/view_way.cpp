#include "view_way.h"

#include <algorithm>
#include <cmath>

#include "view_candidates.h"

namespace vantage {
namespace {

// Points of a way at which the markers are looked for: one every so many metres or radians.
constexpr double kStationSpacing = 0.12;
constexpr int kLeastStations = 6;
constexpr int kMostStations = 48;

// How often a marker that was seen is not seen any more at the stations of a way, given where the arm is
// by then.
int CountLosses(const ViewScene& scene, const CameraRig& rig, const RigMotion& motion,
                double progress_rate, MarkerSet seen, int seen_at_end) {
  const RigPath& path = motion.path();
  const double length = path.Length();
  const int stations =
      std::clamp(static_cast<int>(length / kStationSpacing), kLeastStations, kMostStations);
  int losses = 0;
  for (int i = 1; i <= stations; ++i) {
    const double s = static_cast<double>(i) / stations;
    const double progress = 1.0 - std::exp(-progress_rate * motion.TimeAt(s));
    const int last = std::max(0, std::min(scene.size(), seen_at_end) - 1);
    const int sample = std::min(last, static_cast<int>(std::lround(progress * (scene.size() - 1))));
    const MarkerSet now = scene.Seen(scene.motion()[sample], RigPose(rig, path.At(s)));
    losses += static_cast<int>((seen & ~now).count());
    seen = now;
  }
  return losses;
}

}  // namespace

ViewWay FindWay(const ViewScene& scene, const CameraRig& rig, const PlanRequest& request,
                const Eigen::Vector3d& aim_W, const ViewCandidate& to, MarkerSet seen_at_start) {
  ViewWay best;
  for (const RigPath& path : PathsBetween(rig, request.q_c, to.q_c, aim_W)) {
    const RigMotion motion(rig, path);
    const bool slower = best.found && motion.duration() >= best.duration;
    if (slower && best.losses == 0) continue;
    const int losses =
        CountLosses(scene, rig, motion, request.progress_rate, seen_at_start, to.view.seen);
    if (losses > 0 && !request.may_lose) continue;
    if (best.found && (losses > best.losses || (losses == best.losses && slower))) continue;
    best = {path, motion.duration(), losses, true};
  }
  return best;
}

}  // namespace vantage
