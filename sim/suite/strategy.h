#pragma once

#include <string>
#include <vector>

#include "vantage/config/scenario.h"

namespace vantage::sim {

/// Ways to deal with a view, compared side by side.
enum class Strategy : int {
  kFixed = 0,  ///< The camera stays; Vantage's law.
  kClassic,    ///< The camera stays; textbook IBVS: constant gain, pseudo-inverse, speeds cut off.
  kPlanned,    ///< The camera is placed beforehand by eq. 14 (greatest integral of w_c), and stays.
  kMinimax,    ///< The same by eq. 16 (greatest least w_c).
  kActive,     ///< The default: trigger, plan, move while the arm goes on.
  kGradient,   ///< The camera always climbs the gradient of w_c.
  kStopAndGo,  ///< As active, but the arm waits while the camera moves.
};

[[nodiscard]] const std::vector<Strategy>& AllStrategies();
[[nodiscard]] const char* Name(Strategy strategy) noexcept;  ///< "fixed", "stop-and-go", ...
/// Throws ConfigError (key "strategy").
[[nodiscard]] Strategy StrategyOf(const std::string& name);

/// The scenario as the strategy plays it. Placement uses what the controller knows alone: the nominal
/// models and the goal's prior.
[[nodiscard]] Scenario WithStrategy(Scenario scenario, Strategy strategy);

/// An ingredient of the active camera or of the law, to be switched off.
struct Ablation {
  const char* name;
  const char* what;
  void (*apply)(Scenario* scenario);
};
[[nodiscard]] const std::vector<Ablation>& AllAblations();
/// Throws ConfigError (key "without").
[[nodiscard]] const Ablation& AblationOf(const std::string& name);

}  // namespace vantage::sim
