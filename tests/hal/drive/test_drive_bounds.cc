// Messages of a drive that are no new position, and bounds of its limits.
#include <gtest/gtest.h>

#include <algorithm>

#include "hal/drive/cia402.h"
#include "hal/drive/drive.h"
#include "hal/drive/moteus.h"
#include "hal/drive/odrive.h"

namespace godobject::test_drive_bounds {
namespace {

constexpr Nanoseconds ms = 1'000'000;

CanFrame status(std::int32_t counts) {
  return cia402::make_status(7, {.statusword = cia402::encode_state(cia402::DriveState::operation_enabled),
                                 .position_counts = counts});
}

class DriveBounds : public testing::Test {
 protected:
  const DriveParams params{.joint = "yaw", .node_id = 7, .calibration = {.counts_per_unit = 1000}};
  Drive drive{params, 1e-3, 3 * ms};
};

TEST_F(DriveBounds, EventWithoutAPositionIsNoSample) {
  EXPECT_EQ(drive.on_frame(status(20), ms).result, ParseResult::ok);
  EXPECT_EQ(drive.on_frame(cia402::make_event(7, {.mode = 10}), 10 * ms).result, ParseResult::ok);
  EXPECT_TRUE(drive.silent(10 * ms));
  EXPECT_EQ(drive.position().counters().accepted, 1u);
}

TEST_F(DriveBounds, SecondAnswerToARequestIsNoSample) {
  EXPECT_EQ(drive.on_frame(status(20), ms).result, ParseResult::ok);
  EXPECT_EQ(drive.on_frame(status(25), 2 * ms, true).result, ParseResult::ok);
  EXPECT_EQ(drive.position().counters().accepted, 1u);
  EXPECT_DOUBLE_EQ(drive.feedback(2 * ms).position.q, 0.02);
}

TEST(DriveFeedback, VelocityIsThatOfTheJoint) {
  const DriveParams params{
      .joint = "yaw", .node_id = 7, .calibration = {.counts_per_unit = 1000, .sign = -1}};
  Drive drive(params, 1e-3, 3 * ms);
  EXPECT_EQ(drive.on_frame(cia402::make_event(7, {.velocity_counts_per_s = 300}), ms).result,
            ParseResult::ok);
  EXPECT_DOUBLE_EQ(drive.feedback(ms).velocity, -0.3);
}

TEST(DriveFeedback, SilentAfterTheSyncsThatItMaySkip) {
  const DriveParams params{
      .joint = "yaw", .node_id = 7, .status_every_nth_sync = 4, .calibration = {.counts_per_unit = 1000}};
  Drive drive(params, 1e-3, 3 * ms);
  EXPECT_TRUE(drive.silent(0)) << "no position yet";
  EXPECT_EQ(drive.on_frame(status(20), 0).result, ParseResult::ok);
  EXPECT_FALSE(drive.silent(6 * ms));
  EXPECT_TRUE(drive.silent(6 * ms + 1));
}

// A moteus drive receives its command with the next request.
TEST(DriveFeedback, RequestHasTheLastOrder) {
  const DriveParams params{.joint = "yaw", .protocol = DriveProtocol::moteus, .node_id = 7};
  Drive drive(params, 1e-3, 3 * ms);
  moteus::Reply reply;
  reply.mode = moteus::mode_position;
  EXPECT_EQ(drive.on_frame(moteus::make_reply(7, reply), 0).result, ParseResult::ok);
  const std::optional<CanFrame> before = drive.request();
  drive.sent(drive.plan(1, DriveGoal::hold, 0), 0);
  EXPECT_EQ(drive.commanded_torque_Nm(), 0) << "the request has not been sent";
  const std::optional<CanFrame> after = drive.request();
  drive.request_sent();
  EXPECT_GT(drive.commanded_torque_Nm(), 0);
  ASSERT_TRUE(before && after);
  EXPECT_FALSE(std::ranges::equal(before->bytes(), after->bytes()));
}

// An ODrive is enabled by two frames in turn; one that was not sent is planned again.
TEST(DriveFeedback, SentFrameIsNotPlannedAgain) {
  const DriveParams params{.joint = "yaw", .protocol = DriveProtocol::odrive, .node_id = 7};
  Drive drive(params, 1e-3, 3 * ms);
  const CanFrame idle = odrive::make_heartbeat(7, {.axis_state = odrive::axis_idle});
  EXPECT_EQ(drive.on_frame(idle, 0).result, ParseResult::ok);
  static_cast<void>(drive.plan(0, DriveGoal::enable, ms));
  const DriveCommand mode = drive.plan(0, DriveGoal::enable, ms);
  EXPECT_EQ(mode.out.frame->id, odrive::frame_id(7, odrive::Command::set_controller_mode));
  drive.sent(mode, ms);
  const DriveCommand state = drive.plan(0, DriveGoal::enable, 2 * ms);
  EXPECT_EQ(state.out.frame->id, odrive::frame_id(7, odrive::Command::set_axis_state));
}

}  // namespace
}  // namespace godobject::test_drive_bounds
