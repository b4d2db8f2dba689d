#pragma once

#include <cstddef>
#include <cstdint>

namespace vantage {

/// Bytes of the fingerprint that every message begins with.
inline constexpr std::size_t kFingerprintSize = 8;

/// Big-endian two's complement of `bytes` bytes, 1 to 8.
[[nodiscard]] inline std::int64_t ReadInteger(const std::uint8_t* data,
                                              std::size_t bytes) noexcept {
  std::uint64_t value = (data[0] & 0x80U) != 0 ? ~std::uint64_t{0} : 0;
  for (std::size_t i = 0; i < bytes; ++i) value = value << 8 | data[i];
  return static_cast<std::int64_t>(value);
}

}  // namespace vantage
