#pragma once

#include <memory>
#include <optional>

#include "search_space.h"
#include "vantage/plan/placement_model.h"

namespace vantage::plan {

/// Relative changes that end one program of a polish.
struct Tolerance {
  double x;      ///< Of the place.
  double merit;  ///< Of what is made great.
};

/// The local optimum near a camera by sequential quadratic programming over the limits that are near, in rounds.
/// Never worse than the camera where that keeps all limits.
///
/// @see D. Kraft, "A software package for sequential quadratic programming", DFVLR-FB 88-28, 1988
///   (NLopt's SLSQP).
class Polisher {
 public:
  /// Model, space and scorer, which counts the evaluations, must outlive it.
  Polisher(const PlacementModel& model, const SearchSpace& space, const RigVector& q_c,
           CameraScorer* scorer);
  ~Polisher();
  Polisher(Polisher&&) noexcept;
  Polisher& operator=(Polisher&&) noexcept;

  /// Up the hill, near enough to tell which of many hills may be the highest.
  void Coarse();
  /// Near enough to tell which of a few is.
  void Rough();
  /// To rounding.
  void Finish();

  /// The best so far.
  [[nodiscard]] RigVector q_c() const;
  [[nodiscard]] bool keeps() const noexcept;
  [[nodiscard]] double merit() const noexcept;
  [[nodiscard]] double violation() const noexcept;

 private:
  struct Step {
    double moved{0.0};           // SearchSpace::Distance
    bool kept{false};            // all limits where the program ended
    std::optional<double> gain;  // in merit, where one allowed camera took another's place
  };
  Step Round(const Tolerance& tolerance);
  void Settle(const Tolerance& tolerance);

  struct State;
  std::unique_ptr<State> state_;
};

/// The local optimum near q_c to rounding.
[[nodiscard]] RigVector Polish(const PlacementModel& model, const SearchSpace& space,
                               const RigVector& q_c, CameraScorer* scorer);

}  // namespace vantage::plan
