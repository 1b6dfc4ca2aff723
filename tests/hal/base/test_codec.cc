#include "hal/base/codec.h"

#include <gtest/gtest.h>

#include <array>

namespace godobject::test_codec {
namespace {

TEST(Codec, WritesLittleEndian) {
  std::array<std::uint8_t, 8> bytes{};
  ByteWriter writer(bytes);
  writer.put(std::uint16_t{0x1234}).put(std::int32_t{-2}).put(std::int8_t{-128});
  EXPECT_TRUE(writer.ok());
  EXPECT_EQ(writer.size(), 7u);
  EXPECT_EQ(bytes, (std::array<std::uint8_t, 8>{0x34, 0x12, 0xFE, 0xFF, 0xFF, 0xFF, 0x80, 0}));
}

TEST(Codec, ReadsBackWhatWasWritten) {
  std::array<std::uint8_t, 15> bytes{};
  ByteWriter(bytes)
      .put(std::int64_t{-1234567890123})
      .put(std::uint32_t{0xDEADBEEF})
      .put(std::int16_t{-32768});
  std::int64_t a = 0;
  std::uint32_t b = 0;
  std::int16_t c = 0;
  EXPECT_TRUE(ByteReader(bytes).get(a).get(b).get(c).ok());
  EXPECT_EQ(a, -1234567890123);
  EXPECT_EQ(b, 0xDEADBEEF);
  EXPECT_EQ(c, -32768);
}

TEST(Codec, NothingIsTouchedPastTheEnd) {
  std::array<std::uint8_t, 4> bytes{1, 2, 3, 4};
  ByteWriter writer(std::span<std::uint8_t>(bytes).first(3));
  writer.put(std::uint16_t{0xFFFF}).put(std::uint16_t{0xFFFF}).put(std::uint8_t{0xFF});
  EXPECT_FALSE(writer.ok());
  EXPECT_EQ(bytes, (std::array<std::uint8_t, 4>{0xFF, 0xFF, 3, 4}));

  std::uint32_t value = 77;
  std::uint8_t after = 78;
  EXPECT_FALSE(ByteReader(std::span<const std::uint8_t>(bytes).first(3)).get(value).get(after).ok());
  EXPECT_EQ(value, 77u);
  EXPECT_EQ(after, 78u);
}

TEST(Codec, WorksAtCompileTime) {
  constexpr auto value = [] {
    std::array<std::uint8_t, 2> bytes{};
    ByteWriter(bytes).put(std::int16_t{-300});
    std::int16_t out = 0;
    ByteReader(bytes).get(out);
    return out;
  }();
  static_assert(value == -300);
}

TEST(Codec, SaturatesAndRounds) {
  EXPECT_EQ(saturate_to<std::int16_t>(1e9), 32767);
  EXPECT_EQ(saturate_to<std::int16_t>(-1e9), -32768);
  EXPECT_EQ(saturate_to<std::int16_t>(2.5), 3);
  EXPECT_EQ(saturate_to<std::int16_t>(-2.5), -3);
  EXPECT_EQ(saturate_to<std::int16_t>(500, -100, 100), 100);
  EXPECT_EQ(saturate_to<std::uint8_t>(-1), 0);
  EXPECT_EQ(saturate_to<std::int64_t>(1e300), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(saturate_to<std::int64_t>(9223372036854775808.0), std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(saturate_to<std::int32_t>(-std::numeric_limits<double>::infinity()),
            std::numeric_limits<std::int32_t>::min());
  EXPECT_EQ(saturate_to<std::int32_t>(std::numeric_limits<double>::quiet_NaN()), 0);
}

}  // namespace
}  // namespace godobject::test_codec
