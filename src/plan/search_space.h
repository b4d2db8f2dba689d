#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "vantage/camera/camera_rig.h"

namespace vantage::plan {

/// Coordinates of a search: every rig axis that has room, as a share of it in [0, 1].
using SearchVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxRigAxes, 1>;

/// The free axes of a rig.
class SearchSpace {
 public:
  /// @param q_c_start  Values of the axes without room.
  SearchSpace(const CameraRig& rig, const RigVector& q_c_start);

  [[nodiscard]] int size() const noexcept { return static_cast<int>(axes_.size()); }
  [[nodiscard]] int axis(int i) const noexcept { return axes_[i]; }
  [[nodiscard]] double range(int i) const noexcept { return range_[i]; }
  /// Turns all the way round.
  [[nodiscard]] bool round(int i) const noexcept { return round_[i]; }
  [[nodiscard]] const CameraRig& rig() const noexcept { return rig_; }

  /// Rig coordinates at u; what is outside of [0, 1] is wrapped on axes that turn all the way round, and
  /// moved to the nearest bound on the others.
  [[nodiscard]] RigVector ToRig(const SearchVector& u) const noexcept;
  /// The same without wrapping and bounds.
  [[nodiscard]] RigVector ToRigFreely(const SearchVector& u) const noexcept;
  [[nodiscard]] SearchVector FromRig(const RigVector& q_c) const noexcept;
  /// How far u is outside of its bounds.
  [[nodiscard]] double Excess(const SearchVector& u) const noexcept;
  /// Largest difference along an axis, the short way round.
  [[nodiscard]] double Distance(const SearchVector& a, const SearchVector& b) const noexcept;

  /// Point i of a sequence that fills the unit box evenly: the additive recurrence of the generalised
  /// golden ratio (M. Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018).
  [[nodiscard]] SearchVector Spread(std::int64_t i) const noexcept;

  /// A camera that stands `back` [m] farther from what it sees, along its optical axis, as far as the
  /// limits allow; q_c itself where the rig has no such motion.
  [[nodiscard]] RigVector StepBack(const RigVector& q_c, double back) const noexcept;
  [[nodiscard]] bool can_step_back() const noexcept { return step_ != Step::kNone; }
  /// A step back is a change of one axis, exactly; -1: it is not.
  [[nodiscard]] int step_axis() const noexcept { return step_ == Step::kRadius ? 0 : -1; }

 private:
  enum class Step { kNone, kRadius, kPose };

  CameraRig rig_;
  CameraRig unlocked_;  // the same, no axis without speed
  RigVector q_c_fixed_;
  std::vector<int> axes_;
  std::vector<double> range_;
  std::vector<bool> round_;
  std::vector<double> ratio_;
  Step step_{Step::kNone};
};

}  // namespace vantage::plan
