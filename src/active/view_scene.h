#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <vector>

#include <Eigen/Geometry>

#include "vantage/active/view_planner.h"

/// @file
/// What a view is worth: all that must be seen and by how much it is measured.

namespace vantage {

/// Markers of the arm, then those of the goal.
using MarkerSet = std::bitset<std::size_t{2} * kMaxPoints>;

/// A measure of J_c at one sample of the motion.
struct SampleValue {
  double log_value{0.0};
  int sign{0};  ///< Of det J_c where it has one, else 0.
};

using SampleValues = std::array<SampleValue, kMaxPathSamples>;

/// Everything a plan is scored against. Keeps references to what it is made of.
class ViewScene {
 public:
  /// @pre motion has 1 to kMaxPathSamples samples.
  ViewScene(const ViewModel& model, const TriggerOptions& trigger, const PlannerOptions& options,
            const std::vector<ArmSample>& motion, const std::vector<PlacedMarker>& goal_markers);

  /// Makes the certificate of the motion's end count before all else.
  void Certify() noexcept { certify_ = true; }
  /// So many of the arm's markers may be missing.
  void Spare(int markers) noexcept { spare_markers_ = markers; }
  /// Leaves the goal's markers out of what must be seen; they stand in the way all the same.
  void NeglectGoal() noexcept { goal_optional_ = true; }
  /// Makes every view answer for one more configuration, right after the first. Keeps a reference.
  void AlsoSee(const ArmSample& soon) noexcept { soon_ = &soon; }

  [[nodiscard]] int size() const noexcept { return static_cast<int>(motion_.size()); }
  [[nodiscard]] const std::vector<ArmSample>& motion() const noexcept { return motion_; }
  /// Logarithm of what a sample is worth that is not seen.
  [[nodiscard]] double lowest() const noexcept { return lowest_; }

  /// The markers that are seen, of those that must be.
  [[nodiscard]] MarkerSet Seen(const ArmSample& sample, const Eigen::Isometry3d& X_WC) const;

  /// True when all markers that must be are seen.
  [[nodiscard]] bool Sees(const ArmSample& sample, const Eigen::Isometry3d& X_WC) const;

  /// Samples up to the first fault that is not occlusion.
  [[nodiscard]] int CountUnobstructed(const Eigen::Isometry3d& X_WC, ViewFault* fault) const;

  /// Of the first `seen` samples, those up to the first at which a marker is hidden.
  [[nodiscard]] int CountNotHidden(const Eigen::Isometry3d& X_WC, int seen) const;

  /// At sample i, between lowest() and the cap.
  [[nodiscard]] SampleValue ValueAt(int i, const Eigen::Isometry3d& X_WC) const;

  /// See ScoreView(). Of a motion of one sample, its value.
  [[nodiscard]] double Score(const SampleValues& values, int seen) const noexcept;

  /// How much worse a view is because it does not certify the motion's end; 0: it does.
  [[nodiscard]] double Uncertified(const Eigen::Isometry3d& X_WC) const;

  /// All of the above of one view.
  [[nodiscard]] ViewScore Evaluate(const Eigen::Isometry3d& X_WC) const;

  /// The middle of all that must be seen: where a head looks.
  [[nodiscard]] Eigen::Vector3d Aim() const;

 private:
  // First fault of the sample's markers, beyond those that may be missing, and of the goal's that is not
  // occlusion.
  [[nodiscard]] ViewFault Unobstructed(const ArmSample& sample,
                                       const Eigen::Isometry3d& X_WC) const;
  // By a link, or by another marker: more of the arm's than may be missing, or one of the goal's.
  [[nodiscard]] bool Hidden(const ArmSample& sample, const Eigen::Isometry3d& X_WC) const;

  const ViewModel& model_;
  const TriggerOptions& trigger_;
  const PlannerOptions& options_;
  const std::vector<ArmSample>& motion_;
  const std::vector<PlacedMarker>& goal_markers_;
  const ArmSample* soon_{nullptr};
  bool certify_{false};
  bool goal_optional_{false};
  int spare_markers_{0};
  double highest_{0.0}, lowest_{0.0};
};

}  // namespace vantage
