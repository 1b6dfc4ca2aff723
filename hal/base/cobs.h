// Consistent Overhead Byte Stuffing (Cheshire and Baker 1999): frames without zeros, each followed by a zero.
// A receiver that starts within a frame or loses bytes resynchronises at the next zero.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace godobject {

/// Returns the bytes on the wire for n bytes of payload, including the closing zero.
constexpr std::size_t cobs_size(std::size_t n) noexcept { return n + n / 254 + 2; }

/// Encodes `payload` into `out`, including the closing zero. Returns the size, or nullopt if `out` is smaller
/// than cobs_size().
[[nodiscard]] std::optional<std::size_t> cobs_encode(std::span<const std::uint8_t> payload,
                                                     std::span<std::uint8_t> out) noexcept;

/// Decodes frames from a byte stream. Accepts a full block of 254 bytes with or without a closing 01. Ignores
/// empty frames, that is, consecutive zeros.
class CobsDecoder {
 public:
  static constexpr std::size_t max_payload = 256;

  enum class Result : std::uint8_t {
    more,       // within a frame
    frame,      // payload() is complete and valid until the next byte
    cut_off,    // a zero arrived within a block: the frame is lost
    too_large,  // more than max_payload bytes: the frame is lost
  };

  Result push(std::uint8_t byte) noexcept;
  std::span<const std::uint8_t> payload() const noexcept { return {payload_.data(), size_}; }

 private:
  Result finish() noexcept;
  bool store(std::uint8_t byte) noexcept;

  std::array<std::uint8_t, max_payload> payload_{};
  std::size_t size_ = 0;
  std::uint8_t left_ = 0;      // remaining bytes of the block
  bool zero_pending_ = false;  // the previous block stands for a zero, unless the frame ends here
  bool started_ = false;
  bool complete_ = false;
  bool overflow_ = false;
};

}  // namespace godobject
