// A session with a device of several handles: each drives its own body and displays that body's feedback.
#include "platform/simulated/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "platform/scene/text/key.h"
#include "platform/scene/toml.h"

namespace godobject::test_session_handles {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string body(const std::string& name) {
  return "[[body]]\nname = \"" + name +
         "\"\nmass = 0.1\ninertia = [3e-4, 3e-4, 2e-4]\n"
         "[body.coupling]\nstiffness = 1000\nrotational_stiffness = 1\n[body.feedback]\nscale = 0.2\n";
}
std::string on_joint(const char* table, const std::string& joint, const char* bus, int node_id) {
  return std::string(table) + "\njoint = \"" + joint + "\"\nbus = \"" + bus +
         "\"\nnode_id = " + std::to_string(node_id) + "\ncounts_per_unit = 1000000\n";
}

/// Returns a shaft that slides, a blade that turns on it and is the first handle, and a body without a
/// handle.
SceneConfig shaft_and_blade() {
  std::string text = "[scene]\nname = \"test\"\n" + body("shaft") + body("free") + body("blade") +
                     "[[bus]]\nname = \"can0\"\n[[bus]]\nname = \"can1\"\n[device]\nname = \"d\"\n"
                     "[device.chain]\nbase_position = [0, 0, 0.1]\n"
                     "[[device.joint]]\nname = \"slide\"\nkind = \"slider\"\naxis = [0, 0, 1]\n"
                     "[[device.joint]]\nname = \"turn\"\nposition = [0, 0, 0.1]\naxis = [0, 1, 0]\n"
                     "[[device.handle]]\nbody = \"blade\"\njoint = \"turn\"\nposition = [0.05, 0, 0]\n"
                     "[[device.handle]]\nbody = \"shaft\"\njoint = \"slide\"\n"
                     "[device.plant]\nfriction = 0\nhand_stiffness = 1e5\nhand_damping = 100\n";
  int node_id = 1;
  for (const char* joint : {"slide", "turn"}) {
    text += on_joint("[[device.encoder]]", joint, "can0", node_id);
    text += on_joint("[[device.drive]]", joint, "can1", node_id++) +
            "torque_rated_Nm = 1\ntorque_max_Nm = 20\ntorque_rate_Nm_per_s = 1000\n";
  }
  const LoadResult result = parse_scene(text, "test.toml");
  EXPECT_THAT(result.errors, IsEmpty()) << text;
  return *result.scene;
}

/// Returns a motion of both joints: 5 cm and 0.5 rad, up and down.
Motion both_joints(const SceneConfig& scene) {
  std::string csv = "t,slide,turn\n";
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.02 * i;
    csv +=
        shortest(t) + "," + shortest(0.05 * std::sin(3 * t)) + "," + shortest(0.5 * std::sin(4 * t)) + "\n";
  }
  const MotionResult result = Motion::parse(csv, "m.csv", scene);
  EXPECT_THAT(result.errors, IsEmpty());
  return *result.motion;
}

TEST(SessionHandles, EveryHandleDrivesItsBodyAndTheOthersRest) {
  const SceneConfig scene = shaft_and_blade();
  const KinematicTree tree(scene.device->rig->tree);
  const Motion motion = both_joints(scene);
  const Session::Made made = make_session(scene, motion, BusChoice::sim);
  ASSERT_THAT(made.errors, IsEmpty());
  ASSERT_TRUE(made.session->boot(3)) << made.session->rig()->fault_text();
  CycleRecord record;
  for (int k = 0; k < 1000; ++k) {
    made.session->cycle(record);
    ASSERT_EQ(record.rig_faults, RigFault::none);
    const TreeConfiguration device = tree.at(motion.joints(record.t).q);
    // the hand of 1e5 N/m yields to the displayed force
    EXPECT_LT((record.bodies[0].target.X_WD.p - device.X_WH(1).p).norm(), 3e-4) << k;
    EXPECT_LT((record.bodies[2].target.X_WD.p - device.X_WH(0).p).norm(), 3e-4) << k;
    EXPECT_EQ(record.bodies[1].target.X_WD.p, Vec3::Zero()) << k;
  }
  EXPECT_TRUE(made.session->truth()->reachable());
}

TEST(SessionHandles, TheFeedbackOfEveryBodyReachesTheMotors) {
  const SceneConfig scene = shaft_and_blade();
  const KinematicTree tree(scene.device->rig->tree);
  const Motion motion = both_joints(scene);
  const Session::Made made = make_session(scene, motion, BusChoice::sim);
  ASSERT_THAT(made.errors, IsEmpty());
  ASSERT_TRUE(made.session->boot(3));
  CycleRecord record;
  double largest_of_shaft = 0, largest_of_blade = 0;
  for (int k = 0; k < 1000; ++k) {
    made.session->cycle(record);
    const Wrench shaft = made.session->engine().feedback(0), blade = made.session->engine().feedback(2);
    const double slide = shaft.f.z() + blade.f.z();
    const Vec3 lever =
        tree.at(motion.joints(record.t).q).X_WH(0).p - Vec3(0, 0, 0.2 + motion.joints(record.t).q[0]);
    const double turn = blade.tau.y() + lever.cross(blade.f).y();
    EXPECT_NEAR(made.session->rig()->commanded_torque_Nm(0), slide, 1e-3) << k;
    EXPECT_NEAR(made.session->rig()->commanded_torque_Nm(1), turn, 1e-3) << k;
    largest_of_shaft = std::max(largest_of_shaft, std::abs(shaft.f.z()));
    largest_of_blade = std::max(largest_of_blade, std::abs(blade.f.z()));
  }
  EXPECT_GT(largest_of_shaft, 0.1);  // the checks above are not vacuous
  EXPECT_GT(largest_of_blade, 0.1);
}

TEST(SessionHandles, AMotionOfPosesIsRefusedWhereTheDeviceCannotBeInverted) {
  const SceneConfig scene = shaft_and_blade();
  EXPECT_THAT(make_session(scene, Motion(scene), BusChoice::sim).errors,
              ElementsAre(AllOf(HasSubstr("a column for each joint ('slide', 'turn')"),
                                HasSubstr("one handle and six joints"), HasSubstr("--bus direct"))));
  EXPECT_THAT(make_session(scene, Motion(scene), BusChoice::direct).errors, IsEmpty());
}

TEST(SessionHandles, AHandleOfABodyThatIsNotThereIsRefused) {
  SceneConfig scene = shaft_and_blade();
  scene.device->rig->tree.handles[1].body = "jaw";
  EXPECT_THAT(make_session(scene, both_joints(scene), BusChoice::sim).errors,
              ElementsAre(HasSubstr("handle of body 'jaw': the scene has no coupled body of this name")));
}

}  // namespace
}  // namespace godobject::test_session_handles
