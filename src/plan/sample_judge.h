#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "vantage/observability/batch.h"
#include "vantage/plan/placement_model.h"

/// @file
/// What cameras are worth at single samples of a motion.

namespace vantage::plan {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Keeps its storage from call to call, and a reference to the model. What is returned by reference holds until
/// the next call.
class SampleJudge {
 public:
  explicit SampleJudge(const PlacementModel& model) : model_(model) {}

  struct Worth {
    double value;      ///< Weight times measure; 0 where a limit is broken.
    double violation;  ///< 0: all limits are kept.
  };
  /// At one sample, of many cameras. Writes where they stand.
  const std::vector<Worth>& At(int sample, const std::vector<Eigen::Isometry3d>& X_WC,
                               std::vector<Eigen::Vector3d>* places);

  /// Of one camera.
  Worth Of(int sample, const RigVector& q_c);

  /// How far each camera has to step back along its optical axis to keep field of view and least depth at one
  /// sample [m], >= 0. FromBehind() is about the same cameras.
  const std::vector<double>& BackAt(int sample, const std::vector<Eigen::Isometry3d>& X_WC);

  /// Worth of cameras that stand by[i] [m] further back along the optical axis than camera source[i] of those
  /// that BackAt() was asked about. Writes where they stand.
  const std::vector<Worth>& FromBehind(int sample, const std::vector<Eigen::Isometry3d>& X_WC,
                                       const std::vector<int>& source,
                                       const std::vector<double>& by,
                                       std::vector<Eigen::Vector3d>* places);

  /// A broken limit outweighs anything that was seen so far.
  [[nodiscard]] double Penalty() const noexcept {
    return 1e3 * model_.problem().motion.size() * (largest_ > 0.0 ? largest_ : 1.0);
  }
  [[nodiscard]] std::int64_t evaluations() const noexcept { return evaluations_; }

 private:
  void Load(const std::vector<Eigen::Isometry3d>& X_WC);
  // Sets the margins near, far and image.
  void Frustum(int sample, std::size_t count);
  const std::vector<Worth>& Judge(int sample, const std::vector<Eigen::Vector3d>& places);

  const PlacementModel& model_;
  BatchEvaluator evaluator_;
  BatchCameras cameras_, asked_;
  BatchScores scores_;
  BatchMargins margins_, own_;
  std::vector<double> back_;
  std::vector<Worth> worth_;
  double largest_{0.0};
  std::int64_t evaluations_{0};
};

/// Value, or what a broken limit costs.
[[nodiscard]] inline double Reward(const SampleJudge::Worth& worth, double penalty) noexcept {
  return worth.violation > 0.0 ? -penalty * (1.0 + worth.violation) : worth.value;
}

}  // namespace vantage::plan
