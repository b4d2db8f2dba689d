#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <random>
#include <string>

#include "vantage/servo/servo_record.h"

namespace vantage::soak {

/// Faults at random in what reaches a servo: what kind, when and how long follows from the seed. Counts the
/// messages that a servo has to refuse.
class Faults {
 public:
  explicit Faults(std::uint64_t seed) : random_(seed) {}

  /// The inputs of one control period.
  void Spoil(PeriodInputs* inputs);

  /// Messages that must have been refused so far.
  [[nodiscard]] std::int64_t to_be_refused() const noexcept { return to_be_refused_; }
  /// Faults so far, by name.
  [[nodiscard]] const std::map<std::string, int>& counts() const noexcept { return counts_; }
  /// A new servo has refused nothing yet, and no fault is under way.
  void Restart();

 private:
  enum class Kind : int {
    kNone = 0,
    kNoJoints,
    kJointsNotFinite,
    kJointMissing,
    kJointsFrozen,
    kJointsFromTheFuture,
    kNoPose,
    kPoseNotFinite,
    kPoseFromTheFuture,
    kNoFeatures,
    kFeaturesNotFinite,
    kFeaturesFromTheFuture,
    kNoMarkers,
    kSomeMarkers,
    kCount
  };

  static const char* Name(Kind kind) noexcept;
  void Choose(Time now);

  std::mt19937_64 random_;
  Kind kind_{Kind::kNone};
  Time next_{}, end_{};
  std::optional<JointState> frozen_;
  std::int64_t to_be_refused_{0};
  std::map<std::string, int> counts_;
};

}  // namespace vantage::soak
