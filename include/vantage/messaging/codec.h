#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "vantage/camera/camera_pose.h"
#include "vantage/features/marker.h"
#include "vantage/messaging/camera_image.h"
#include "vantage/messaging/refusal.h"
#include "vantage/robot/joint_state.h"
#include "vantage/servo/ground_truth.h"
#include "vantage/servo/servo_record.h"
#include "vantage/servo/servo_report.h"

/// @file
/// Between this program's values and the bytes of LCM messages (lcm_types/). Nothing that comes from
/// outside is trusted: Decode() checks size, type, counts, numbers and times, in the order of Refusal,
/// and names what is wrong. It allocates no more than a small multiple of the message's size, and no
/// message larger than its type's cap is looked at.

namespace vantage {

/// An encoded message.
using Bytes = std::vector<std::uint8_t>;

/// Most bytes a message may have: of types that hold numbers only, of records, and of images.
inline constexpr std::size_t kMaxStateBytes = 16'384;
inline constexpr std::size_t kMaxRecordBytes = std::size_t{1} << 20;  ///< Of the servo's record.
/// Largest image message that is looked at [bytes].
inline constexpr std::size_t kMaxImageBytes = std::size_t{16} << 20;

/// Largest magnitude taken for a position, a velocity or a pixel coordinate [rad, m, px, per s].
inline constexpr double kMaxMagnitude = 1e6;

/// The bytes in a value. *out is untouched unless kNone is returned.
///
/// Quaternions may be off unit length by 1e-3 and are normalised; markers that are not valid come out
/// with pixel (0, 0). The names in words are not read: the numbers say the same.
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, JointState* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, JointCommand* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, CameraPose* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, ImageFeatures* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, ObservabilityReport* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, ServoStatus* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, GroundTruth* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, CameraImage* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, ServoRecord* out) noexcept;
[[nodiscard]] Refusal Decode(const void* data, std::size_t size, ServoSetup* out) noexcept;

/// The value as a message; *out keeps its capacity. What is encoded is what was given: checking is the
/// receiver's. Times are cut to whole microseconds.
void Encode(const JointState& value, Bytes* out);
void Encode(const JointCommand& value, Bytes* out);
void Encode(const CameraPose& value, Bytes* out);
void Encode(const ImageFeatures& value, Bytes* out);
/// @pre value.axes has value.k rows, or no columns.
void Encode(const ObservabilityReport& value, Bytes* out);
void Encode(const ServoStatus& value, Bytes* out);
void Encode(const GroundTruth& value, Bytes* out);
void Encode(const CameraImage& value, Bytes* out);
/// Exact: times to the nanosecond, poses as matrices.
void Encode(const ServoRecord& value, Bytes* out);
void Encode(const ServoSetup& value, Bytes* out);

}  // namespace vantage
