#include "hal/canopen/canopen.h"

#include <gtest/gtest.h>

#include "hal/canopen/cia406.h"

namespace godobject::test_canopen {
namespace {

using namespace canopen;

CanFrame resized(CanFrame frame, std::uint8_t size) {
  frame.size = size;
  return frame;
}

TEST(Canopen, PredefinedConnectionSet) {
  EXPECT_EQ(emcy_cob_id(5), 0x085u);
  EXPECT_EQ(tpdo_cob_id(1, 5), 0x185u);
  EXPECT_EQ(tpdo_cob_id(4, 5), 0x485u);
  EXPECT_EQ(rpdo_cob_id(1, 5), 0x205u);
  EXPECT_EQ(rpdo_cob_id(4, 5), 0x505u);
  EXPECT_EQ(heartbeat_cob_id(5), 0x705u);
}

TEST(Canopen, NmtRoundTripAndRejects) {
  Nmt nmt;
  const CanFrame frame = make_nmt(NmtCommand::enter_pre_operational, 7);
  EXPECT_EQ(frame.id, 0u);
  EXPECT_EQ(frame.size, 2);
  EXPECT_EQ(frame.data[0], 0x80);
  ASSERT_EQ(parse_nmt(frame, nmt), ParseResult::ok);
  EXPECT_EQ(nmt.command, NmtCommand::enter_pre_operational);
  EXPECT_EQ(nmt.node, 7);
  EXPECT_EQ(parse_nmt(resized(frame, 1), nmt), ParseResult::too_short);
  EXPECT_EQ(parse_nmt(resized(frame, 3), nmt), ParseResult::too_long);
  EXPECT_EQ(parse_nmt(make_nmt(static_cast<NmtCommand>(3), 7), nmt), ParseResult::bad_value);
  EXPECT_EQ(parse_nmt(make_nmt(NmtCommand::start, 128), nmt), ParseResult::bad_value);
  EXPECT_EQ(parse_nmt(make_sync(), nmt), ParseResult::other_message);
}

TEST(Canopen, OutputStaysUntouchedOnError) {
  Nmt nmt{.command = NmtCommand::stop, .node = 9};
  EXPECT_EQ(parse_nmt(make_nmt(NmtCommand::start, 200), nmt), ParseResult::bad_value);
  EXPECT_EQ(nmt.command, NmtCommand::stop);
  EXPECT_EQ(nmt.node, 9);
}

TEST(Canopen, HeartbeatCarriesNodeAndState) {
  Heartbeat heartbeat;
  ASSERT_EQ(parse_heartbeat(make_heartbeat(127, NmtState::pre_operational), heartbeat), ParseResult::ok);
  EXPECT_EQ(heartbeat.node, 127);
  EXPECT_EQ(heartbeat.state, NmtState::pre_operational);
  ASSERT_EQ(parse_heartbeat(make_heartbeat(1, NmtState::boot_up), heartbeat), ParseResult::ok);
  EXPECT_EQ(heartbeat.state, NmtState::boot_up);
  EXPECT_EQ(parse_heartbeat(make_heartbeat(1, static_cast<NmtState>(0x85)), heartbeat),
            ParseResult::bad_value);
  EXPECT_EQ(parse_heartbeat({.id = 0x700, .size = 1}, heartbeat), ParseResult::other_message);
  EXPECT_EQ(parse_heartbeat({.id = 0x780, .size = 1}, heartbeat), ParseResult::other_message);
  EXPECT_EQ(parse_heartbeat(resized(make_heartbeat(1, NmtState::stopped), 0), heartbeat),
            ParseResult::too_short);
}

TEST(Canopen, SyncWithAndWithoutCounter) {
  std::uint8_t counter = 99;
  ASSERT_EQ(parse_sync(make_sync(), counter), ParseResult::ok);
  EXPECT_EQ(counter, 0);
  ASSERT_EQ(parse_sync(make_sync(17), counter), ParseResult::ok);
  EXPECT_EQ(counter, 17);
  EXPECT_EQ(parse_sync(resized(make_sync(), 2), counter), ParseResult::too_long);
  EXPECT_EQ(parse_sync({.id = 0x80, .extended = true}, counter), ParseResult::other_message);
  EXPECT_EQ(parse_sync({.id = 0x80, .remote = true}, counter), ParseResult::other_message);
}

// SYNC shares 080h with the base of the emergencies.
TEST(Canopen, EmergencyIsNotSync) {
  Emergency emergency;
  EXPECT_EQ(parse_emergency(make_sync(), emergency), ParseResult::other_message);
  const CanFrame frame =
      make_emergency({.node = 9, .error_code = 0x8250, .error_register = 0x11, .vendor = {1, 2, 3, 4, 5}});
  EXPECT_EQ(frame.id, 0x089u);
  EXPECT_EQ(frame.data[0], 0x50);
  EXPECT_EQ(frame.data[1], 0x82);
  ASSERT_EQ(parse_emergency(frame, emergency), ParseResult::ok);
  EXPECT_EQ(emergency.node, 9);
  EXPECT_EQ(emergency.error_code, emcy_rpdo_timeout);
  EXPECT_EQ(emergency.error_register, 0x11);
  EXPECT_EQ(emergency.vendor, (std::array<std::uint8_t, 5>{1, 2, 3, 4, 5}));
  EXPECT_EQ(parse_emergency(resized(frame, 9), emergency), ParseResult::too_long);
}

TEST(Canopen, EmergencyOfFewerBytesIsOne) {
  const CanFrame whole =
      make_emergency({.node = 9, .error_code = 0x8250, .error_register = 0x11, .vendor = {1, 2, 3, 4, 5}});
  for (std::uint8_t size = 0; size < 8; ++size) {
    Emergency emergency{.vendor = {9, 9, 9, 9, 9}};
    ASSERT_EQ(parse_emergency(resized(whole, size), emergency), ParseResult::ok) << int{size};
    EXPECT_EQ(emergency.node, 9);
    EXPECT_EQ(emergency.error_code, size < 2 ? 0x1000 : 0x8250);
    EXPECT_EQ(emergency.error_register, size < 3 ? 0 : 0x11);
    EXPECT_EQ(emergency.vendor[4], 0);
  }
}

TEST(Cia406, PositionRoundTripAndRejects) {
  const CanFrame frame = cia406::make_position(3, 0x80000001u);
  EXPECT_EQ(frame.id, 0x183u);
  EXPECT_EQ(frame.size, 4);
  std::uint32_t counts = 5;
  EXPECT_EQ(cia406::parse_position(frame, 4, counts), ParseResult::other_message);
  EXPECT_EQ(cia406::parse_position(resized(frame, 3), 3, counts), ParseResult::too_short);
  EXPECT_EQ(cia406::parse_position(resized(frame, 8), 3, counts), ParseResult::too_long);
  EXPECT_EQ(cia406::parse_position(resized(frame, 255), 3, counts), ParseResult::too_long);
  EXPECT_EQ(counts, 5u);
  ASSERT_EQ(cia406::parse_position(frame, 3, counts), ParseResult::ok);
  EXPECT_EQ(counts, 0x80000001u);
}

}  // namespace
}  // namespace godobject::test_canopen
