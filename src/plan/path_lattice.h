#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "sample_judge.h"
#include "search_space.h"
#include "vantage/plan/placement_model.h"

namespace vantage::plan {

/// Directions of a coarse lattice of camera paths and where they stand at each of its stages. Keeps references to
/// what it is made of.
class PathLattice {
 public:
  /// @param q_c_fixed  One of the states.
  /// @param states     How many, >= 2.
  PathLattice(const PlacementModel& model, const SearchSpace& space, const RigVector& q_c_fixed,
              int states, SampleJudge* judge);

  /// The best path, as far as the speeds between the stages tell; empty where they allow none.
  [[nodiscard]] std::vector<RigVector> BestPath();

 private:
  static constexpr double kReserve = 0.95;  // of the speeds

  [[nodiscard]] int layers() const { return static_cast<int>(spare_.size()); }
  [[nodiscard]] double StageTime() const {
    return model_.problem().motion.time.back() / (stages_ - 1);
  }
  [[nodiscard]] int SampleOf(int stage) const;
  // As many stages as leave a state enough others to go to.
  void Connect();
  // Where one axis is the distance, each direction from as near as can be and from further back: what comes near
  // fast has to begin in time.
  void Layer();
  // In between as near as can be, and as the speeds allow.
  [[nodiscard]] std::vector<RigVector> PathThrough(
      const std::vector<int>& sequence, const std::vector<std::vector<double>>& distance) const;

  const PlacementModel& model_;
  const SearchSpace& space_;
  SampleJudge* judge_;
  std::vector<RigVector> states_;
  std::vector<Eigen::Isometry3d> X_WC_;
  // Of the layers of a state: how much further back than need be [m].
  std::vector<double> spare_{0.0};
  int stages_{2};
  std::vector<std::vector<int>> predecessor_;
};

}  // namespace vantage::plan
