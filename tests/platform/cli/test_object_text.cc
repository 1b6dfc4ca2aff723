#include "platform/cli/bus/dialogue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace godobject::test_object_text {
namespace {

using canopen::ObjectAddress;
using testing::HasSubstr;

TEST(ObjectText, AddressesAsInManuals) {
  for (const char* text : {"6077", "6077h", "0x6077", "6077:00", "6077h:00", "0x6077:0x00", "6077H:0"})
    EXPECT_EQ(parse_object_address(text), (ObjectAddress{0x6077, 0})) << text;
  EXPECT_EQ(parse_object_address("1A00:0A"), (ObjectAddress{0x1A00, 0x0A}));
  for (const char* text : {"", ":", "6077:", ":01", "10000", "6077:100", "60G7", "6077 ", "-1", "6077:1:2"})
    EXPECT_FALSE(parse_object_address(text)) << text;
}

TEST(ObjectText, ValuesAreCheckedAgainstTheirType) {
  std::string error;
  EXPECT_EQ(parse_value("-2", "i16", error), (std::vector<std::uint8_t>{0xFE, 0xFF}));
  EXPECT_EQ(parse_value("0x65766173", "u32", error), (std::vector<std::uint8_t>{'s', 'a', 'v', 'e'}));
  EXPECT_EQ(parse_value("abc", "string", error), (std::vector<std::uint8_t>{'a', 'b', 'c'}));
  EXPECT_EQ(parse_value("0A 0b", "hex", error), (std::vector<std::uint8_t>{0x0A, 0x0B}));
  EXPECT_EQ(error, "");
  EXPECT_FALSE(parse_value("256", "u8", error));
  EXPECT_THAT(error, HasSubstr("0 to 255"));
  for (const char* text : {"", "1.5", "10h", "0x", "0x-1", "1 "})
    EXPECT_FALSE(parse_value(text, "i32", error)) << text;
  for (const char* text : {"", "0", "0G", "0A0"}) EXPECT_FALSE(parse_value(text, "hex", error)) << text;
}

TEST(ObjectText, BytesAsTheirTypeOrAsAllTheyMayBe) {
  std::string error;
  const std::array<std::uint8_t, 2> two{0xFE, 0xFF};
  EXPECT_EQ(format_value(two, "i16", error), "-2");
  EXPECT_EQ(format_value(two, "", error), "hex FE FF, u16 65534, i16 -2");
  EXPECT_FALSE(format_value(two, "u32", error));
  EXPECT_THAT(error, HasSubstr("has 2 bytes"));
  const std::array<std::uint8_t, 5> text{'E', 'P', '\x1b', '4', 0};
  EXPECT_EQ(format_value(text, "string", error), "EP.4");
}

}  // namespace
}  // namespace godobject::test_object_text
