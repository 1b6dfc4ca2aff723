#include "hal/drive/drive.h"

#include "hal/drive/cia402.h"

#include <gtest/gtest.h>

namespace godobject::test_drive {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr double cycle_s = 1e-3;

DriveParams params() {
  DriveParams p;
  p.node_id = 7;
  p.torque_rated_Nm = 0.2;
  p.torque_max_Nm = 0.1;
  p.torque_rate_Nm_per_s = 10;  // 0.01 N m per cycle
  p.joint_per_motor_rad = 0.05;
  p.sign = -1;
  p.calibration.counts_per_unit = 1000;
  return p;
}

CanFrame status(cia402::DriveState state, std::int32_t position_counts = 0,
                std::int16_t torque_per_mille = 0) {
  return cia402::make_status(7, {.statusword = static_cast<std::uint16_t>(cia402::encode_state(state) |
                                                                          cia402::status_follows_command),
                                 .position_counts = position_counts,
                                 .actual_torque_per_mille = torque_per_mille});
}

/// Returns params() for drives, which refer to them.
const DriveParams& lasting_params() {
  static const DriveParams p = params();
  return p;
}

/// p: must outlive the drive.
Drive enabled_drive(const DriveParams& p = lasting_params()) {
  Drive drive(p, cycle_s, 3 * ms);
  EXPECT_EQ(drive.on_frame(status(cia402::DriveState::operation_enabled), 0).result, ParseResult::ok);
  return drive;
}

cia402::Command decoded(const DriveCommand& command) {
  cia402::Command out;
  EXPECT_EQ(cia402::parse_command(*command.out.frame, 7, out), ParseResult::ok);
  return out;
}

TEST(Drive, TransmissionAndSignKeepThePower) {
  Drive drive = enabled_drive();
  const DriveCommand command = drive.plan(0.1, DriveGoal::hold, 0);
  EXPECT_DOUBLE_EQ(command.order.torque_Nm, -0.1 * 0.05);
  EXPECT_EQ(decoded(command).target_torque_per_mille, -25);
  EXPECT_EQ(decoded(command).controlword, cia402::enable_operation);
  EXPECT_FALSE(command.torque_limited || command.rate_limited);
}

TEST(Drive, SlewsFromWhatWasSent) {
  Drive drive = enabled_drive();
  DriveCommand command = drive.plan(-1.5, DriveGoal::hold, 0);  // 0.075 N m at the motor
  EXPECT_DOUBLE_EQ(command.order.torque_Nm, 0.01);
  EXPECT_TRUE(command.rate_limited);
  EXPECT_FALSE(command.torque_limited);
  command = drive.plan(-1.5, DriveGoal::hold, 0);  // the first one was never sent
  EXPECT_DOUBLE_EQ(command.order.torque_Nm, 0.01);
  drive.sent(command, 0);
  EXPECT_DOUBLE_EQ(drive.plan(-1.5, DriveGoal::hold, 0).order.torque_Nm, 0.02);
}

TEST(Drive, SaturatesAtTorqueMax) {
  DriveParams p = params();
  p.torque_rate_Nm_per_s = 1e6;
  Drive drive = enabled_drive(p);
  const DriveCommand command = drive.plan(-1e9, DriveGoal::hold, 0);
  EXPECT_DOUBLE_EQ(command.order.torque_Nm, 0.1);
  EXPECT_EQ(decoded(command).target_torque_per_mille, 500);
  EXPECT_TRUE(command.torque_limited);
}

TEST(Drive, SendsNoTorqueUnlessEnabledAndStartsFromZeroAfterwards) {
  Drive drive = enabled_drive();
  for (int k = 0; k < 5; ++k) drive.sent(drive.plan(-1.5, DriveGoal::hold, 0), 0);
  EXPECT_DOUBLE_EQ(drive.commanded_torque_Nm(), 0.05);
  ASSERT_EQ(drive.on_frame(status(cia402::DriveState::fault), ms).result, ParseResult::ok);
  const DriveCommand command = drive.plan(-1.5, DriveGoal::hold, 0);
  EXPECT_EQ(decoded(command).target_torque_per_mille, 0);
  EXPECT_EQ(decoded(command).controlword, cia402::disable_voltage);
  drive.sent(command, 0);
  ASSERT_EQ(drive.on_frame(status(cia402::DriveState::operation_enabled), 2 * ms).result, ParseResult::ok);
  EXPECT_DOUBLE_EQ(drive.plan(-1.5, DriveGoal::hold, 0).order.torque_Nm, 0.01);
}

TEST(Drive, FeedbackInJointAndMotorUnits) {
  Drive drive(lasting_params(), cycle_s, 3 * ms);
  EXPECT_TRUE(drive.silent(0));
  ASSERT_EQ(drive.on_frame(status(cia402::DriveState::switched_on, -250, 100), ms).result, ParseResult::ok);
  const DriveFeedback feedback = drive.feedback(2 * ms);
  EXPECT_DOUBLE_EQ(feedback.position.q, -0.25);
  EXPECT_TRUE(feedback.position.valid);
  EXPECT_EQ(feedback.position.age(2 * ms), ms);
  EXPECT_DOUBLE_EQ(feedback.torque_Nm, 0.02);
  EXPECT_EQ(feedback.state, MotorState::off);
}

TEST(Drive, SilenceAllowsForTheSyncsItLeavesOut) {
  DriveParams p = params();
  p.status_every_nth_sync = 5;
  Drive drive(p, cycle_s, 3 * ms);
  ASSERT_EQ(drive.on_frame(status(cia402::DriveState::switched_on), 0).result, ParseResult::ok);
  EXPECT_FALSE(drive.silent(7 * ms));
  EXPECT_TRUE(drive.silent(7 * ms + 1));
  EXPECT_FALSE(drive.feedback(7 * ms + 1).position.valid);
}

TEST(Drive, RefusesAnotherNodesStatus) {
  Drive drive(lasting_params(), cycle_s, 3 * ms);
  EXPECT_EQ(drive.on_frame(cia402::make_status(8, {}), 0).result, ParseResult::other_message);
  EXPECT_TRUE(drive.silent(0));
}

}  // namespace
}  // namespace godobject::test_drive
