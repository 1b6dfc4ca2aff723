// The device's own buttons, on the simulated bus: from the motion's columns through the node to the session.
#include <gtest/gtest.h>

#include <cmath>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_buttons {
namespace {

// Returns the demo's arm with an input node.
SceneConfig scene_with(const ButtonParams& button) {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  EXPECT_TRUE(loaded.scene);
  loaded.scene->device->rig->buttons = {button};
  return *loaded.scene;
}

std::unique_ptr<Session> session_of(const SceneConfig& scene, const std::string& motion) {
  const MotionResult read = Motion::parse(motion, "m.csv", scene);
  EXPECT_TRUE(read.motion);
  Session::Made made = make_session(scene, *read.motion, BusChoice::sim);
  EXPECT_TRUE(made.session && made.session->boot(5));
  return std::move(made.session);
}

TEST(Buttons, EveryPressGripsOrReleases) {
  for (const bool active_low : {false, true}) {
    SceneConfig scene = scene_with({.node_id = 40, .bit = 5, .active_low = active_low});
    scene.device->grab_radius = 1;
    const auto session = session_of(scene, "t,button\n0,0\n0.1,1\n0.2,0\n0.4,1\n0.5,0\n");
    CycleRecord record = session->at_start();
    while (record.cycle < 600) {
      session->cycle(record);
      ASSERT_EQ(record.rig_faults, RigFault::none);
      const bool changing = std::abs(record.t - 0.101) < 2e-3 || std::abs(record.t - 0.401) < 2e-3;
      const bool expected = record.t > 0.1 && record.t < 0.4;
      ASSERT_TRUE(changing || record.held.has_value() == expected) << record.t;
    }
  }
}

TEST(Buttons, TheClutchOfARelativeDevice) {
  SceneConfig scene = scene_with({.use = ButtonUse::clutch, .node_id = 40});
  scene.device->kind = DeviceKind::relative;
  const std::string body = scene.bodies.front().name;
  const auto session = session_of(scene, "t," + body + ".clutch\n0,1\n0.1,0\n0.3,1\n");
  CycleRecord before = session->at_start(), now = before;
  double moved_closed = 0;
  while (now.cycle < 500) {
    session->cycle(now);
    ASSERT_EQ(now.rig_faults, RigFault::none);
    const double moved = (now.bodies[0].target.X_WD.p - before.bodies[0].target.X_WD.p).norm();
    const bool open = now.t > 0.103 && now.t < 0.3;
    ASSERT_TRUE(!open || moved == 0) << now.t;
    moved_closed += moved;
    before = now;
  }
  EXPECT_GT(moved_closed, 1e-3);
}

}  // namespace
}  // namespace godobject::test_buttons
