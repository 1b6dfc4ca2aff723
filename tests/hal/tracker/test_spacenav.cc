#include "hal/tracker/spacenav.h"

#include <gtest/gtest.h>

#include <random>

namespace godobject::test_spacenav {
namespace {

using Words = std::array<std::int32_t, 8>;

ParseResult decode_words(const Words& words, SpacenavEvent& out) {
  std::array<std::uint8_t, spacenav_event_bytes> bytes{};
  std::memcpy(bytes.data(), words.data(), bytes.size());
  return decode(bytes, out);
}

TEST(Spacenav, ReadsMotionsAndButtons) {
  std::mt19937 random(19);
  std::uniform_int_distribution<std::int32_t> counts(-max_spacenav_counts, max_spacenav_counts),
      number(0, 255);
  for (int i = 0; i < 1000; ++i) {
    Words words{0};
    for (std::size_t k = 1; k < 7; ++k) words[k] = counts(random);
    words[7] = 16;
    SpacenavEvent event;
    ASSERT_EQ(decode_words(words, event), ParseResult::ok);
    EXPECT_EQ(event.kind, SpacenavEvent::Kind::motion);
    EXPECT_TRUE(std::equal(event.axes.begin(), event.axes.end(), words.begin() + 1));
    const bool pressed = i % 2 == 0;
    const std::int32_t button = number(random);
    ASSERT_EQ(decode_words({pressed ? 1 : 2, button}, event), ParseResult::ok);
    EXPECT_EQ(event.kind, pressed ? SpacenavEvent::Kind::press : SpacenavEvent::Kind::release);
    EXPECT_EQ(event.button, button);
  }
}

TEST(Spacenav, RefusesWhatIsNoEvent) {
  SpacenavEvent event{.button = 7};
  const std::array<std::uint8_t, spacenav_event_bytes + 1> bytes{};
  EXPECT_EQ(decode(std::span(bytes).first(31), event), ParseResult::too_short);
  EXPECT_EQ(decode(bytes, event), ParseResult::too_long);
  for (const std::int32_t later : {3, 4, 5, 6})
    EXPECT_EQ(decode_words({later}, event), ParseResult::other_message);
  for (const std::int32_t unknown : {-1, 7, 0x7faa5500})
    EXPECT_EQ(decode_words({unknown}, event), ParseResult::bad_value);
  EXPECT_EQ(decode_words({1, -1}, event), ParseResult::bad_value);
  EXPECT_EQ(decode_words({2, 256}, event), ParseResult::bad_value);
  for (std::size_t axis = 1; axis <= 6; ++axis)
    for (const std::int32_t far : {max_spacenav_counts + 1, std::numeric_limits<std::int32_t>::min(),
                                   std::numeric_limits<std::int32_t>::max()}) {
      Words words{};
      words[axis] = far;
      EXPECT_EQ(decode_words(words, event), ParseResult::bad_value);
    }
  EXPECT_EQ(event.button, 7) << "written on ok only";
}

/// The daemon's frame has x to the right, y up, z away from the user.
TEST(Spacenav, AxesAreThoseOfAWorldWithZUp) {
  const SpacenavEvent right{.axes = {1, 0, 0, 1, 0, 0}}, up{.axes = {0, 1, 0, 0, 1, 0}},
      away{.axes = {0, 0, 1, 0, 0, 1}};
  for (const std::size_t first : {0u, 3u}) {
    EXPECT_EQ(spacenav_vector(right, first), Vec3::UnitX());
    EXPECT_EQ(spacenav_vector(up, first), Vec3::UnitZ());
    EXPECT_EQ(spacenav_vector(away, first), Vec3::UnitY());
  }
}

}  // namespace
}  // namespace godobject::test_spacenav
