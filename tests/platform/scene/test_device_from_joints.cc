// The device made from a tool's joints.
#include "platform/scene/joint/joints.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <regex>

#include "hal/joint/kinematic_tree.h"
#include "platform/motion/motion.h"
#include "platform/scene/toml.h"
#include "tests/support/program.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_device_from_joints {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string encoder =
    "[[bus]]\nname = \"can0\"\n[device]\nname = \"d\"\n"
    "[[device.encoder]]\njoint = \"p\"\nbus = \"can0\"\nnode_id = 1\ncounts_per_turn = 4096\n";

TEST(DeviceFromJoints, WhatHasNoEncoderOrDoesNotMoveIsRefused) {
  const std::string coupling = "[body.coupling]\nstiffness = 1\nrotational_stiffness = 1\n";
  EXPECT_THAT(parse_tool(body("a", coupling) + joint("p", "ball", "world", "a") + encoder).errors,
              testing::Contains(HasSubstr("joint 'p' is a ball joint, which encoders cannot measure")));
  EXPECT_THAT(
      parse_tool(body("a") + body("b", coupling) + joint("p", "hinge", "world", "a") + encoder).errors,
      testing::Contains(HasSubstr("connect the world to body 'b'")));
}

TEST(DeviceFromJoints, AMisspeltBodyOfAJointIsOneErrorInEveryShippedScene) {
  int num_names = 0;
  for (const auto& file : std::filesystem::directory_iterator(GODOBJECT_SOURCE_DIR "/sim/scenes")) {
    if (file.path().extension() != ".toml") continue;
    const std::string scene = read_file(file.path());
    const std::regex name_of_body("\n(child|parent) = \"[a-z_]*");
    for (std::sregex_iterator at(scene.begin(), scene.end(), name_of_body), end; at != end;
         ++at, ++num_names) {
      std::string misspelt = scene;
      misspelt.insert(static_cast<std::size_t>(at->position() + at->length()), "qq");
      EXPECT_THAT(parse_scene(misspelt, file.path().string()).errors,
                  ElementsAre(AllOf(HasSubstr(at->str(1)), HasSubstr("which is not a body"))))
          << at->str().substr(1) << "qq";
    }
  }
  EXPECT_GT(num_names, 20);
}

TEST(DeviceFromJoints, NoCoordinateIsCalledLikeTheBase) {
  const std::string coupling = "[body.coupling]\nstiffness = 1\nrotational_stiffness = 1\n";
  EXPECT_THAT(
      parse_tool(body("a", coupling) + joint("base", "hinge", "world", "a") + encoder).errors,
      testing::Contains(HasSubstr("coordinate 'base' of joint 'base' is the name of the device's base")));
}

TEST(DeviceFromJoints, HandlesAndMotionsReferToItsJoints) {
  const std::string coupling = "[body.coupling]\nstiffness = 1\nrotational_stiffness = 1\n";
  const std::string tool = body("a", coupling) + joint("p", "hinge", "world", "a") + encoder;
  const LoadResult loaded =
      parse_tool(tool + "[motion]\n[[motion.joint]]\ncoordinate = \"p\"\namplitude = 0.5\n");
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_EQ(loaded.scene->motion->joints.front().amplitude, 0.5);
  EXPECT_EQ(loaded.scene->device->rig->tree.handles.front().joint, "p");
  EXPECT_THAT(parse_tool(tool + "[device.chain]\nhandle_position = [0, 0, 1]\n").errors,
              ElementsAre(HasSubstr("handle_position in [device.chain] has no meaning")));
  EXPECT_THAT(parse_tool(tool + "[motion]\n[[motion.joint]]\ncoordinate = \"q\"\n").errors,
              ElementsAre(HasSubstr("admissible is \"p\"")));
  EXPECT_THAT(
      parse_tool(tool + "[motion]\namplitude = [1, 0, 0]\n[[motion.joint]]\ncoordinate = \"p\"\n").errors,
      ElementsAre(HasSubstr("remove 'amplitude'")));
  EXPECT_THAT(
      parse_tool(tool +
                 "[motion]\n[[motion.joint]]\ncoordinate = \"p\"\n[[motion.joint]]\ncoordinate = \"p\"\n")
          .errors,
      ElementsAre(HasSubstr("has an earlier table")));
}

const std::string moved_p = "[motion]\n[[motion.joint]]\ncoordinate = \"p\"\namplitude = 0.5\n";
const std::string coupled = "[body.coupling]\nstiffness = 1\nrotational_stiffness = 1\n";

/// Without encoders and buses the joints of the tool are still the device's, or those that it lists.
TEST(DeviceFromJoints, AMotionMovesJointsThatNothingMeasures) {
  const std::string tool = body("a", coupled) + joint("p", "hinge", "world", "a");
  const std::string device = "[device]\nname = \"d\"\n", own = "[[device.joint]]\nname = \"p\"\n";
  for (const std::string& described : {device, device + own, device + own + "[device.chain]\n"}) {
    const LoadResult loaded = parse_tool(tool + described + moved_p);
    ASSERT_THAT(loaded.errors, IsEmpty()) << described;
    EXPECT_FALSE(loaded.scene->device->rig) << "there is nothing on buses";
    ASSERT_NE(device_tree(*loaded.scene), nullptr);
    EXPECT_EQ(device_tree(*loaded.scene)->handles.front().body, "a");
    const Motion motion(*loaded.scene);
    ASSERT_TRUE(motion.has_joints());
    const double quarter_s = 0.25;
    const Target target = motion.target(0, quarter_s);
    EXPECT_NEAR(2 * std::acos(std::abs(target.X_WD.q.w())), std::abs(motion.joints(quarter_s).q[0]), 1e-9);
    const LoadResult again = parse_scene(effective_config_toml(*loaded.scene), "again");
    ASSERT_THAT(again.errors, IsEmpty()) << described;
    EXPECT_EQ(effective_config_toml(*again.scene), effective_config_toml(*loaded.scene));
  }
}

TEST(DeviceFromJoints, UnmeasuredJointsAreRefusedBesideAnotherHand) {
  const std::string tool = body("a", coupled) + joint("p", "hinge", "world", "a") +
                           "[device]\nname = \"d\"\nkind = \"non-haptic\"\n";
  const std::string mouse = "[device.spacemouse]\nbody = \"a\"\n";
  EXPECT_THAT(parse_tool(tool + mouse).errors, IsEmpty()) << "the tool's joints are not the mouse's";
  EXPECT_THAT(parse_tool(tool + mouse + "[[device.joint]]\nname = \"p\"\n").errors,
              testing::Contains(HasSubstr("are not measured")));
  EXPECT_THAT(parse_tool(tool + "[[bus]]\nname = \"can0\"\n[[device.joint]]\nname = \"p\"\n").errors,
              testing::Contains(HasSubstr("joint 'p' is not measured")));
  EXPECT_THAT(parse_tool(tool + "[device.supervision]\nlost_after = 0.1\n").errors,
              testing::Contains(HasSubstr("need a [[bus]]")));
}

/// Returns a random tree of these kinds with random frames, every body coupled.
SceneConfig random_tool(std::mt19937& random, const std::vector<JointKind>& kinds) {
  std::uniform_real_distribution<double> number(-1, 1);
  const auto vector = [&] { return Vec3(number(random), number(random), number(random)); };
  const auto pose = [&] {
    return Pose{vector(), Quat(number(random), number(random), number(random), number(random)).normalized()};
  };
  SceneConfig scene;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    BodyConfig link;
    link.name = "body" + std::to_string(i);
    link.coupling = SpringParams{};
    scene.bodies.push_back(link);
    JointConfig j;
    j.name = "joint" + std::to_string(i);
    j.kind = kinds[i];
    const std::size_t parent = std::uniform_int_distribution<std::size_t>(0, i)(random);
    j.parent = i == 0 || parent == 0 ? world_name : "body" + std::to_string(parent - 1);
    if (j.kind == JointKind::fixed) j.parent = "body0";
    j.child = link.name;
    j.X_BP = pose();
    j.X_BC = pose();
    for (std::size_t c = 0; c < num_coordinates(j.kind); ++c)
      j.coordinates.push_back(j.name + std::to_string(c));
    scene.joints.push_back(j);
  }
  return scene;
}

/// At any coordinates of the device each joint of the instrument is closed and at the same coordinates.
TEST(DeviceFromJoints, HandlesAreWhereTheBodiesWouldBe) {
  std::mt19937 random(5);
  const std::vector<JointKind> kinds{JointKind::universal, JointKind::cylindrical, JointKind::hinge,
                                     JointKind::fixed,     JointKind::slider,      JointKind::universal};
  std::uniform_real_distribution<double> angle(-1.5, 1.5);
  for (int trial = 0; trial < 200; ++trial) {
    SceneConfig scene = random_tool(random, kinds);
    const DeviceTree device = device_from_joints(scene);
    ASSERT_THAT(device.errors, IsEmpty());
    ASSERT_EQ(device.tree.joints.size(), 8u);
    ASSERT_EQ(device.tree.handles.size(), scene.bodies.size());
    JointVector q(8);
    for (Eigen::Index i = 0; i < q.size(); ++i) q[i] = angle(random);
    const TreeConfiguration at = KinematicTree(device.tree).at(q);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      ASSERT_EQ(device.tree.handles[i].body, scene.bodies[i].name);
      scene.bodies[i].X_WB = at.X_WH(i);
    }
    Eigen::Index next = 0;
    for (const JointConfig& j : scene.joints) {
      const JointGap gap = gap_at_start(scene.bodies, j);
      EXPECT_LT(gap.m, 1e-13) << j.name;
      EXPECT_LT(gap.rad, 1e-7) << j.name;  // of an angle by its cosine
      const JointCoordinates is = coordinates_at_start(scene.bodies, j);
      for (std::size_t c = 0; c < j.coordinates.size(); ++c, ++next) {
        EXPECT_EQ(device.tree.joints[static_cast<std::size_t>(next)].name, j.coordinates[c]);
        EXPECT_NEAR(is[static_cast<Eigen::Index>(c)], q[next], 1e-12) << j.name;
      }
    }
  }
}

}  // namespace
}  // namespace godobject::test::test_device_from_joints
