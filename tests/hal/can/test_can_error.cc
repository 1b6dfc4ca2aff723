#include "hal/can/error.h"

#include <gtest/gtest.h>

#include <array>
#include <random>

namespace godobject::test_can_error {
namespace {

struct Line {
  const char* what;
  std::uint32_t error_class;
  std::array<std::uint8_t, 8> data;
  BusError error;
  std::optional<BusState> state;
};

// Frames as made by Linux's slcan, sja1000 and can-dev drivers.
TEST(CanError, NamesWhatTheDriversReport) {
  const Line lines[] = {
      {"warning", 0x204, {0, 0x0C, 0, 0, 0, 0, 96, 96}, BusError::none, BusState::error_warning},
      {"sender passive", 0x204, {0, 0x20, 0, 0, 0, 0, 128, 0}, BusError::none, BusState::error_passive},
      {"receiver passive, sender warning", 0x204, {0, 0x18}, BusError::none, BusState::error_passive},
      {"back to active", 0x204, {0, 0x40}, BusError::none, BusState::error_active},
      {"bus-off", 0x040, {}, BusError::none, BusState::bus_off},
      {"restarted", 0x100, {}, BusError::restarted, BusState::error_active},
      {"no acknowledge", 0x0A8, {0, 0, 0, 0x19}, BusError::acknowledge, std::nullopt},
      {"acknowledge slot only", 0x088, {0, 0, 0x02, 0x19}, BusError::acknowledge, std::nullopt},
      {"bit 1", 0x088, {0, 0, 0x10, 0}, BusError::bit, std::nullopt},
      {"bit 0 while sending", 0x088, {0, 0, 0x88, 0x0A}, BusError::bit, std::nullopt},
      {"stuff", 0x088, {0, 0, 0x04, 0x0A}, BusError::stuff, std::nullopt},
      {"form", 0x088, {0, 0, 0x02, 0x1A}, BusError::form, std::nullopt},
      {"crc", 0x088, {0, 0, 0, 0x08}, BusError::crc, std::nullopt},
      {"crc delimiter", 0x088, {0, 0, 0x02, 0x18}, BusError::crc, std::nullopt},
      {"lost arbitration", 0x002, {11}, BusError::lost_arbitration, std::nullopt},
      {"receive overflow", 0x004, {0, 0x01}, BusError::receive_overflow, std::nullopt},
      {"transmit overflow", 0x004, {0, 0x02}, BusError::transmit_overflow, std::nullopt},
      {"transmit time-out", 0x001, {}, BusError::transmit_timeout, std::nullopt},
      {"transceiver", 0x010, {0, 0, 0, 0, 0x04}, BusError::transceiver, std::nullopt},
      {"slcan's overflow", 0x08C, {0, 0x01}, BusError::receive_overflow, std::nullopt},
      {"unspecified", 0x080, {}, BusError::other, std::nullopt},
      {"nothing", 0, {}, BusError::none, std::nullopt},
  };
  for (const Line& line : lines) {
    const CanErrorReport report = decode_can_error(line.error_class, line.data);
    EXPECT_EQ(report.error, line.error) << line.what;
    EXPECT_EQ(report.state, line.state) << line.what;
  }
}

TEST(CanError, CountersAreReadOnlyWhereTheDriverSaysSo) {
  const std::array<std::uint8_t, 8> data{0, 0x10, 0, 0, 0, 0, 12, 130};
  EXPECT_FALSE(decode_can_error(0x004, data).counters);
  const CanErrorReport report = decode_can_error(0x204, data);
  ASSERT_TRUE(report.counters);
  EXPECT_EQ(report.counters->transmit, 12);
  EXPECT_EQ(report.counters->receive, 130);
}

TEST(CanError, BusOffIsCountedOnceAndLeftByTheRestart) {
  BusState state = BusState::error_active;
  BusCounters counters;
  apply(decode_can_error(0x040, {}), state, counters);
  apply(decode_can_error(0x040, {}), state, counters);
  EXPECT_EQ(state, BusState::bus_off);
  EXPECT_EQ(counters.bus_off_events, 1u);
  apply(decode_can_error(0x100, {}), state, counters);
  EXPECT_EQ(state, BusState::error_active);
  EXPECT_EQ(counters.restarts, 1u);
  EXPECT_EQ(counters.last_error, BusError::restarted);
  EXPECT_EQ(counters.error_frames, 3u);
}

TEST(CanError, ErrorFramesDoNotBringBackAnInterfaceThatIsGone) {
  for (const BusState absent : {BusState::closed, BusState::down, BusState::gone}) {
    BusState state = absent;
    BusCounters counters;
    apply(decode_can_error(0x204, std::array<std::uint8_t, 2>{0, 0x40}), state, counters);
    EXPECT_EQ(state, absent);
  }
}

TEST(CanError, LastErrorOutlivesAPlainChangeOfState) {
  BusState state = BusState::error_active;
  BusCounters counters;
  apply(decode_can_error(0x088, std::array<std::uint8_t, 4>{0, 0, 4, 0}), state, counters);
  apply(decode_can_error(0x204, std::array<std::uint8_t, 8>{0, 0x08, 0, 0, 0, 0, 96, 0}), state, counters);
  EXPECT_EQ(counters.last_error, BusError::stuff);
  EXPECT_EQ(state, BusState::error_warning);
  EXPECT_EQ(counters.transmit_error_counter, 96);
}

TEST(CanError, AnOverrunInTheControllerCountsAsALostFrame) {
  BusState state = BusState::error_active;
  BusCounters counters;
  apply(decode_can_error(0x004, std::array<std::uint8_t, 2>{0, 0x01}), state, counters);
  EXPECT_EQ(counters.receive_overflow, 1u);
}

TEST(CanError, AnyBytesGiveAReport) {
  std::mt19937 random(7);
  for (int i = 0; i < 100'000; ++i) {
    std::array<std::uint8_t, 8> data{};
    for (std::uint8_t& byte : data) byte = static_cast<std::uint8_t>(random());
    const std::size_t size = random() % 9;
    const CanErrorReport report =
        decode_can_error(static_cast<std::uint32_t>(random()), std::span(data).first(size));
    ASSERT_LE(report.error, BusError::other);
    ASSERT_NE(name_of(report.error), "?");
  }
}

TEST(CanBus, EveryStateAndErrorHasAName) {
  for (int i = 0; i <= static_cast<int>(BusState::gone); ++i)
    EXPECT_NE(name_of(static_cast<BusState>(i)), "?") << i;
  for (int i = 1; i <= static_cast<int>(BusError::other); ++i)
    EXPECT_FALSE(text_of(static_cast<BusError>(i)).empty()) << i;
  EXPECT_TRUE(is_cut_off(BusState::down));
  EXPECT_TRUE(is_cut_off(BusState::closed));
  EXPECT_FALSE(is_cut_off(BusState::error_passive));
}

}  // namespace
}  // namespace godobject::test_can_error
