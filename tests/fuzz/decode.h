// Shared parts of the fuzz targets: an input of bytes, frames made of it, and a guard that ends the program
// when a decoder allocates.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/can/frame.h"

namespace godobject::fuzz {

/// Guard: while one exists, an allocation in this thread is an error like those of the sanitizers.
class NoAllocation {
 public:
  NoAllocation() noexcept;
  ~NoAllocation();
  NoAllocation(const NoAllocation&) = delete;
  NoAllocation& operator=(const NoAllocation&) = delete;
};

/// The input, consumed from its front; zeros once it is used up.
class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : rest_(data, size) {}

  bool empty() const { return rest_.empty(); }
  std::uint8_t byte() {
    if (rest_.empty()) return 0;
    const std::uint8_t value = rest_.front();
    rest_ = rest_.subspan(1);
    return value;
  }
  std::uint32_t word() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | byte();
    return value;
  }
  /// Returns the next bytes, at most `size`, fewer at the end.
  std::span<const std::uint8_t> bytes(std::size_t size) {
    const std::span<const std::uint8_t> taken = rest_.first(std::min(size, rest_.size()));
    rest_ = rest_.subspan(taken.size());
    return taken;
  }

 private:
  std::span<const std::uint8_t> rest_;
};

/// Returns a frame as delivered by a bus: flags and sizes in range, everything else random.
inline CanFrame frame_of(Input& in) {
  const std::uint8_t kind = in.byte();
  CanFrame frame{.id = (static_cast<std::uint32_t>(in.byte()) << 8 | in.byte()) & 0x7FFu};
  frame.extended = (kind & 1) != 0;
  if (frame.extended) frame.id |= in.word() & 0x1FFF'F800u;
  frame.fd = (kind & 2) != 0;
  frame.remote = !frame.fd && (kind & 4) != 0;
  frame.bit_rate_switch = frame.fd && (kind & 8) != 0;
  frame.size = static_cast<std::uint8_t>(in.byte() % (frame.fd ? 65 : 9));
  if (!is_valid(frame)) frame.size = 8;
  std::ranges::copy(in.bytes(frame.size), frame.data.begin());
  return frame;
}

}  // namespace godobject::fuzz
