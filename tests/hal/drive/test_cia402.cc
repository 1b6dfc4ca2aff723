#include "hal/drive/cia402.h"

#include <gtest/gtest.h>

#include <limits>

namespace godobject::test_cia402 {
namespace {

using namespace cia402;

TEST(Cia402, DecodesStatesWhateverTheOtherBitsSay) {
  const std::pair<std::uint16_t, DriveState> states[] = {
      {0x00, DriveState::not_ready_to_switch_on}, {0x40, DriveState::switch_on_disabled},
      {0x21, DriveState::ready_to_switch_on},     {0x23, DriveState::switched_on},
      {0x27, DriveState::operation_enabled},      {0x07, DriveState::quick_stop_active},
      {0x0F, DriveState::fault_reaction_active},  {0x08, DriveState::fault}};
  for (const auto& [bits, state] : states) {
    EXPECT_EQ(decode_state(bits), state);
    EXPECT_EQ(decode_state(bits | 0xFF90), state);
    EXPECT_EQ(encode_state(state), bits);
  }
  // Bit 5 is ignored in the states with mask 4Fh.
  EXPECT_EQ(decode_state(0x60), DriveState::switch_on_disabled);
  EXPECT_EQ(decode_state(0x28), DriveState::fault);
  EXPECT_EQ(decode_state(0x01), DriveState::unknown);
}

// A recording of a real drive (fault reset and enable): 0218 0250 0231 0233.
TEST(Cia402, DecodesARealDrive) {
  EXPECT_EQ(decode_state(0x0218), DriveState::fault);
  EXPECT_EQ(decode_state(0x0250), DriveState::switch_on_disabled);
  EXPECT_EQ(decode_state(0x0231), DriveState::ready_to_switch_on);
  EXPECT_EQ(decode_state(0x0233), DriveState::switched_on);
}

TEST(Cia402, EnableSequence) {
  EXPECT_EQ(next_controlword(DriveState::switch_on_disabled, 0, false), 0x06);
  EXPECT_EQ(next_controlword(DriveState::ready_to_switch_on, 0x06, false), 0x07);
  EXPECT_EQ(next_controlword(DriveState::switched_on, 0x07, false), 0x0F);
  EXPECT_EQ(next_controlword(DriveState::operation_enabled, 0x0F, false), 0x0F);
  EXPECT_EQ(next_controlword(DriveState::quick_stop_active, 0x02, false), 0x00);
  EXPECT_EQ(next_controlword(DriveState::unknown, 0x0F, true), 0x00);
}

TEST(Cia402, FaultIsResetByRisingEdgesAndOnlyOnRequest) {
  EXPECT_EQ(next_controlword(DriveState::fault, 0x0F, false), 0x00);
  EXPECT_EQ(next_controlword(DriveState::fault, 0x0F, true), 0x80);
  EXPECT_EQ(next_controlword(DriveState::fault, 0x80, true), 0x00);
  EXPECT_EQ(next_controlword(DriveState::fault, 0x00, true), 0x80);
}

TEST(Cia402, TorqueIsScaledRoundedAndSaturated) {
  EXPECT_EQ(torque_to_per_mille(0.05, 0.1, 0.2), 500);
  EXPECT_EQ(torque_to_per_mille(-0.00016, 0.1, 0.2), -2);
  EXPECT_EQ(torque_to_per_mille(5, 0.1, 0.05), 500);
  EXPECT_EQ(torque_to_per_mille(-5, 0.1, 0.05), -500);
  EXPECT_EQ(torque_to_per_mille(1e9, 0.1, 1e9), 32767);
  EXPECT_EQ(torque_to_per_mille(-1e9, 0.1, 1e9), -32767);
  EXPECT_EQ(torque_to_per_mille(std::numeric_limits<double>::infinity(), 0.1, 0.05), 500);
  EXPECT_DOUBLE_EQ(torque_from_per_mille(-500, 0.1), -0.05);
}

TEST(Cia402, ImpossibleTorqueIsNoTorque) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(torque_to_per_mille(nan, 0.1, 0.05), 0);
  EXPECT_EQ(torque_to_per_mille(0.05, nan, 0.05), 0);
  EXPECT_EQ(torque_to_per_mille(0.05, 0.1, nan), 0);
  EXPECT_EQ(torque_to_per_mille(0.05, 0, 0.05), 0);
  EXPECT_EQ(torque_to_per_mille(0.05, 0.1, -1), 0);
}

TEST(Cia402, MessagesHaveTheirLayout) {
  const CanFrame command = make_command(5, {.controlword = 0x010F, .target_torque_per_mille = -2});
  EXPECT_EQ(command.id, 0x205u);
  EXPECT_EQ(command.size, 4);
  EXPECT_EQ(command.data[0], 0x0F);
  EXPECT_EQ(command.data[1], 0x01);
  EXPECT_EQ(command.data[2], 0xFE);
  EXPECT_EQ(command.data[3], 0xFF);
  const CanFrame status =
      make_status(5, {.statusword = 0x0237, .position_counts = -1, .actual_torque_per_mille = 0x1234});
  EXPECT_EQ(status.id, 0x185u);
  EXPECT_EQ(status.size, 8);
  EXPECT_EQ(status.data[5], 0xFF);
  EXPECT_EQ(status.data[6], 0x34);
  const CanFrame event = make_event(5, {.velocity_counts_per_s = 256, .mode = 10, .error_code = 0x8250});
  EXPECT_EQ(event.id, 0x285u);
  EXPECT_EQ(event.size, 7);
  EXPECT_EQ(event.data[1], 1);
  EXPECT_EQ(event.data[4], 10);
  EXPECT_EQ(event.data[6], 0x82);
}

TEST(Cia402, RoundTrips) {
  Command command;
  ASSERT_EQ(
      parse_command(make_command(5, {.controlword = 0x8F, .target_torque_per_mille = -999}), 5, command),
      ParseResult::ok);
  EXPECT_EQ(command.controlword, 0x8F);
  EXPECT_EQ(command.target_torque_per_mille, -999);
  Status status;
  const Status sent{.statusword = 0x1237, .position_counts = -2'000'000'000, .actual_torque_per_mille = -1};
  ASSERT_EQ(parse_status(make_status(5, sent), 5, status), ParseResult::ok);
  EXPECT_EQ(status.statusword, sent.statusword);
  EXPECT_EQ(status.position_counts, sent.position_counts);
  EXPECT_EQ(status.actual_torque_per_mille, sent.actual_torque_per_mille);
  Event event;
  ASSERT_EQ(
      parse_event(make_event(5, {.velocity_counts_per_s = -7, .mode = -1, .error_code = 0xFFFF}), 5, event),
      ParseResult::ok);
  EXPECT_EQ(event.velocity_counts_per_s, -7);
  EXPECT_EQ(event.mode, -1);
  EXPECT_EQ(event.error_code, 0xFFFF);
}

TEST(Cia402, WrongSizesAndIdentifiersAreRejected) {
  for (int size = 0; size <= 8; ++size) {
    const auto expected = [size](int right) {
      return size < right ? ParseResult::too_short : size > right ? ParseResult::too_long : ParseResult::ok;
    };
    CanFrame frame{.size = static_cast<std::uint8_t>(size)};
    Command command;
    Status status;
    Event event;
    frame.id = 0x205;
    EXPECT_EQ(parse_command(frame, 5, command), expected(4));
    EXPECT_EQ(parse_command(frame, 6, command), ParseResult::other_message);
    frame.id = 0x185;
    EXPECT_EQ(parse_status(frame, 5, status), expected(8));
    frame.id = 0x285;
    EXPECT_EQ(parse_event(frame, 5, event), expected(7));
    frame.remote = true;
    EXPECT_EQ(parse_event(frame, 5, event), ParseResult::other_message);
  }
}

}  // namespace
}  // namespace godobject::test_cia402
