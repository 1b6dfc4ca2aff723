// CRC-32 of IEEE 802.3, of the chunks of input logs, of PNG and of MCAP.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace godobject {

/// CRC of each single byte.
inline constexpr std::array<std::uint32_t, 256> crc32_table = [] {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xEDB88320u : 0u);
    table[byte] = crc;
  }
  return table;
}();

/// Computes the CRC of `bytes`. Check value of "123456789": CBF43926.
/// before: CRC of the bytes before them.
constexpr std::uint32_t crc32(std::string_view bytes, std::uint32_t before = 0) noexcept {
  std::uint32_t crc = ~before;
  for (const char byte : bytes) crc = crc >> 8 ^ crc32_table[(crc ^ static_cast<unsigned char>(byte)) & 0xff];
  return ~crc;
}

}  // namespace godobject
