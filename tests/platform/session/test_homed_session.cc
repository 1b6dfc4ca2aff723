// Incremental sensors on a simulated rig: unknown counts at each power-on, and a hand that homes the device.
#include <gtest/gtest.h>

#include "platform/trace/rig_replay.h"
#include "tests/support/faulted_run.h"

namespace godobject::test_homed_session {
namespace {

using test::FaultedRun;
using test::FaultyRig;

constexpr double home_rad[] = {0.4, -0.3};  // of turret and elbow; their motion begins at 0

/// Makes the sensors of both joints incremental; the home button is input 2 of the node of the stop.
SceneConfig incremental(SceneConfig scene, std::uint64_t seed = 1) {
  RigParams& rig = *scene.device->rig;
  for (std::size_t i = 0; i < rig.tree.joints.size(); ++i) {
    Calibration& sensor = rig.encoders.empty() ? rig.drives[i].calibration : rig.encoders[i].calibration;
    sensor.offset_counts = 0;
    sensor.home = home_rad[i];
    sensor.incremental = true;
  }
  rig.buttons.push_back({.use = ButtonUse::home, .bus = 0, .node_id = 3, .bit = 1});
  scene.wire.seed = seed;
  return scene;
}

// Friction of the joints against the stiffness of the hand that holds them at home.
constexpr double misplaced_rad = 1e-3 / 20;

/// Expects the coordinates of the last step within a count of the truth.
void expect_right_pose(const FaultedRun& run) {
  const RigParams& rig = *run.session->scene().device->rig;
  for (std::size_t i = 0; i < rig.tree.joints.size(); ++i) {
    const double count_rad = 1 / sensor_of(rig, rig.tree.joints[i].name)->counts_per_unit;
    EXPECT_NEAR(run.record().device_q[i], run.device().joints().q[static_cast<Eigen::Index>(i)],
                count_rad + misplaced_rad)
        << i;
  }
}

bool is_armed(const FaultedRun& run) { return run.is(RigState::armed); }

TEST(HomedSession, EveryPowerOnIsHomed) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    FaultedRun run(incremental(test::two_joints(), seed));
    run.start();
    ASSERT_TRUE(run.reaches([&] { return run.rig_state() == RigState::homing; }));
    const double raw = run.session->rig()->encoder(0).sample(run.session->bus_time_ns()).q;
    EXPECT_GT(std::abs(raw - home_rad[0]), 0.1) << "the test needs another seed";
    ASSERT_TRUE(run.reaches([&] { return is_armed(run); }));
    for (int i = 0; i < 8; ++i) {
      run.cycles(100);
      expect_right_pose(run);
    }
    EXPECT_TRUE(is_armed(run));
    EXPECT_EQ(run.broken, "");
  }
}

TEST(HomedSession, DrivesOfEveryProtocolAreHomed) {
  for (const auto& [protocol, watchdog] : {std::pair(DriveProtocol::cia402, DriveWatchdog::host),
                                           std::pair(DriveProtocol::odrive, DriveWatchdog::drive),
                                           std::pair(DriveProtocol::moteus, DriveWatchdog::host)}) {
    const bool is_cia402 = protocol == DriveProtocol::cia402;
    SceneConfig scene = is_cia402 ? test::two_joints() : test::two_joints(protocol, watchdog);
    scene.device->rig->encoders.clear();
    FaultedRun run(incremental(scene));
    run.start();
    ASSERT_TRUE(run.reaches([&] { return is_armed(run); })) << run.session->rig()->fault_text();
    run.cycles(700);
    expect_right_pose(run);
    EXPECT_TRUE(is_armed(run)) << run.session->rig()->fault_text();
    EXPECT_EQ(run.broken, "");
  }
}

TEST(HomedSession, IsNeverArmedWithoutAPress) {
  SceneConfig scene = incremental(test::two_joints());
  scene.device->plant.hand_homes = false;
  FaultedRun run(scene);
  run.start();
  run.cycles(12'000);
  EXPECT_EQ(run.rig_state(), RigState::homing) << "also after the limits for booting";
  EXPECT_EQ(run.session->phase(), RunPhase::booting);
  EXPECT_EQ(run.motor_torque_Nm(), 0);
  run.apply("press bus=can0 node=3 value=2 duration=0.1");
  EXPECT_TRUE(run.reaches([&] { return is_armed(run); }, 300));
  EXPECT_EQ(run.broken, "");
}

TEST(HomedSession, APowerCycleIsHomedAgain) {
  FaultedRun run(incremental(test::two_joints()));
  run.start();
  ASSERT_TRUE(run.reaches([&] { return is_armed(run); }));
  ASSERT_TRUE(run.reaches([&] { return run.motor_torque_Nm() > 0; }));
  run.apply("reboot-node bus=can0 node=1 duration=0.02");
  ASSERT_TRUE(run.reaches([&] { return run.is(RigState::fault); }, 30));
  EXPECT_TRUE(any(run.session->rig()->faults() & RigFault::node_restarted));
  run.cycles(FaultedRun::ramp_cycles);
  EXPECT_EQ(run.motor_torque_Nm(), 0);
  run.cycles(300);
  EXPECT_FALSE(run.session->rig()->encoder(0).has_zero());
  EXPECT_TRUE(run.session->rig()->encoder(1).has_zero()) << "of the node that stayed up, until the next boot";
  run.apply("stop");
  ASSERT_TRUE(run.reaches([&] { return run.is(RigState::ended); }));
  run.apply("restart");
  run.apply("start");
  ASSERT_TRUE(run.reaches([&] { return run.rig_state() == RigState::homing; }));
  run.apply("press bus=can0 node=3 value=2 duration=0.05");
  run.cycles(60);
  EXPECT_EQ(run.session->rig()->refused_presses().count, 1u) << "the hand is on its way to the home pose";
  EXPECT_EQ(run.rig_state(), RigState::homing);
  ASSERT_TRUE(run.reaches([&] { return is_armed(run); }));
  run.cycles(700);
  expect_right_pose(run);
  EXPECT_TRUE(is_armed(run));
  EXPECT_EQ(run.broken, "");
}

// The rig gets the recorded frames, those of the button among them.
TEST(HomedSession, AReplayRepeatsTheHoming) {
  FaultedRun run(incremental(test::two_joints()));
  std::vector<LinkEvent> events;
  run.session->record_rig({.push =
                               [](void* context, const LinkEvent& event) noexcept GODOBJECT_NONBLOCKING {
                                 static_cast<std::vector<LinkEvent>*>(context)->push_back(event);
                                 return true;
                               },
                           .context = &events});
  run.start();
  ASSERT_TRUE(run.reaches([&] { return is_armed(run); }));
  RigReplay replay(run.session->scene(), std::vector<double>(2, 0.0));
  std::size_t num_added = 0;
  for (int i = 0; i < 300; ++i) {
    run.cycles(1);
    replay.add(num_added, std::span(events).subspan(num_added));
    num_added = events.size();
    ASSERT_EQ(replay.step(run.record()), "") << i;
  }
  EXPECT_GT(std::ranges::count(events, RigState::homing, &LinkEvent::rig_state), 100);
}

TEST(HomedSession, AStopWhileHomingEndsTheRun) {
  SceneConfig scene = incremental(test::two_joints());
  scene.device->plant.hand_homes = false;
  FaultedRun run(scene);
  run.start();
  ASSERT_TRUE(run.reaches([&] { return run.rig_state() == RigState::homing; }));
  run.apply("press bus=can0 node=3 duration=0.1");
  ASSERT_TRUE(run.reaches([&] { return run.is(RigState::ended); }));
  EXPECT_EQ(run.session->rig()->faults(), RigFault::quick_stop);
}

}  // namespace
}  // namespace godobject::test_homed_session
