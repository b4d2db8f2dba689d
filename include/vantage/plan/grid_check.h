#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "vantage/plan/placement.h"

/// @file
/// The best of a dense grid that knows nothing of a search: the certificate of its result (docs/placement.md). The
/// grid is cut into blocks, which may be searched anywhere and in any order: what comes of them is the same.

namespace vantage {

/// A camera of the grid: enough to find it again.
struct GridCamera {
  std::int64_t index{0};  ///< In the grid, from 0.
  std::uint64_t cell{0};  ///< Number of the part of the rig's workspace that it stands in.
  double score{0.0};      ///< Of the scene: PlacementModel::Value() says what it is worth.
};

/// The best camera of each cell, of the best cells. A greater score is better; of equal ones the lower index. The
/// outcome depends neither on the order of what is offered nor on how often, so the best of several parts of a
/// grid, offered to another, make up the best of the whole.
class GridBest {
 public:
  /// Cells that are kept: the two dozen cameras that are polished, which must be apart, are among them.
  static constexpr std::size_t kMost = 128;

  /// Whether the camera would be kept.
  [[nodiscard]] bool Wants(const GridCamera& camera) const;
  /// Keeps the camera if it is wanted, in the place of a worse one; true if so.
  bool Offer(const GridCamera& camera);
  /// Best first.
  [[nodiscard]] const std::vector<GridCamera>& cameras() const noexcept { return cameras_; }
  /// What the best of all is worth; nothing: there is none.
  [[nodiscard]] std::optional<double> ValueOfBest(const PlacementModel& model) const;

 private:
  std::vector<GridCamera> cameras_;
};

/// A grid and the best cameras of it that keep all limits.
struct SearchedGrid {
  std::int64_t cameras{0};  ///< Of the grid, those that break a limit included.
  GridBest best;            ///< Of those that keep all limits.
};

/// Searches a grid, block by block. Keeps its storage; one thread at a time.
class GridSearch {
 public:
  /// @param model    Must outlive it.
  /// @param cameras  Of the whole grid; >= 0.
  GridSearch(const PlacementModel& model, std::int64_t cameras);
  ~GridSearch();
  GridSearch(const GridSearch&) = delete;
  GridSearch& operator=(const GridSearch&) = delete;

  /// Blocks of a grid of so many cameras. Depends on nothing else.
  [[nodiscard]] static int BlocksOf(std::int64_t cameras) noexcept;

  /// Searches one block. What all calls together return holds the best of the blocks searched; cameras that those
  /// of earlier calls keep out of it are left out. @pre 0 <= block < BlocksOf(cameras).
  [[nodiscard]] std::vector<GridCamera> Search(int block);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A search's result beside the best of a grid.
struct GridCheck {
  std::int64_t cameras{0};   ///< Cameras of the grid.
  double best_on_grid{0.0};  ///< Value; -inf: none is feasible.
  PlacedCamera best;         ///< After polishing.
  /// How much less the result is worth than `best`, relative; negative: it is worth more.
  double gap{0.0};
};

/// Polishes the best cameras of a grid that are apart, and compares the result with the best of them.
[[nodiscard]] GridCheck FinishGridCheck(const PlacementModel& model, const PlacedCamera& result,
                                        const SearchedGrid& grid,
                                        const PlanProgress& progress = {});

/// Searches a grid of `cameras` here, all of its blocks, and compares the result with it.
[[nodiscard]] GridCheck CheckAgainstGrid(const PlacementModel& model, const PlacedCamera& result,
                                         std::int64_t cameras);

}  // namespace vantage
