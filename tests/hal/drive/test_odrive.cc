// CAN Simple: the bytes, and the enabling of a drive.
#include "hal/drive/odrive.h"

#include <gtest/gtest.h>

#include <limits>

namespace godobject::test_odrive {
namespace {

constexpr Nanoseconds ms = 1'000'000;
constexpr std::uint8_t node = 5;
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

TEST(Odrive, IdsAreThoseOfTheManual) {
  using odrive::Command;
  EXPECT_EQ(odrive::frame_id(node, Command::heartbeat), 0x0A1u);
  EXPECT_EQ(odrive::make_set_axis_state(node, 8).id, 0x0A7u);
  EXPECT_EQ(odrive::make_encoder_estimates(node, {}).id, 0x0A9u);
  EXPECT_EQ(odrive::make_torque_mode(node).id, 0x0ABu);
  EXPECT_EQ(odrive::make_input_torque(node, 0).id, 0x0AEu);
}

TEST(Odrive, BytesAreLittleEndian) {
  const CanFrame torque = odrive::make_input_torque(node, -0.5f);  // BF000000h
  EXPECT_EQ(torque.size, 4);
  EXPECT_EQ(torque.data[0], 0x00);
  EXPECT_EQ(torque.data[3], 0xBF);
  const CanFrame mode = odrive::make_torque_mode(node);
  EXPECT_EQ(mode.size, 8);
  EXPECT_EQ(mode.data[0], 1);
  EXPECT_EQ(mode.data[4], 1);
  EXPECT_EQ(odrive::make_set_axis_state(node, odrive::axis_closed_loop).data[0], 8);
  const CanFrame request = odrive::make_request(node, odrive::Command::encoder_estimates);
  EXPECT_TRUE(request.remote && is_valid(request));
}

TEST(Odrive, EstimatesComeBackAndNotANumberDoesNot) {
  odrive::EncoderEstimates out{.position_rev = 9, .velocity_rev_per_s = 9};
  EXPECT_EQ(odrive::parse_encoder_estimates(odrive::make_encoder_estimates(node, {1.25f, -2}), node, out),
            ParseResult::ok);
  EXPECT_EQ(out.position_rev, 1.25f);
  EXPECT_EQ(out.velocity_rev_per_s, -2.f);
  for (const odrive::EncoderEstimates& bad : {odrive::EncoderEstimates{nan, 0}, {0, nan}, {1 / 0.f, 0}})
    EXPECT_EQ(odrive::parse_encoder_estimates(odrive::make_encoder_estimates(node, bad), node, out),
              ParseResult::bad_value);
  EXPECT_EQ(out.position_rev, 1.25f);
}

TEST(Odrive, MessagesAreDescribedInWords) {
  const DriveText heartbeat = odrive::describe(
      odrive::make_heartbeat(node, {.error = odrive::error_watchdog, .axis_state = odrive::axis_idle}));
  EXPECT_EQ(heartbeat.node, node);
  EXPECT_EQ(heartbeat.name, "heartbeat");
  EXPECT_EQ(heartbeat.value, "idle, error 01000000h watchdog");
  const DriveText estimates = odrive::describe(odrive::make_encoder_estimates(node, {-0.25f, 2}));
  EXPECT_EQ(estimates.position_counts, -25000);
  EXPECT_EQ(estimates.value, "velocity +2.0000 rev/s");
  EXPECT_EQ(odrive::describe(odrive::make_encoder_estimates(node, {nan, 2})).position_counts, std::nullopt);
  EXPECT_EQ(odrive::describe(odrive::make_request(node, odrive::Command::encoder_estimates)).name,
            "estimates request");
  EXPECT_EQ(odrive::describe(odrive::make_input_torque(node, -0.5f)).value, "torque -0.5000 Nm");
  EXPECT_EQ(odrive::describe(odrive::make_torques(node, {.target_Nm = 1, .estimate_Nm = 0.5f})).value,
            "torque +0.5000 Nm, target +1.0000 Nm");
  EXPECT_EQ(odrive::describe(odrive::make_set_axis_state(node, 8)).value, "closed loop");
  EXPECT_EQ(odrive::describe(odrive::make_torque_mode(node)).value, "torque control");
  EXPECT_EQ(odrive::describe({.id = node << 5 | 0x1D, .size = 8}).name, "message 1Dh");
  EXPECT_EQ(
      odrive::describe({.id = odrive::frame_id(node, odrive::Command::set_input_torque), .size = 2}).value,
      "")
      << "too short";
  EXPECT_EQ(odrive::describe({.id = 0x7E1, .size = 8}).node, 0);
}

TEST(Odrive, OtherNodesRemoteAndExtendedFramesAreNotItsOwn) {
  odrive::Heartbeat out;
  CanFrame frame = odrive::make_heartbeat(node, {});
  EXPECT_EQ(odrive::parse_heartbeat(frame, node + 1, out), ParseResult::other_message);
  frame.size = 7;
  EXPECT_EQ(odrive::parse_heartbeat(frame, node, out), ParseResult::too_short);
  frame.extended = true;
  EXPECT_EQ(odrive::sender(frame), 0);
  EXPECT_EQ(odrive::sender(odrive::make_request(node, odrive::Command::heartbeat)), 0);
  EXPECT_EQ(odrive::sender(odrive::make_heartbeat(62, {})), 62);
  EXPECT_EQ(odrive::sender({.id = 0x7E1, .size = 8}), 0);  // node 63: not addressed yet
}

class OdriveLinkTest : public testing::Test {
 protected:
  DriveMessage heartbeat(std::uint8_t axis_state, std::uint32_t error = 0) {
    return link.decode(odrive::make_heartbeat(node, {.error = error, .axis_state = axis_state}), telemetry);
  }
  /// Returns the id of the frame sent towards `goal`; 0 if none.
  std::uint32_t command(DriveGoal goal, double torque_Nm = 0) {
    const DriveFrame out = link.command({.goal = goal, .torque_Nm = torque_Nm}, now);
    if (out.frame) link.sent(out, now);
    now += ms;
    return out.frame ? out.frame->id : 0u;
  }

  DriveParams params{.joint = "j", .node_id = node};
  OdriveLink link{params, 1e-3};
  DriveTelemetry telemetry;
  Nanoseconds now = ms;
};

TEST_F(OdriveLinkTest, ModeThenStateThenTorque) {
  EXPECT_EQ(command(DriveGoal::enable), 0u);  // no message was received from it
  EXPECT_TRUE(heartbeat(odrive::axis_idle).alive);
  EXPECT_EQ(telemetry.state, MotorState::off);
  EXPECT_EQ(command(DriveGoal::hold), 0x0AEu);  // feeds the watchdog
  EXPECT_EQ(command(DriveGoal::enable), 0x0ABu);
  EXPECT_EQ(command(DriveGoal::enable), 0x0A7u);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(command(DriveGoal::enable), 0x0AEu);
  heartbeat(odrive::axis_closed_loop);
  EXPECT_EQ(telemetry.state, MotorState::enabled);
  EXPECT_EQ(command(DriveGoal::enable), 0x0AEu);
  EXPECT_EQ(command(DriveGoal::hold, 0.1), 0x0AEu);
}

TEST_F(OdriveLinkTest, RepeatsARequestThatTheDriveIgnored) {
  heartbeat(odrive::axis_idle);
  command(DriveGoal::enable);
  command(DriveGoal::enable);
  now += 250 * ms;
  EXPECT_EQ(command(DriveGoal::enable), 0x0ABu);
  EXPECT_EQ(command(DriveGoal::enable), 0x0A7u);
}

TEST_F(OdriveLinkTest, ClosedLoopOfAnotherHostIsNotTrustedUntilTheModeIsSet) {
  heartbeat(odrive::axis_closed_loop);
  EXPECT_EQ(telemetry.state, MotorState::off);
  EXPECT_EQ(command(DriveGoal::enable), 0x0ABu);
  heartbeat(odrive::axis_closed_loop);
  EXPECT_EQ(telemetry.state, MotorState::enabled);
}

TEST_F(OdriveLinkTest, ErrorsAreClearedFirst) {
  heartbeat(odrive::axis_idle, odrive::error_watchdog);
  EXPECT_EQ(telemetry.state, MotorState::fault);
  EXPECT_EQ(telemetry.error_code, odrive::error_watchdog);
  EXPECT_EQ(command(DriveGoal::enable), 0x0B8u);
  EXPECT_EQ(command(DriveGoal::enable), 0x0AEu);
  heartbeat(odrive::axis_idle);
  EXPECT_EQ(command(DriveGoal::enable), 0x0ABu);
}

TEST_F(OdriveLinkTest, OffAndQuickStopMakeItIdle) {
  heartbeat(odrive::axis_closed_loop);
  for (const DriveGoal goal : {DriveGoal::off, DriveGoal::quick_stop}) {
    const DriveFrame out = link.command({.goal = goal}, now);
    ASSERT_TRUE(out.frame);
    EXPECT_EQ(out.frame->id, 0x0A7u);
    EXPECT_EQ(out.frame->data[0], odrive::axis_idle);
  }
  heartbeat(odrive::axis_idle);
  EXPECT_EQ(command(DriveGoal::quick_stop), 0u);
}

TEST_F(OdriveLinkTest, PositionsAreHundredThousandthsOfATurn) {
  const DriveMessage message = link.decode(odrive::make_encoder_estimates(node, {-0.25f, 2}), telemetry);
  EXPECT_TRUE(message.position);
  EXPECT_EQ(static_cast<std::int32_t>(telemetry.position_counts), -25000);
  EXPECT_DOUBLE_EQ(telemetry.velocity_counts_per_s, 2e5);
  EXPECT_EQ(link.decode(odrive::make_encoder_estimates(node, {1e9f, 0}), telemetry).result,
            ParseResult::bad_value);
  EXPECT_EQ(static_cast<std::int32_t>(telemetry.position_counts), -25000);
}

}  // namespace
}  // namespace godobject::test_odrive
