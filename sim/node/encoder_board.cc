#include "sim/node/encoder_board.h"

#include <algorithm>

namespace godobject {

std::span<const std::uint8_t> SimEncoderBoard::transmit(std::span<std::uint8_t> out,
                                                        Nanoseconds now) noexcept {
  if (!started_) {
    started_ = true;
    clock_ns_ = next_ns_ = 0;
    frame_.sequence = 0;
    last_ = now;
  }
  clock_ns_ += static_cast<double>(now - last_) * (1 + 1e-6 * faults.clock_drift);
  last_ = now;
  if (clock_ns_ < next_ns_) return {};
  frame_.t_us = static_cast<std::uint32_t>(static_cast<std::uint64_t>(next_ns_ / 1000));
  next_ns_ += period_;
  const std::span<const std::uint8_t> bytes = make_encoder_frame(frame_, out);
  ++frame_.sequence;
  if (faults.silent || random_.chance(faults.drop_probability)) return {};
  if (random_.chance(faults.corrupt_probability)) {
    std::uint8_t& byte = out[random_.next() % bytes.size()];
    byte = static_cast<std::uint8_t>(byte ^ (1u << (random_.next() % 8)));
  }
  return bytes;
}

}  // namespace godobject
