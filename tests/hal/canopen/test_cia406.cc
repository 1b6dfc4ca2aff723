// CiA 406 encoders and CiA 401 inputs.
#include "hal/canopen/cia406.h"

#include <gtest/gtest.h>

#include "hal/canopen/cia401.h"

namespace godobject::test_cia406 {
namespace {

TEST(Cia406, PositionAndSpeed) {
  const CanFrame frame = cia406::make_position_and_speed(3, {.position_counts = 0x01020304, .speed = -2});
  EXPECT_EQ(frame.id, 0x183u);
  EXPECT_EQ(frame.size, 6);
  EXPECT_EQ(frame.data[0], 0x04);
  EXPECT_EQ(frame.data[4], 0xFE);
  cia406::PositionAndSpeed out;
  ASSERT_EQ(cia406::parse_position_and_speed(frame, 3, out), ParseResult::ok);
  EXPECT_EQ(out.position_counts, 0x01020304u);
  EXPECT_EQ(out.speed, -2);
  EXPECT_EQ(cia406::parse_position_and_speed(cia406::make_position(3, 0), 3, out), ParseResult::too_short);
}

TEST(Cia406, PresetIsNotForAnArmedDeviceNorBeyondTheModulus) {
  using cia406::PresetCheck;
  EXPECT_EQ(cia406::check_preset(100, 4096, true), PresetCheck::armed);
  EXPECT_EQ(cia406::check_preset(4096, 4096, false), PresetCheck::out_of_range);
  EXPECT_EQ(cia406::check_preset(4095, 4096, false), PresetCheck::allowed);
  EXPECT_EQ(cia406::check_preset(0xFFFFFFFF, 0, false), PresetCheck::allowed);
}

TEST(Cia406, AlarmsAndWarningsHaveWords) {
  EXPECT_EQ(cia406::alarm_texts[0].meaning, "position error");
  std::uint16_t seen = 0;
  for (const cia406::BitText& text : cia406::warning_texts) {
    EXPECT_EQ(seen & text.bit, 0);
    EXPECT_FALSE(text.meaning.empty());
    seen = static_cast<std::uint16_t>(seen | text.bit);
  }
  EXPECT_EQ(seen, 0x3F);
}

TEST(Cia401, FirstByteOfTheInputs) {
  std::uint8_t inputs = 0;
  CanFrame frame = cia401::make_inputs(9, 0xA5);
  EXPECT_EQ(frame.id, 0x189u);
  ASSERT_EQ(cia401::parse_inputs(frame, 9, inputs), ParseResult::ok);
  EXPECT_EQ(inputs, 0xA5);
  frame.size = 0;
  EXPECT_EQ(cia401::parse_inputs(frame, 9, inputs), ParseResult::too_short);
  frame.size = 2;
  EXPECT_EQ(cia401::parse_inputs(frame, 9, inputs), ParseResult::ok);
  EXPECT_EQ(cia401::parse_inputs(frame, 8, inputs), ParseResult::other_message);
}

}  // namespace
}  // namespace godobject::test_cia406
