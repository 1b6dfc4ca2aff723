// The default comparison of sensors raises no false fault: in no shipped scene, and in no fast motion with
// lost, late or missing answers.
#include <gtest/gtest.h>

#include "hal/rig/slip.h"
#include "platform/scene/toml.h"
#include "tests/support/faulty_rig.h"

namespace godobject::test_no_false_slip {
namespace {

class SlipOfShippedScene : public testing::TestWithParam<const char*> {};

TEST_P(SlipOfShippedScene, NoSensorsDisagree) {
  LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + GetParam());
  ASSERT_TRUE(loaded.scene) << loaded.errors.front();
  const SceneConfig& scene = *loaded.scene;
  for (const DriveParams& drive : scene.device->rig->drives) {
    const bool both = std::ranges::count(scene.device->rig->encoders, drive.joint, &EncoderParams::joint) > 0;
    EXPECT_EQ(allowed_slip(*scene.device->rig, drive) > 0, both) << drive.joint;
  }
  test::FaultyRig device(scene);
  device.F_hand_W = {};
  static_cast<void>(device.boot());
  ASSERT_EQ(device.rig.state(), RigState::armed) << device.rig.fault_text();
  EXPECT_FALSE(device.cycles_to_fault(static_cast<int>(scene.duration / 1e-3))) << device.rig.fault_text();
}

INSTANTIATE_TEST_SUITE_P(All, SlipOfShippedScene,
                         testing::Values("rigid.toml", "grasper.toml", "grasp.toml", "organ.toml",
                                         "scissors-imposed.toml"));

class SlipOfFastMotion : public testing::TestWithParam<const char*> {};

TEST_P(SlipOfFastMotion, NoSensorsDisagree) {
  SceneConfig scene = test::two_joints();
  for (CoordinateMotion& coordinate : scene.motion->joints) coordinate.frequency_hz = 6;  // 11 rad/s
  scene.device->rig->drives[0].status_every_nth_sync = 3;
  test::FaultyRig device(scene);
  ASSERT_TRUE(device.boot()) << device.rig.fault_text();
  device.F_hand_W = {};
  device.play(GetParam());
  device.cycles(4000);
  EXPECT_FALSE(any(device.rig.faults() & RigFault::sensors_disagree)) << device.rig.fault_text();
}

INSTANTIATE_TEST_SUITE_P(Each, SlipOfFastMotion,
                         testing::Values("restart", "drop bus=can0 value=0.1", "drop value=0.3",
                                         "delay value=0.002", "delay bus=can0 node=1 value=0.0025",
                                         "delay bus=can1 value=0.0025", "corrupt value=0.2",
                                         "drop bus=can0 node=2 duration=0.05", "drop bus=can1 duration=0.015",
                                         "nan bus=can0 node=2 duration=0.01"));

}  // namespace
}  // namespace godobject::test_no_false_slip
