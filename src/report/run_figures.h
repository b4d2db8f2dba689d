#pragma once

#include <string>
#include <vector>

#include "run_events.h"
#include "run_log.h"

namespace vantage {

/// A picture that was drawn.
struct DrawnFigure {
  std::string name;     ///< Of the files: name.png, name.svg, name.gp.
  std::string title;    ///< For a heading.
  std::string caption;  ///< What to see in it.
};

/// Draws what the log holds data for: image error, measures, image paths of the features, joints, camera path,
/// timing. Files go to `folder`.
/// Throws Error as RunGnuplot() does.
[[nodiscard]] std::vector<DrawnFigure> DrawFigures(const RunLog& log, const std::string& folder);

}  // namespace vantage
