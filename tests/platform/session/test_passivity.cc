// The margins of scenes: gains at the joints, the delay of the buses, the defaults, and the shipped scenes.
#include "platform/session/passivity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "platform/scene/toml.h"
#include "tests/support/desk_scene.h"

namespace godobject::test_passivity {
namespace {

using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Passivity of_scene(const SceneConfig& scene) {
  return passivity(scene, joints_at_start(scene, Motion(scene)));
}

SceneConfig parsed(const std::string& text) {
  const LoadResult loaded = parse_scene(text, "mine.toml");
  EXPECT_THAT(loaded.errors, IsEmpty());
  return *loaded.scene;
}

SceneConfig shipped(const std::string& name) {
  return *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/" + name + ".toml").scene;
}

TEST(Passivity, ADeviceOfDefaultsIsPassiveWithTheDefaultFeedback) {
  const SceneConfig scene = parsed(test::desk_scene("scale = 0.25\n"));
  const Passivity result = of_scene(scene);
  ASSERT_THAT(result.joints, SizeIs(3));
  for (const JointMargin& joint : result.joints) {
    EXPECT_DOUBLE_EQ(joint.axis.K, 125);
    EXPECT_EQ(joint.axis.B, 0);
    EXPECT_EQ(joint.axis.delay, 1);
    EXPECT_DOUBLE_EQ(joint.axis.needed(), 125 * 1.5e-3);
    EXPECT_GT(joint.axis.margin(), 0.8);
    EXPECT_TRUE(joint.stable_alone && joint.stable_held);
  }
  EXPECT_TRUE(result.passive());
  EXPECT_THAT(passivity_warnings(result), IsEmpty());
}

TEST(Passivity, ALightDeviceWithDampingInSoftwareIsNamedWithWhatToLower) {
  const Passivity result = of_scene(parsed(test::desk_scene(test::heavy_feedback, test::light_plant)));
  ASSERT_THAT(result.joints, SizeIs(3));
  EXPECT_NEAR(result.joints[0].axis.needed(), 2.5 + 125 * 1.5e-3, 1e-9);
  EXPECT_FALSE(result.joints[0].stable_alone);
  const std::vector<std::string> warnings = passivity_warnings(result);
  ASSERT_THAT(warnings, SizeIs(3));
  EXPECT_THAT(warnings, Each(HasSubstr("needs 2.69 N s/m of its own damping and has 0.01")));
  EXPECT_THAT(warnings, Each(HasSubstr("lower its stiffness to 5.3 % of its present value")));
  EXPECT_THAT(warnings, Each(HasSubstr("feedback damping alone: from 0.828 N s/m on")));
}

TEST(Passivity, WhatTheWarningSaysIsEnough) {
  const std::string plant = "damping = 0.5\n";
  for (const auto& [feedback, mended] :
       {std::pair<std::string, std::string>{"stiffness = 125\ndamping = 2.5\n",
                                            "stiffness = 125\ndamping = 0.31\n"},
        {"stiffness = 1000\ndamping = 1\n", "stiffness = 333\ndamping = 0\n"}}) {
    EXPECT_THAT(passivity_warnings(of_scene(parsed(test::desk_scene(feedback, plant)))), SizeIs(3));
    EXPECT_THAT(passivity_warnings(of_scene(parsed(test::desk_scene(mended, plant)))), IsEmpty());
  }
  EXPECT_THAT(
      passivity_warnings(of_scene(parsed(test::desk_scene("stiffness = 125\ndamping = 2.5\n", plant)))),
      Each(HasSubstr("lower the feedback's damping to 12.5 %")));
  EXPECT_THAT(
      passivity_warnings(of_scene(parsed(test::desk_scene("stiffness = 1000\ndamping = 1\n", plant)))),
      Each(HasSubstr("lower its stiffness to 33.3 %")));
}

TEST(Passivity, OnAHingeGainsCountByTheLever) {
  const SceneConfig scene = shipped("rigid");
  const Passivity result = of_scene(scene);
  ASSERT_THAT(result.joints, SizeIs(3));
  const KinematicTree tree(scene.device->rig->tree);
  const TreeConfiguration at = tree.at(joints_at_start(scene, Motion(scene)));
  for (std::size_t i = 0; i < 3; ++i) {  // force alone: K = k |dp/dq|^2
    const double lever_sq = at.jacobian(0).col(static_cast<Eigen::Index>(i)).tail<3>().squaredNorm();
    EXPECT_NEAR(result.joints[i].axis.K, 200 * lever_sq, 1e-9);
    EXPECT_NEAR(result.joints[i].axis.B, scene.bodies[0].feedback->g * lever_sq, 1e-9);
  }
}

TEST(Passivity, ADriveThatIsTheSensorAndAnswersEveryThirdSyncIsLater) {
  SceneConfig scene = parsed(test::desk_scene("scale = 0.25\n"));
  RigParams& rig = *scene.device->rig;
  rig.drives[1].status_every_nth_sync = 3;
  EXPECT_EQ(of_scene(scene).joints[1].axis.delay, 1);  // its joint has an encoder
  rig.encoders.erase(rig.encoders.begin() + 1);
  const Passivity result = of_scene(scene);
  EXPECT_EQ(result.joints[1].axis.delay, 3);
  EXPECT_DOUBLE_EQ(result.joints[1].axis.needed(), 125 * 3.5e-3);
}

TEST(Passivity, TheWorstDirectionOfJointsThatMoveTogether) {
  // two slides along the same line: each displays the other's spring as well
  SceneConfig scene = parsed(test::desk_scene("stiffness = 400\n"));
  std::vector<DeviceJoint>& joints = scene.device->rig->tree.joints;
  joints[1].axis_J = joints[0].axis_J;
  const Passivity result = of_scene(scene);
  for (const JointMargin& joint : result.joints) EXPECT_TRUE(joint.axis.passive());
  EXPECT_NEAR(result.worst_direction, 2 * 400 * 1.5e-3, 1e-9);
  EXPECT_THAT(passivity_warnings(result), testing::ElementsAre(HasSubstr("not together")));
  // both have a controller, for the sum of their needs; the third, along its own line, has none
  const std::vector<PassivityParams> controllers =
      passivity_controllers(scene, joints_at_start(scene, Motion(scene)));
  for (const int i : {0, 1}) {
    EXPECT_TRUE(controllers[static_cast<std::size_t>(i)].is_active()) << i;
    EXPECT_NEAR(controllers[static_cast<std::size_t>(i)].needed, 2 * 400 * 1.5e-3, 1e-9) << i;
  }
  EXPECT_FALSE(controllers[2].is_active());
  joints[1].axis_J = Vec3::UnitY();  // on their own lines none has
  for (const PassivityParams& controller :
       passivity_controllers(scene, joints_at_start(scene, Motion(scene))))
    EXPECT_FALSE(controller.is_active());
}

/// An arm of two links of 0.2 m whose handle is at their end.
SceneConfig planar_arm() {
  SceneConfig scene = parsed(test::desk_scene("stiffness = 1e4\n"));
  std::vector<DeviceJoint>& joints = scene.device->rig->tree.joints;
  joints[0].kind = joints[1].kind = DeviceJointKind::hinge;
  joints[0].axis_J = joints[1].axis_J = Vec3::UnitZ();
  joints[1].X_PJ.p = joints[2].X_PJ.p = Vec3(0.2, 0, 0);
  return scene;
}

TEST(Passivity, AHingeIsJudgedWhereItsLeverIsLongest) {
  SceneConfig scene = planar_arm();
  const JointVector folded = Vec3(0, 2.8, 0);
  EXPECT_TRUE(passivity(scene, folded).joints.front().axis.passive());
  const auto longest_sq = [](double elbow) { return 0.08 + 0.08 * std::cos(elbow); };
  const Passivity worst = worst_passivity(scene, folded);
  EXPECT_NEAR(worst.joints.front().axis.K, 1e4 * longest_sq(0), 0.01 * 1e4 * longest_sq(0));
  EXPECT_NEAR(std::remainder(worst.joints.front().q(1), 2 * 3.14159265), 0, 0.2);
  EXPECT_NEAR(worst.joints[1].axis.K, 1e4 * 0.04, 1e-6);  // does not depend on the pose
  EXPECT_FALSE(worst.joints.front().axis.passive());
  EXPECT_NEAR(passivity_controllers(scene, folded).front().stiffness, worst.joints.front().axis.K, 1e-9);
  EXPECT_THAT(passivity_warnings(worst).front(), HasSubstr("axis x is not passive at x "));
  EXPECT_THAT(passivity_table(worst), testing::Contains(HasSubstr("worst pose of x: x ")));

  // a stated range bounds it
  scene.device->rig->tree.joints[1].lower = 1.5;
  scene.device->rig->tree.joints[1].upper = 2.8;
  const Passivity bounded = worst_passivity(scene, folded);
  EXPECT_NEAR(bounded.joints.front().axis.K, 1e4 * longest_sq(1.5), 0.01 * 1e4 * longest_sq(1.5));
  EXPECT_LE(bounded.joints.front().axis.K, 1e4 * longest_sq(1.5) + 1e-6);
}

TEST(Passivity, SlidersWithoutAStatedRangeStayAtTheStart) {
  SceneConfig scene = parsed(test::desk_scene("stiffness = 400\n"));
  EXPECT_FALSE(worst_passivity(scene, JointVector::Zero(3)).ranges.vary());
  EXPECT_THAT(passivity_table(worst_passivity(scene, JointVector::Zero(3))).front(),
              HasSubstr("at the start"));
  // a slide that carries a hinge's handle away from it
  std::vector<DeviceJoint>& joints = scene.device->rig->tree.joints;
  joints[0].kind = DeviceJointKind::hinge;
  joints[0].axis_J = Vec3::UnitZ();
  joints[0].lower = -1;
  joints[0].upper = 1;
  joints[1].lower = 0.1;
  joints[1].upper = 0.3;
  const JointVector start = Vec3(0, 0.1, 0);
  EXPECT_NEAR(passivity(scene, start).joints.front().axis.K, 400 * 0.01, 1e-9);
  EXPECT_NEAR(worst_passivity(scene, start).joints.front().axis.K, 400 * 0.09, 1e-9);
}

TEST(Passivity, EndsOfARangeAreChecked) {
  const auto with_range = [](const std::string& range) {
    std::string text = test::desk_scene("scale = 0.25\n");
    const std::string name = "name = \"z\"\n";
    text.insert(text.find(name) + name.size(), range);
    return text;
  };
  const LoadResult loaded = parse_scene(with_range("lower = -0.1\nupper = 0.2\n"), "mine.toml");
  ASSERT_TRUE(loaded.scene);
  EXPECT_EQ(loaded.scene->device->rig->tree.joints[2].upper, 0.2);
  EXPECT_THAT(parse_scene(with_range("lower = -0.1\n"), "mine.toml").errors,
              testing::ElementsAre(HasSubstr("give both ends, lower and upper, or none")));
  EXPECT_THAT(parse_scene(with_range("lower = 0.1\nupper = 0.1\n"), "mine.toml").errors,
              testing::ElementsAre(HasSubstr("must be above lower")));
}

TEST(Passivity, ControllersActOnAxesWithoutMarginAlone) {
  const auto controllers = [](const std::string& feedback, const std::string& plant) {
    const SceneConfig scene = parsed(test::desk_scene(feedback, plant));
    return passivity_controllers(scene, joints_at_start(scene, Motion(scene)));
  };
  const auto are_active = [](const std::vector<PassivityParams>& all) {
    return std::ranges::count_if(all, &PassivityParams::is_active);
  };
  const std::vector<PassivityParams> light =
      controllers("stiffness = 125\ndamping = 2.5\n", "damping = 0.5\n");
  ASSERT_THAT(light, SizeIs(3));
  EXPECT_EQ(are_active(light), 3);
  EXPECT_NEAR(light[0].deficit(), 2.5 + 125 * 1.5e-3 - 0.5, 1e-9);
  EXPECT_DOUBLE_EQ(light[0].stiffness, 125);
  EXPECT_DOUBLE_EQ(light[0].resolution, 1e-6);
  EXPECT_EQ(light[0].delay, 1);
  EXPECT_EQ(are_active(controllers("scale = 0.25\n", "")), 0);
  EXPECT_EQ(are_active(controllers("stiffness = 125\ndamping = 2.5\n",
                                   "damping = 0.5\n[device.limits]\npassivity_control = false\n")),
            0);
}

TEST(Passivity, ScenesWithoutFeedbackOrDrivesHaveNone) {
  for (const char* name : {"non-haptic", "relative", "lego", "pendulum"})
    EXPECT_THAT(of_scene(shipped(name)).joints, IsEmpty()) << name;
  EXPECT_THAT(passivity_table(Passivity{}), IsEmpty());
}

/// Shipped scenes that are not passive alone are stable when held, and their file states the margin.
TEST(Passivity, ShippedScenesAreStableAndSayWhatTheirMarginIs) {
  for (const std::string name : {"rigid", "grasper", "grasp", "organ", "scissors-imposed"}) {
    const SceneConfig scene = shipped(name);
    std::stringstream file;
    file << std::ifstream(GODOBJECT_SOURCE_DIR "/sim/scenes/" + name + ".toml").rdbuf();
    const Passivity result = worst_passivity(scene, joints_at_start(scene, Motion(scene)));
    EXPECT_FALSE(result.joints.empty()) << name;
    for (const JointMargin& joint : result.joints) {
      EXPECT_TRUE(joint.stable_alone) << name << " " << joint.joint;
      EXPECT_TRUE(joint.stable_held) << name << " " << joint.joint;
      EXPECT_GT(joint.axis.margin() + scene.device->plant.hand_damping, 0) << name << " " << joint.joint;
      if (joint.axis.passive()) continue;
      std::array<char, 32> needed{};
      std::snprintf(needed.data(), needed.size(), "%.3g", joint.axis.needed());
      EXPECT_THAT(file.str(), HasSubstr(joint.joint + " needs " + needed.data())) << name;
    }
  }
}

}  // namespace
}  // namespace godobject::test_passivity
