#pragma once

#include <array>
#include <string>
#include <vector>

#include "measure_setup.h"

namespace vantage {

/// One swept parameter.
struct SweepAxis {
  enum class Kind {
    kRig,    ///< One coordinate of the camera's rig.
    kJoint,  ///< One joint, or several that turn by the same angle.
    kPath,   ///< Where along the recipe's path of joints: 0 to 1.
  };
  Kind kind{Kind::kRig};
  std::string name;          ///< "R", "theta", "elbow", "path": as in the table.
  std::string symbol;        ///< As printed in pictures, gnuplot's enhanced text.
  std::string unit;          ///< "rad", "m" or the recipe's unit of length; empty: none.
  std::vector<int> indices;  ///< Of the rig's axis or of the joints.
  double from{0.0};          ///< [m] or [rad].
  double to{0.0};
  int samples{2};  ///< Both ends included.
};

/// Value of sample i of an axis: the ends are exact.
[[nodiscard]] double ValueAt(const SweepAxis& axis, int i) noexcept;

/// What pictures write for an axis of the rig or a joint: "θ" for theta, "φ" for phi, else its name.
[[nodiscard]] std::string SymbolOf(const std::string& name);

/// Quantities that a picture may show.
enum class MapQuantity { kViewW, kArmW, kCompositeW, kSigmaMin, kGeometricMean, kPaperProduct };

/// Name of a quantity in files: "w_v", "w_r", "w_c", "sigma_min_c", ...
[[nodiscard]] const char* Name(MapQuantity quantity) noexcept;

/// What vantage-map sweeps and how it shows the result.
struct MapRecipe {
  MeasureSetup setup;
  std::string title;
  std::string notes;              ///< What the paper leaves open, for instance. May be empty.
  std::string length_unit;        ///< "m", or what the recipe calls its lengths.
  std::array<SweepAxis, 2> axes;  ///< x and y.
  MapQuantity picture{MapQuantity::kCompositeW};  ///< What pictures show.
  bool logarithmic{false};                        ///< Heat maps and surfaces of log10.
  double view_turn{30.0};                         ///< Of the surface about its z axis [deg].
};

/// A recipe file, or a built-in one by its name. Throws ConfigError with file, line and key.
/// @param recorder  Told of each key that is read (for the reference); may be null.
[[nodiscard]] MapRecipe FindMapRecipe(const std::string& name_or_path,
                                      SchemaRecorder* recorder = nullptr);

}  // namespace vantage
