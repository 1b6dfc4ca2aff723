// Integers to and from the little-endian bytes of a message, and numbers to integers without overflow.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <type_traits>

namespace godobject {

/// Result of a parse function. The output is written on `ok` only.
enum class ParseResult : std::uint8_t {
  ok,
  other_message,  // identifier or kind of frame does not match: try another parser
  too_short,
  too_long,
  bad_value,  // a field holds a value that the protocol does not define
};

/// Writes integers consecutively, little-endian.
class ByteWriter {
 public:
  explicit constexpr ByteWriter(std::span<std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  /// Appends a value. If it does not fit, this and all later calls write nothing.
  template <std::integral T>
  constexpr ByteWriter& put(T value) noexcept {
    ok_ = ok_ && bytes_.size() - size_ >= sizeof(T);
    if (!ok_) return *this;
    auto rest = static_cast<std::uint64_t>(static_cast<std::make_unsigned_t<T>>(value));
    for (std::size_t i = 0; i < sizeof(T); ++i, rest >>= 8) {
      bytes_[size_++] = static_cast<std::uint8_t>(rest & 0xFFu);
    }
    return *this;
  }

  /// Appends an IEEE 754 float of 32 bits.
  constexpr ByteWriter& put(float value) noexcept { return put(std::bit_cast<std::uint32_t>(value)); }

  constexpr bool ok() const noexcept { return ok_; }
  constexpr std::size_t size() const noexcept { return size_; }

 private:
  std::span<std::uint8_t> bytes_;
  std::size_t size_ = 0;
  bool ok_ = true;
};

/// Reads integers consecutively, little-endian.
class ByteReader {
 public:
  explicit constexpr ByteReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}

  /// Reads a value. If too few bytes remain, this and all later calls leave `value` unchanged.
  template <std::integral T>
  constexpr ByteReader& get(T& value) noexcept {
    ok_ = ok_ && bytes_.size() - position_ >= sizeof(T);
    if (!ok_) return *this;
    std::uint64_t raw = 0;
    for (std::size_t i = sizeof(T); i-- > 0;) raw = (raw << 8) | bytes_[position_ + i];
    position_ += sizeof(T);
    value = static_cast<T>(static_cast<std::make_unsigned_t<T>>(raw));
    return *this;
  }

  /// Reads an IEEE 754 float of 32 bits, which may be infinite or NaN.
  constexpr ByteReader& get(float& value) noexcept {
    std::uint32_t bits = 0;
    if (get(bits).ok()) value = std::bit_cast<float>(bits);
    return *this;
  }

  /// Returns the next `size` bytes. If too few remain, returns none, and later calls read nothing.
  constexpr std::span<const std::uint8_t> take(std::size_t size) noexcept {
    ok_ = ok_ && bytes_.size() - position_ >= size;
    if (!ok_) return {};
    position_ += size;
    return bytes_.subspan(position_ - size, size);
  }

  constexpr bool ok() const noexcept { return ok_; }
  /// Returns the number of unread bytes.
  constexpr std::size_t left() const noexcept { return bytes_.size() - position_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t position_ = 0;
  bool ok_ = true;
};

/// Rounds x to the nearest integer (halves away from zero) and clamps it to [low, high]. Returns 0 for NaN:
/// on the wire 0 commands no motion. The range must contain 0.
template <std::integral T>
T saturate_to(double x, T low, T high) noexcept {
  if (std::isnan(x)) return 0;
  const double rounded = std::round(x);
  if (rounded <= static_cast<double>(low)) return low;
  if (rounded >= static_cast<double>(high)) return high;
  return static_cast<T>(rounded);
}
template <std::integral T>
T saturate_to(double x) noexcept {
  return saturate_to(x, std::numeric_limits<T>::min(), std::numeric_limits<T>::max());
}

/// Compares the size of a frame with the only size that its message has.
[[nodiscard]] constexpr ParseResult check_size(std::size_t size, std::size_t expected) noexcept {
  if (size < expected) return ParseResult::too_short;
  return size > expected ? ParseResult::too_long : ParseResult::ok;
}

}  // namespace godobject
