// CSV, CSP, homing, quick stop and fault reset of CiA 402: codecs and state logic.
#include <gtest/gtest.h>

#include "hal/drive/cia402_homing.h"
#include "hal/drive/cia402_link.h"

namespace godobject::test_cia402_modes {
namespace {

using namespace cia402;

constexpr Nanoseconds ms = 1'000'000;
constexpr std::uint16_t enabled = encode_state(DriveState::operation_enabled);

std::uint16_t status(HomingState homing) {
  return static_cast<std::uint16_t>(enabled | encode_homing(homing));
}

TEST(Cia402Modes, SupportedModesAreBits) {
  EXPECT_TRUE(supports(0x200, OperationMode::cyclic_synchronous_torque));
  EXPECT_TRUE(supports(0x100, OperationMode::cyclic_synchronous_velocity));
  EXPECT_TRUE(supports(0x80, OperationMode::cyclic_synchronous_position));
  EXPECT_TRUE(supports(0x20, OperationMode::homing));
  EXPECT_FALSE(supports(0x1FF, OperationMode::cyclic_synchronous_torque));
  EXPECT_FALSE(supports(0xFFFFFFFF, OperationMode::none));
}

TEST(Cia402Modes, CommandsOfEachKind) {
  const CanFrame position =
      make_motion_command(5, {.kind = CommandKind::position, .controlword = 0x0F, .target = -2});
  EXPECT_EQ(position.id, 0x305u);
  EXPECT_EQ(position.size, 6);
  EXPECT_EQ(position.data[0], 0x0F);
  EXPECT_EQ(position.data[2], 0xFE);
  EXPECT_EQ(position.data[5], 0xFF);
  EXPECT_EQ(make_motion_command(5, {.kind = CommandKind::velocity}).id, 0x405u);

  MotionCommand out;
  ASSERT_EQ(parse_motion_command(position, 5, out), ParseResult::ok);
  EXPECT_TRUE(out.kind == CommandKind::position && out.target == -2 && out.controlword == 0x0F);
  EXPECT_EQ(parse_motion_command(position, 6, out), ParseResult::other_message);
  CanFrame cut = position;
  cut.size = 5;
  EXPECT_EQ(parse_motion_command(cut, 5, out), ParseResult::too_short);
  EXPECT_EQ(mode_of(CommandKind::position), OperationMode::cyclic_synchronous_position);
}

TEST(Cia402Modes, FaultResetIsAnEdge) {
  EXPECT_EQ(fault_reset_controlword(0x0F), fault_reset_bit);
  EXPECT_EQ(fault_reset_controlword(fault_reset_bit), 0);
}

TEST(Cia402Homing, StatesAreThreeBits) {
  using S = HomingState;
  const std::pair<std::uint16_t, S> table[] = {{0x0000, S::in_progress},      {0x0400, S::not_running},
                                               {0x1000, S::attained},         {0x1400, S::complete},
                                               {0x2000, S::failed_in_motion}, {0x2400, S::failed}};
  for (const auto& [bits, state] : table) {
    EXPECT_EQ(decode_homing(bits | enabled), state);
    EXPECT_EQ(encode_homing(state), bits);
  }
}

TEST(Cia402Homing, EnablesStartsAndWaits) {
  Homing homing(100 * ms);
  EXPECT_EQ(homing.step(encode_state(DriveState::switch_on_disabled), 0), shutdown);
  EXPECT_EQ(homing.step(encode_state(DriveState::ready_to_switch_on), ms), switch_on);
  EXPECT_EQ(homing.step(encode_state(DriveState::switched_on), 2 * ms), enable_operation);
  EXPECT_EQ(homing.step(status(HomingState::not_running), 3 * ms), 0x1F);
  EXPECT_EQ(homing.step(status(HomingState::in_progress), 4 * ms), 0x1F);
  EXPECT_EQ(homing.step(status(HomingState::attained), 5 * ms), 0x1F);
  EXPECT_FALSE(homing.finished());
  EXPECT_EQ(homing.step(status(HomingState::complete), 6 * ms), enable_operation);
  EXPECT_EQ(homing.result(), Homing::Result::complete);
}

TEST(Cia402Homing, TheOutcomeOfAnEarlierOneDoesNotCount) {
  Homing homing(100 * ms);
  homing.step(status(HomingState::complete), 0);
  homing.step(status(HomingState::complete), ms);
  homing.step(status(HomingState::complete), 2 * ms);
  EXPECT_FALSE(homing.finished());
  homing.step(status(HomingState::in_progress), 3 * ms);
  homing.step(status(HomingState::failed), 4 * ms);
  EXPECT_EQ(homing.result(), Homing::Result::failed);
}

TEST(Cia402Homing, ADriveThatWasDoneAtOnceIsDone) {
  Homing homing(100 * ms);
  for (int k = 0; k < 20; ++k) homing.step(status(HomingState::complete), k * ms);
  EXPECT_EQ(homing.result(), Homing::Result::complete);
}

TEST(Cia402Homing, GivesUpInTimeAndWhenTheDriveDoes) {
  Homing slow(10 * ms);
  for (int k = 0; k < 12; ++k) slow.step(status(HomingState::in_progress), k * ms);
  EXPECT_EQ(slow.result(), Homing::Result::timed_out);
  Homing broken(100 * ms);
  for (int k = 0; k < 4; ++k) broken.step(status(HomingState::in_progress), k * ms);
  EXPECT_EQ(broken.step(encode_state(DriveState::fault), 5 * ms), disable_voltage);
  EXPECT_EQ(broken.result(), Homing::Result::failed);
}

class Cia402LinkTest : public testing::Test {
 protected:
  MotorState state(std::uint16_t statusword) {
    const DriveMessage message = link.decode(make_status(7, {.statusword = statusword}), telemetry);
    EXPECT_EQ(message.result, ParseResult::ok);
    return telemetry.state;
  }
  std::uint16_t controlword(DriveGoal goal, Nanoseconds now = 0) {
    Command command;
    const DriveFrame out = link.command({.goal = goal}, now);
    link.sent(out, now);
    EXPECT_EQ(parse_command(*out.frame, 7, command), ParseResult::ok);
    return command.controlword;
  }

  const DriveParams params{.joint = "j", .node_id = 7};
  Cia402Link link{params, 1e-3};
  DriveTelemetry telemetry;
};

TEST_F(Cia402LinkTest, EnabledMeansThatItFollowsTheCommand) {
  EXPECT_EQ(state(enabled), MotorState::off);
  EXPECT_EQ(controlword(DriveGoal::hold), enable_operation);  // it may still come
  EXPECT_EQ(state(enabled | status_follows_command), MotorState::enabled);
}

TEST_F(Cia402LinkTest, ADriveInAnotherModeIsNotEnabled) {
  static_cast<void>(link.decode(make_event(7, {.velocity_counts_per_s = -5, .mode = 8}), telemetry));
  EXPECT_EQ(telemetry.velocity_counts_per_s, -5);
  EXPECT_EQ(state(enabled | status_follows_command), MotorState::off);
  static_cast<void>(link.decode(make_event(7, {.mode = 10}), telemetry));
  EXPECT_EQ(state(enabled | status_follows_command), MotorState::enabled);
}

TEST_F(Cia402LinkTest, ControlwordsOfTheGoals) {
  EXPECT_EQ(state(encode_state(DriveState::fault)), MotorState::fault);
  EXPECT_EQ(controlword(DriveGoal::hold), disable_voltage);
  for (const Nanoseconds t : {0, 1, 20, 49})
    EXPECT_EQ(controlword(DriveGoal::enable, t * ms), fault_reset_bit);
  for (const Nanoseconds t : {50, 51, 99}) EXPECT_EQ(controlword(DriveGoal::enable, t * ms), disable_voltage);
  EXPECT_EQ(controlword(DriveGoal::enable, 100 * ms), fault_reset_bit);
  EXPECT_EQ(state(encode_state(DriveState::switch_on_disabled)), MotorState::off);
  EXPECT_EQ(controlword(DriveGoal::enable, 101 * ms), shutdown);
  EXPECT_EQ(controlword(DriveGoal::quick_stop), quick_stop);
  EXPECT_EQ(controlword(DriveGoal::off), disable_voltage);
}

}  // namespace
}  // namespace godobject::test_cia402_modes
