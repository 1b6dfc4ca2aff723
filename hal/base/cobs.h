// Consistent Overhead Byte Stuffing (Cheshire and Baker 1999): frames without zeros, a zero after each. A receiver that
// comes in the middle, or has lost bytes, is in step again at the next zero.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace godobject {

/// Bytes on the wire of n bytes of payload, the closing zero included.
constexpr std::size_t cobs_size(std::size_t n) noexcept { return n + n / 254 + 2; }

/// Writes the frame of `payload`, the closing zero included. None when `out` is smaller than cobs_size().
[[nodiscard]] std::optional<std::size_t> cobs_encode(std::span<const std::uint8_t> payload,
                                                     std::span<std::uint8_t> out) noexcept;

/// Takes frames out of a stream, byte by byte. Both forms after a full block of 254 bytes are read: with a closing 01
/// and without. Nothing comes between two zeros: empty frames are ignored.
class CobsDecoder {
 public:
  static constexpr std::size_t max_payload = 256;

  enum class Result : std::uint8_t {
    more,       // in the middle of a frame
    frame,      // payload() is complete, until the next byte
    cut_off,    // a zero came where a block was not at its end: the frame is lost
    too_large,  // more than max_payload bytes: the frame is lost
  };

  Result push(std::uint8_t byte) noexcept;
  std::span<const std::uint8_t> payload() const noexcept { return {payload_.data(), size_}; }

 private:
  Result finish() noexcept;
  bool store(std::uint8_t byte) noexcept;

  std::array<std::uint8_t, max_payload> payload_{};
  std::size_t size_ = 0;
  std::uint8_t left_ = 0;      // bytes of the block still to come
  bool zero_pending_ = false;  // the block before stands for a zero, unless the frame ends here
  bool started_ = false;
  bool complete_ = false;
  bool overflow_ = false;
};

}  // namespace godobject
