// The two CRC-16 variants of the serial protocols: one routine per bit order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace godobject {

/// Parameters of a CRC-16. Both variants have no final exclusive-or.
struct Crc16Kind {
  std::uint16_t polynomial = 0;  // bit-reversed when `reflected`
  std::uint16_t initial = 0;
  bool reflected = false;
};

/// CRC-16/ARC of the NDI Combined API: x16 + x15 + x2 + 1. Check value of "123456789": BB3D.
inline constexpr Crc16Kind crc16_arc{.polynomial = 0xA001, .initial = 0x0000, .reflected = true};
/// CRC-16/CCITT-FALSE of the encoder board: x16 + x12 + x5 + 1. Check value of "123456789": 29B1.
inline constexpr Crc16Kind crc16_ccitt{.polynomial = 0x1021, .initial = 0xFFFF, .reflected = false};

/// Computes the CRC of each single byte.
template <Crc16Kind kind>
consteval std::array<std::uint16_t, 256> crc16_table() {
  std::array<std::uint16_t, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    unsigned crc = kind.reflected ? byte : byte << 8;
    for (int bit = 0; bit < 8; ++bit) {
      const bool out = (crc & (kind.reflected ? 1u : 0x8000u)) != 0;
      crc = (kind.reflected ? crc >> 1 : crc << 1) ^ (out ? kind.polynomial : 0u);
    }
    table[byte] = static_cast<std::uint16_t>(crc);
  }
  return table;
}

/// Computes the CRC of `bytes`. so_far: CRC of the preceding bytes of the same message.
template <Crc16Kind kind>
constexpr std::uint16_t crc16(std::span<const std::uint8_t> bytes,
                              std::uint16_t so_far = kind.initial) noexcept {
  constexpr auto table = crc16_table<kind>();
  unsigned crc = so_far;
  for (const std::uint8_t byte : bytes) {
    crc = kind.reflected ? (crc >> 8) ^ table[(crc ^ byte) & 0xFFu]
                         : ((crc << 8) & 0xFFFFu) ^ table[(crc >> 8) ^ byte];
  }
  return static_cast<std::uint16_t>(crc);
}

}  // namespace godobject
