#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "sample_judge.h"
#include "search_space.h"
#include "vantage/plan/placement_model.h"

namespace vantage::plan {

/// The neighbours of a camera path and the best way through them. Nodes lie `spacing` samples apart; what moves a
/// node moves the samples about it in proportion. Keeps references to what it is made of, and its storage from
/// round to round.
class PathTube {
 public:
  PathTube(const PlacementModel& model, const SearchSpace& space, double penalty,
           SampleJudge* judge)
      : model_(model), space_(space), penalty_(penalty), judge_(judge) {}

  /// Samples of a path that are refined.
  struct Window {
    int first, count;
    bool hold_first;
  };
  struct Round {
    Window window;
    /// Of a node, in steps of each free axis: -1, 0 or 1. The first is none.
    std::vector<std::vector<int>> moves;
    int spacing{1};    ///< Samples between nodes.
    int offset{1};     ///< Of the second node.
    double step{0.1};  ///< As a share of what the speeds allow from node to node.
    int stride{1};     ///< Samples between those that are looked at.
    /// What twice the camera's speed costs at a sample; inf: none above it is allowed.
    double haste{kInfinity};
  };
  /// The best way through the neighbours of the path becomes the path. Returns what the window's samples are
  /// then worth, those that are not looked at as their neighbours; nothing where there is no way.
  std::optional<double> Refine(const Round& round, std::vector<RigVector>* path);

 private:
  // Neighbours of one sample.
  struct Slice {
    std::vector<std::vector<double>> value;  // of each rig axis, those that occur
    std::vector<double> distance;            // of each neighbour, where one axis is the distance
    std::vector<Eigen::Vector3d> place;
    std::vector<double> reward;
  };
  // What the neighbours of a sample are. At a node: its moves. Between nodes: each move of the one before with
  // each move of the one after. A move of an axis is a code: 3 (move before + 1) + (move after + 1).
  struct Neighbours {
    std::vector<std::array<int, kMaxRigAxes>> code;  // of each, by rig axis
    // Of each: where one axis is the distance, those with equal other axes share one.
    std::vector<int> direction;
    std::vector<int> pick;  // of each direction: codes by rig axis, one after the other
  };
  static constexpr int kStays = 4;  // code of an axis that does not move
  static constexpr int kCodes = 9;

  [[nodiscard]] static std::vector<int> NodesOf(const Round& round);
  // Sets the neighbours and the steps.
  void Prepare(const Round& round, const std::vector<RigVector>& path);
  // Two moves, in steps of each free axis.
  [[nodiscard]] bool SameDirection(const std::vector<int>& a, const std::vector<int>& b) const;
  // One more neighbour; `direction`: its index among those of all, -1: it is the first to have it.
  void Add(const std::array<int, kMaxRigAxes>& code, int* direction, Neighbours* all) const;
  // One step of an axis: a share of what its speed and that of the camera allow from node to node.
  void SetSteps(const Round& round, const std::vector<RigVector>& path);
  [[nodiscard]] bool Follows(int sample, const RigVector& from, const RigVector& to) const;
  // Rig coordinates of a neighbour.
  [[nodiscard]] RigVector StateOf(const Window& window, int i, const Neighbours& all, int entry,
                                  const std::vector<RigVector>& path) const;
  // Where sample i lies in time between two nodes.
  [[nodiscard]] double ShareOf(const Window& window, int begin, int i, int end) const;
  // Rig coordinates of a neighbour that was not looked at.
  [[nodiscard]] RigVector LeftOut(int sample, double lambda,
                                  const std::array<int, kMaxRigAxes>& code, const RigVector& own);
  // Judges the neighbours of a sample that lies at `lambda` between two nodes, or is one.
  void Look(const Window& window, int i, double lambda, const Neighbours& all,
            const RigVector& own);
  // From one sample to another, for each pair of the moves of the nodes about them: adds what the
  // latter is worth to the sums, -inf where the speeds do not allow it.
  void Pass(const Window& window, int before, int i, bool from_node, bool to_node, double weight,
            const std::vector<RigVector>& path, std::vector<double>* sum);
  // Follows the best way back from its last move: the samples of the window move along it.
  void Take(const Round& round, const std::vector<int>& nodes,
            const std::vector<std::vector<int>>& from, int last, std::vector<RigVector>* path);

  const PlacementModel& model_;
  const SearchSpace& space_;
  double penalty_;
  double haste_{kInfinity};
  SampleJudge* judge_;
  Neighbours at_node_, between_;
  std::vector<double> step_;  // of each rig axis
  std::vector<Eigen::Isometry3d> X_WC_;
  std::vector<double> by_;
  std::vector<Slice> slices_;
};

}  // namespace vantage::plan
