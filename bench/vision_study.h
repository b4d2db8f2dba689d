#pragma once

#include <string>
#include <vector>

#include "vision_detectors.h"

/// @file
/// Detectors against the truth: rendered images whose markers' places are known, under what a real camera
/// does to them.

namespace vantage::bench {

/// What is done to the images of one row of the study.
struct Condition {
  std::string name;
  double noise{0.0};   ///< Standard deviation of each pixel [grey levels].
  double blur{0.0};    ///< Of a Gaussian blur [px].
  double motion{0.0};  ///< Way of the markers during the exposure [px].
  bool bar{false};     ///< A bar stands at random before the markers.
  bool border{false};  ///< The markers lie across the image's border.
};

[[nodiscard]] std::vector<Condition> Conditions();

/// What one detector made of it.
struct StudyResult {
  int whole{0};              ///< Discs that are wholly in the image and not hidden.
  int found{0};              ///< Of those: accepted.
  double mean_error{0.0};    ///< Of those found [px].
  double max_error{0.0};     ///< [px].
  int damaged{0};            ///< Discs that lost more than two hundredths of their area.
  int bad_accepted{0};       ///< Of those: accepted; and whole ones accepted more than 0.5 px off.
  double microseconds{0.0};  ///< Of processor time for each image of four markers.
};

/// The same images for each detector: 120 of four markers at 640x480, from cameras all round, predictions
/// up to 6 px off (for those that need a start: exact). Seeded. In the order of kDetectors.
[[nodiscard]] std::vector<StudyResult> RunStudy(const Condition& condition);

}  // namespace vantage::bench
