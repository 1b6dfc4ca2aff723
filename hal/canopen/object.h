// Objects in the dictionary of a CANopen device: address, type, and encoding in SDO and PDO (CiA 301 7.4).
#pragma once

#include <array>
#include <compare>
#include <limits>

#include "hal/base/codec.h"

namespace godobject::canopen {

struct ObjectAddress {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;

  friend constexpr auto operator<=>(const ObjectAddress&, const ObjectAddress&) = default;
};

enum class ObjectType : std::uint8_t { u8, u16, u32, i8, i16, i32, text };

/// Names of ObjectType in profiles and on the command line, in the order of the enumeration.
inline constexpr std::array object_type_names{"u8", "u16", "u32", "i8", "i16", "i32", "string"};

constexpr bool is_signed(ObjectType type) noexcept {
  return type == ObjectType::i8 || type == ObjectType::i16 || type == ObjectType::i32;
}

/// Returns the size in bytes; 0 for text, which has no fixed size.
constexpr std::size_t size_of(ObjectType type) noexcept {
  switch (type) {
    case ObjectType::u8:
    case ObjectType::i8: return 1;
    case ObjectType::u16:
    case ObjectType::i16: return 2;
    case ObjectType::u32:
    case ObjectType::i32: return 4;
    case ObjectType::text: break;
  }
  return 0;
}

/// Returns the largest value of a numeric type.
constexpr std::int64_t highest(ObjectType type) noexcept {
  const std::size_t bits = 8 * size_of(type) - (is_signed(type) ? 1 : 0);
  return (std::int64_t{1} << bits) - 1;
}
constexpr std::int64_t lowest(ObjectType type) noexcept { return is_signed(type) ? -highest(type) - 1 : 0; }
constexpr bool in_range(ObjectType type, std::int64_t value) noexcept {
  return value >= lowest(type) && value <= highest(type);
}

/// Encodes the low `bytes.size()` bytes of a number, little-endian, two's complement.
constexpr void encode_number(std::int64_t value, std::span<std::uint8_t> bytes) noexcept {
  auto rest = static_cast<std::uint64_t>(value);
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(rest & 0xFFu);
    rest >>= 8;
  }
}

/// Decodes at most eight bytes and ignores further ones. No bytes give 0. negative_possible: type is signed.
constexpr std::int64_t decode_number(std::span<const std::uint8_t> bytes, bool negative_possible) noexcept {
  const std::size_t size = bytes.size() < 8 ? bytes.size() : 8;
  std::uint64_t raw = 0;
  for (std::size_t i = size; i-- > 0;) raw = (raw << 8) | bytes[i];
  const bool negative = negative_possible && size > 0 && size < 8 && (raw >> (8 * size - 1)) != 0;
  if (negative) raw |= ~std::uint64_t{0} << (8 * size);
  return static_cast<std::int64_t>(raw);
}

}  // namespace godobject::canopen
