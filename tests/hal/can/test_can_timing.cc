#include "hal/can/timing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

namespace godobject::test_can_timing {
namespace {

CanFrame frame_of(std::uint8_t size, bool extended = false, bool fd = false) {
  return {.id = 0, .extended = extended, .fd = fd, .bit_rate_switch = fd, .size = size};
}

// Counts independently: the bits as text, CRC by polynomial long division, stuffing by scanning the text.
std::string binary(std::uint32_t value, int width) {
  std::string out;
  for (int i = width - 1; i >= 0; --i) out += ((value >> i) & 1u) != 0 ? '1' : '0';
  return out;
}

std::string crc15(const std::string& message) {
  const std::string polynomial = "1100010110011001";
  std::string rest = message + std::string(15, '0');
  for (std::size_t i = 0; i < message.size(); ++i) {
    if (rest[i] == '0') continue;
    for (std::size_t k = 0; k < polynomial.size(); ++k) {
      rest[i + k] = rest[i + k] == polynomial[k] ? '0' : '1';
    }
  }
  return rest.substr(message.size());
}

int counted_bits(const CanFrame& f) {
  std::string bits = "0";
  if (f.extended) {
    bits += binary(f.id >> 18, 11) + "11" + binary(f.id & 0x3FFFF, 18) + (f.remote ? "1" : "0") + "00";
  } else {
    bits += binary(f.id, 11) + (f.remote ? "1" : "0") + "00";
  }
  bits += binary(f.size, 4);
  if (!f.remote) {
    for (const std::uint8_t byte : f.bytes()) bits += binary(byte, 8);
  }
  bits += crc15(bits);
  std::string wire;
  for (const char bit : bits) {
    wire += bit;
    if (wire.ends_with("00000")) wire += '1';
    else if (wire.ends_with("11111")) wire += '0';
  }
  return static_cast<int>(wire.size()) + 13;
}

TEST(CanTiming, ClassicBoundsAreTheHandbooks) {
  for (std::uint8_t n = 0; n <= 8; ++n) {
    EXPECT_EQ(nominal_bits(frame_of(n)).total(), 47 + 8 * n);
    EXPECT_EQ(worst_bits(frame_of(n)).total(), 55 + 10 * n);
    EXPECT_EQ(nominal_bits(frame_of(n, true)).total(), 67 + 8 * n);
    EXPECT_EQ(worst_bits(frame_of(n, true)).total(), 80 + 10 * n);
  }
}

TEST(CanTiming, FdBoundsAreTheHandbooks) {
  struct Row {
    std::uint8_t bytes;
    double data_rate;
    bool extended;
    double nominal_us, worst_us;
  };
  const Row rows[] = {
      {0, 2e6, false, 46, 50},    {8, 2e6, false, 78, 90},    {24, 2e6, false, 144, 173},
      {64, 2e6, false, 304, 373}, {0, 5e6, false, 36, 41},    {8, 5e6, false, 49, 57},
      {16, 5e6, false, 62, 73},   {64, 5e6, false, 140, 170}, {0, 5e6, true, 55, 64},
      {8, 5e6, true, 68, 80},     {24, 5e6, true, 95, 113},   {64, 5e6, true, 159, 193},
      {0, 8e6, false, 34, 38},    {32, 8e6, false, 67, 79},   {48, 8e6, false, 83, 99},
      {64, 8e6, false, 99, 119},
  };
  for (const Row& row : rows) {
    const CanFrame frame = frame_of(row.bytes, row.extended, true);
    const BitRates rates{.nominal = 1e6, .data = row.data_rate};
    EXPECT_NEAR(1e-3 * static_cast<double>(duration_ns(nominal_bits(frame), rates)), row.nominal_us, 0.5);
    EXPECT_NEAR(1e-3 * static_cast<double>(duration_ns(worst_bits(frame), rates)), row.worst_us, 0.5);
  }
}

TEST(CanTiming, FdWithoutBitRateSwitchTravelsAtTheNominalRate) {
  CanFrame frame = frame_of(8, false, true);
  const int total = worst_bits(frame).total();
  frame.bit_rate_switch = false;
  EXPECT_EQ(worst_bits(frame).data_rate, 0);
  EXPECT_EQ(worst_bits(frame).total(), total);
}

// 34 dominant bits, the CRC of zeros being zero: a stuff bit after every five.
TEST(CanTiming, AllDominantFrameHasSixStuffBits) { EXPECT_EQ(exact_bits(frame_of(0)).total(), 47 + 6); }

TEST(CanTiming, ExactLengthAgreesWithAnIndependentCount) {
  std::mt19937 random(1);
  int shortest_margin = 100;
  for (int i = 0; i < 20000; ++i) {
    CanFrame frame;
    frame.extended = random() % 2 != 0;
    frame.id = static_cast<std::uint32_t>(random()) & (frame.extended ? 0x1FFFFFFFu : 0x7FFu);
    frame.remote = random() % 8 == 0;
    frame.size = static_cast<std::uint8_t>(random() % 9);
    // Long runs of equal bits, which are critical for stuffing.
    for (std::uint8_t& byte : frame.data) {
      byte = static_cast<std::uint8_t>(random() % 3 == 0 ? random() : (random() % 2) * 255);
    }
    const int exact = exact_bits(frame).total();
    ASSERT_EQ(exact, counted_bits(frame));
    ASSERT_GE(exact, nominal_bits(frame).total());
    ASSERT_LE(exact, worst_bits(frame).total());
    shortest_margin = std::min(shortest_margin, worst_bits(frame).total() - exact);
  }
  EXPECT_LE(shortest_margin, 8);
}

TEST(CanTiming, BytesBeyondTheSizeDoNotCount) {
  CanFrame frame = frame_of(2);
  const int bits = exact_bits(frame).total();
  frame.data[2] = 0x55;
  EXPECT_EQ(exact_bits(frame).total(), bits);
}

TEST(CanTiming, DurationScalesWithTheBitRate) {
  const FrameBits bits = nominal_bits(frame_of(8));
  EXPECT_EQ(duration_ns(bits, {.nominal = 1e6}), 111'000);
  EXPECT_EQ(duration_ns(bits, {.nominal = 125e3}), 888'000);
  EXPECT_EQ(duration_ns(128 * 11, {.nominal = 1e6}), 1'408'000);
}

TEST(CanFrame, ValidityFollowsTheFormat) {
  EXPECT_TRUE(is_valid({.id = 0x7FF, .size = 8}));
  EXPECT_FALSE(is_valid({.id = 0x800}));
  EXPECT_TRUE(is_valid({.id = 0x1FFFFFFF, .extended = true}));
  EXPECT_FALSE(is_valid({.id = 0x20000000, .extended = true}));
  EXPECT_FALSE(is_valid({.size = 9}));
  EXPECT_FALSE(is_valid({.bit_rate_switch = true}));
  EXPECT_FALSE(is_valid({.remote = true, .fd = true}));
  EXPECT_TRUE(is_valid({.fd = true, .size = 12}));
  EXPECT_FALSE(is_valid({.fd = true, .size = 13}));
  EXPECT_FALSE(is_valid({.fd = true, .size = 65}));
}

}  // namespace
}  // namespace godobject::test_can_timing
