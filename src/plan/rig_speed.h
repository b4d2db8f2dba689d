#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "sample_judge.h"
#include "search_space.h"
#include "vantage/camera/camera_rig.h"
#include "vantage/plan/placement_model.h"

/// @file
/// What the speeds of a rig allow between samples of a camera path.

namespace vantage::plan {

/// How far a rig gets in a time.
class Reach {
 public:
  /// @param dt  [s].
  Reach(const CameraRig& rig, double dt) : size_(rig.size()) {
    // What rounding takes is no excess.
    constexpr double kSpeedSlack = 1e-9;
    const double allowed = dt * (1.0 + kSpeedSlack) + 1e-12;
    for (int i = 0; i < size_; ++i) axis_[i] = rig.axes[i].max_speed * allowed;
    centre2_ = std::pow(rig.max_linear_speed * allowed, 2);
  }
  /// [m or rad].
  [[nodiscard]] double axis(int i) const noexcept { return axis_[i]; }
  /// Of the camera's centre, squared [m²].
  [[nodiscard]] double centre2() const noexcept { return centre2_; }
  [[nodiscard]] bool Covers(const RigVector& from, const Eigen::Vector3d& p_from,
                            const RigVector& to, const Eigen::Vector3d& p_to) const noexcept {
    if ((p_to - p_from).squaredNorm() > centre2_) return false;
    for (int i = 0; i < size_; ++i) {
      if (std::abs(to(i) - from(i)) > axis_[i]) return false;
    }
    return true;
  }

 private:
  int size_;
  std::array<double, kMaxRigAxes> axis_{};
  double centre2_{0.0};
};

/// True when the rig gets from one to the other in dt [s].
[[nodiscard]] bool MayFollow(const CameraRig& rig, const RigVector& from, const RigVector& to,
                             double dt);

/// Makes a path as near as the frustum lets each sample be and the speeds allow, other axes as they are: no
/// distance is less than those of its neighbours allow. Nothing where no axis is the distance.
void PullNear(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
              std::vector<RigVector>* path);

/// Makes a path as limits and speeds allow, as near as can be: where it runs ahead, what follows lags behind.
void Obey(const PlacementModel& model, const SearchSpace& space, SampleJudge* judge,
          std::vector<RigVector>* path);

}  // namespace vantage::plan
