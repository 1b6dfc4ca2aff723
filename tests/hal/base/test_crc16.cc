#include "hal/base/crc16.h"

#include <gtest/gtest.h>

#include <string_view>
#include <vector>

namespace godobject::test_crc16 {
namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) { return {text.begin(), text.end()}; }

TEST(Crc16, CheckValuesOfTheCatalogue) {
  EXPECT_EQ(crc16<crc16_arc>(bytes_of("123456789")), 0xBB3D);
  EXPECT_EQ(crc16<crc16_ccitt>(bytes_of("123456789")), 0x29B1);
}

TEST(Crc16, NdiMessages) {
  const std::pair<std::string_view, std::uint16_t> messages[] = {
      {"RESET", 0xBE6F},      {"OKAY", 0xA896},     {"INIT:", 0xE3A5},    {"TSTART:", 0x5423},
      {"TSTART:80", 0x1B0B},  {"TSTOP:", 0x2C14},   {"BX:0001", 0xC26D},  {"BX:0801", 0x00EC},
      {"TX:0001", 0x031A},    {"PHSR:00", 0x20FF},  {"PINIT:01", 0x31EA}, {"PENA:01D", 0x6D3B},
      {"COMM:50000", 0x0048}, {"APIREV:0", 0xC4C5}, {"VER:0", 0x65EE}};
  for (const auto& [text, crc] : messages) EXPECT_EQ(crc16<crc16_arc>(bytes_of(text)), crc) << text;
}

TEST(Crc16, PartsGiveTheSameAsTheWhole) {
  const std::vector<std::uint8_t> all = bytes_of("123456789");
  const std::span<const std::uint8_t> bytes(all);
  for (std::size_t cut = 0; cut <= all.size(); ++cut) {
    EXPECT_EQ(crc16<crc16_arc>(bytes.subspan(cut), crc16<crc16_arc>(bytes.first(cut))), 0xBB3D);
    EXPECT_EQ(crc16<crc16_ccitt>(bytes.subspan(cut), crc16<crc16_ccitt>(bytes.first(cut))), 0x29B1);
  }
}

TEST(Crc16, EveryChangeOfOneByteIsSeen) {
  std::vector<std::uint8_t> bytes = bytes_of("0A+07138+05131+04024+02550");
  const std::uint16_t arc = crc16<crc16_arc>(bytes), ccitt = crc16<crc16_ccitt>(bytes);
  for (std::uint8_t& byte : bytes) {
    for (int flip = 1; flip < 256; ++flip) {
      byte = static_cast<std::uint8_t>(byte ^ flip);
      EXPECT_NE(crc16<crc16_arc>(bytes), arc);
      EXPECT_NE(crc16<crc16_ccitt>(bytes), ccitt);
      byte = static_cast<std::uint8_t>(byte ^ flip);
    }
  }
}

}  // namespace
}  // namespace godobject::test_crc16
