// Bytes of a tracker that were not understood, put into words: a line of text, another protocol, or noise.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/tracker/params.h"

namespace godobject {

/// The bytes since the last reply or record that was understood: how many there are, and how they begin.
class UnreadBytes {
 public:
  void add(std::span<const std::uint8_t> bytes) noexcept;
  void clear() noexcept { count_ = 0; }
  bool empty() const noexcept { return count_ == 0; }

  /// Writes how many bytes came, how they begin and whose they may be, and ends with a zero.
  /// expected: the protocol that the scene gives the tracker. baud: bit/s of the line.
  void describe(TrackerProtocol expected, std::uint32_t baud, std::span<char> out) const noexcept;

 private:
  std::array<std::uint8_t, 128> first_{};
  std::uint64_t count_ = 0;
};

}  // namespace godobject
