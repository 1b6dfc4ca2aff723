// Describes unrecognised bytes of a tracker: a line of text, another protocol, or noise.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/tracker/params.h"

namespace godobject {

/// Bytes since the last recognised reply or record: their number and their beginning.
class UnreadBytes {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  void clear() noexcept { count_ = 0; }
  bool empty() const noexcept { return count_ == 0; }

  /// Writes number, beginning and probable origin of the bytes, zero-terminated. expected: protocol of the
  /// tracker in the scene. baud: bit/s of the line.
  void describe(TrackerProtocol expected, std::uint32_t baud, std::span<char> out) const noexcept;

 private:
  std::array<std::uint8_t, 128> first_{};
  std::uint64_t count_ = 0;
};

}  // namespace godobject
