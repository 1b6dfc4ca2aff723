// Scenes with joints: contents of their files, and errors of invalid trees.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <sstream>

#include "platform/scene/joint/joints.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_articulated_scene {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns the errors of a scene with bodies "a", "b", "c" and these joints.
std::vector<std::string> errors_of(const std::string& joints) {
  return parse_tool(body("a") + body("b") + body("c") + joints).errors;
}

TEST(ArticulatedScene, KindsHaveTheirCoordinatesAndDefaultNames) {
  const LoadResult loaded = parse_tool(
      body("a") + body("b") + body("c") + body("d") + body("e") + body("f") +
      joint("one", "hinge", "world", "a") + joint("two", "universal", "world", "b") +
      joint("three", "cylindrical", "world", "c") + joint("four", "ball", "world", "d") +
      joint("five", "slider", "world", "e", "coordinates = [\"reach\"]\n") + joint("six", "fixed", "e", "f"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  const std::vector<JointConfig>& joints = loaded.scene->joints;
  EXPECT_THAT(joints[0].coordinates, ElementsAre("one"));
  EXPECT_THAT(joints[1].coordinates, ElementsAre("two_x", "two_y"));
  EXPECT_THAT(joints[2].coordinates, ElementsAre("three_turn", "three_slide"));
  EXPECT_THAT(joints[3].coordinates, IsEmpty());
  EXPECT_THAT(joints[4].coordinates, ElementsAre("reach"));
  EXPECT_EQ(joints[5].kind, JointKind::fixed);
}

TEST(ArticulatedScene, AxisTurnsBothFrames) {
  const LoadResult loaded =
      parse_tool(body("a") + joint("j", "hinge", "world", "a", "axis = [0.6, -0.8, 0.0]\n"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  const JointConfig& j = loaded.scene->joints.front();
  EXPECT_LT((j.X_BP.q * Vec3::UnitZ() - Vec3(0.6, -0.8, 0)).norm(), 1e-15);
  EXPECT_EQ(j.X_BP.q.coeffs(), j.X_BC.q.coeffs());
}

TEST(ArticulatedScene, ParentsComeFirstAndTheRestStaysInOrder) {
  const LoadResult loaded =
      parse_tool(body("hand") + body("brick") + body("arm") + body("ball") +
                 joint("wrist", "hinge", "arm", "hand") + joint("base", "hinge", "world", "arm"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  std::vector<std::string> names;
  for (const BodyConfig& b : loaded.scene->bodies) names.push_back(b.name);
  EXPECT_THAT(names, ElementsAre("brick", "arm", "hand", "ball"));
}

TEST(ArticulatedScene, WhatIsNoTreeIsRefusedByTheNamesOfItsJoints) {
  const std::string world_a = joint("p", "hinge", "world", "a"), a_b = joint("q", "hinge", "a", "b");
  EXPECT_THAT(errors_of(world_a + a_b + joint("r", "ball", "b", "c") + joint("s", "ball", "c", "world")),
              ElementsAre(HasSubstr("'child' is the world, which cannot be a child: swap parent and child")));
  EXPECT_THAT(errors_of(a_b + joint("r", "hinge", "a", "b")),
              ElementsAre(AllOf(HasSubstr("joints 'q' and 'r' both join 'a' and 'b'"),
                                HasSubstr("constrains some motion twice"))));
  EXPECT_THAT(errors_of(a_b + joint("r", "hinge", "b", "a")),
              ElementsAre(HasSubstr("constrains some motion twice")));
  EXPECT_THAT(errors_of(a_b + joint("r", "hinge", "c", "b")),
              ElementsAre(AllOf(HasSubstr("body 'b' is the child of joints 'q' and 'r'"),
                                HasSubstr("swap parent and child of one of them"))));
  EXPECT_THAT(errors_of(joint("q", "hinge", "a", "a")),
              ElementsAre(HasSubstr("joint 'q' joins body 'a' to itself")));
}

TEST(ArticulatedScene, UnknownBodiesAndTakenNamesAreRefused) {
  EXPECT_THAT(
      errors_of(joint("q", "hinge", "arm", "a")),
      ElementsAre(AllOf(HasSubstr("a.toml:18:"), HasSubstr("'parent' is \"arm\", which is not a body"),
                        HasSubstr("\"world\", \"a\", \"b\", \"c\""))));
  EXPECT_THAT(errors_of(joint("q", "hinge", "world", "d")),
              ElementsAre(HasSubstr("'child' is \"d\", which is not a body")));
  EXPECT_THAT(errors_of("[[joint]]\nname = \"q\"\n"), ElementsAre(HasSubstr("required key 'child'")));
  EXPECT_THAT(
      errors_of(joint("q", "hinge", "world", "a") + joint("q", "hinge", "a", "b", "coordinates = [\"r\"]\n")),
      ElementsAre(HasSubstr("is the name of an earlier joint")));
  EXPECT_THAT(
      errors_of(joint("q", "hinge", "world", "a") + joint("r", "hinge", "a", "b", "coordinates = [\"q\"]\n")),
      ElementsAre(HasSubstr("has 'q', which is the name of another coordinate: choose another")));
  EXPECT_THAT(parse_tool(body("world")).errors, ElementsAre(HasSubstr("the name of the ground in joints")));
}

TEST(ArticulatedScene, KeysThatDoNotFitTheKindAreRefused) {
  const auto errors = [](const std::string& kind, const std::string& more) {
    return errors_of(joint("q", kind, "world", "a", more));
  };
  EXPECT_THAT(errors("hinge", "coordinates = [\"r\", \"s\"]\n"),
              ElementsAre(HasSubstr("'coordinates' are 2: a joint of this kind has 1")));
  EXPECT_THAT(errors("hinge", "coordinates = [\"r s\"]\n"), ElementsAre(HasSubstr("letters, digits")));
  EXPECT_THAT(errors("hinge", "coordinates = \"r\"\n"),
              ElementsAre(HasSubstr("must be an array of strings")));
  EXPECT_THAT(errors("ball", "imposed = true\n"), testing::Contains(HasSubstr("'imposed' has no meaning")));
  EXPECT_THAT(errors("hinge", "imposed = 1\n"),
              ElementsAre(HasSubstr("must be true or false, not an integer")));
  EXPECT_THAT(errors("universal", "axis = [1, 0, 0]\n"),
              ElementsAre(HasSubstr("'axis' has no meaning for this kind of joint")));
  EXPECT_THAT(errors("hinge", "axis = [1, 1, 0]\n"), ElementsAre(HasSubstr("'axis' must have length 1")));
  EXPECT_THAT(errors("hinge", "axis = [1, 0, 0]\nchild_orientation_wxyz = [1, 0, 0, 0]\n"),
              ElementsAre(HasSubstr("both give the axis")));
  EXPECT_THAT(errors("hing", ""), ElementsAre(HasSubstr("nearest is \"hinge\"")));
}

TEST(ArticulatedScene, StopsAreOfOneCoordinateEach) {
  const std::string spring = "stiffness = 1\nwidth = 0.01\n";
  const LoadResult loaded =
      parse_tool(body("a") + joint("j", "cylindrical", "world", "a") +
                 "[[joint.stop]]\ncoordinate = \"j_turn\"\nlower = -1\nupper = 2\n" + spring +
                 "[[joint.stop]]\ncoordinate = \"j_slide\"\nupper = 5\n" + spring);
  ASSERT_THAT(loaded.errors, IsEmpty());
  ASSERT_EQ(loaded.scene->joints[0].stops.size(), 2u);
  EXPECT_EQ(loaded.scene->joints[0].stops[1].params.upper, 5);
  EXPECT_EQ(loaded.scene->joints[0].stops[1].params.lower, -std::numeric_limits<double>::infinity());

  const auto errors = [&](const std::string& kind, const std::string& stop) {
    return errors_of(joint("j", kind, "world", "a") + "[[joint.stop]]\n" + spring + stop);
  };
  EXPECT_THAT(errors("hinge", "lower = -4\nupper = 30\n"), IsEmpty());  // turns are counted
  EXPECT_THAT(errors("hinge", "lower = 1\nupper = 0.5\n"), ElementsAre(HasSubstr("must be above lower")));
  EXPECT_THAT(errors("hinge", ""), ElementsAre(HasSubstr("the stop has no end")));
  EXPECT_THAT(errors("universal", "lower = 0\n"), ElementsAre(HasSubstr("required key 'coordinate'")));
  EXPECT_THAT(errors("slider", "lower = 0\n[[joint.stop]]\nupper = 1\n" + spring),
              ElementsAre(HasSubstr("has an earlier stop")));
}

TEST(ArticulatedScene, JointsApartAtTheStartAreAdvisedAgainst) {
  const auto warnings = [](const std::string& pose, const std::string& kind) {
    return parse_tool(body("a", pose) + joint("j", kind, "world", "a")).warnings;
  };
  EXPECT_THAT(
      warnings("position = [0, 0.01, 0]\n", "ball"),
      ElementsAre(AllOf(HasSubstr("a.toml:8:"), HasSubstr("joint 'j' is apart by 0.01 m and 0 rad"))));
  EXPECT_THAT(warnings("orientation_wxyz = [0, 1, 0, 0]\n", "hinge"),
              ElementsAre(HasSubstr("0 m and 3.14 rad")));
  EXPECT_THAT(warnings("position = [0, 0, 0.3]\n", "cylindrical"), IsEmpty());
  EXPECT_THAT(warnings("position = [0, 0, 0.3]\n", "slider"), IsEmpty());
  EXPECT_THAT(warnings("orientation_wxyz = [0, 0, 0, 1]\n", "slider"),
              ElementsAre(HasSubstr("0 m and 3.14 rad")));
}

/// Joints of every kind, with bodies anywhere: the run begins with the joints closed, at their coordinates.
TEST(ArticulatedScene, JointsApartAtTheStartAreBroughtTogether) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto numbers = [&](int n, double size, bool unit) {
    std::vector<double> x(static_cast<std::size_t>(n));
    double sum = 0;
    for (double& a : x) {
      a = size * normal(random);
      sum += a * a;
    }
    std::ostringstream text;
    text.precision(17);
    for (std::size_t i = 0; i < x.size(); ++i)
      text << (i == 0 ? "[" : ", ") << (unit ? x[i] / std::sqrt(sum) : x[i]);
    return text.str() + "]\n";
  };
  const auto anywhere = [&](const std::string& prefix) {
    return prefix + "position = " + numbers(3, 0.3, false) + prefix +
           "orientation_wxyz = " + numbers(4, 1, true);
  };
  for (int draw = 0; draw < 60; ++draw) {
    const std::vector<std::string> kinds = joint_kind_names();
    const auto kind = [&](int i) { return kinds[static_cast<std::size_t>(draw + i) % kinds.size()]; };
    const LoadResult loaded =
        parse_tool(body("c", anywhere("")) + body("b", anywhere("")) + body("a", anywhere("")) +
                   joint("p", kind(0), "world", "a", anywhere("parent_") + anywhere("child_")) +
                   joint("q", kind(1), "a", "b", anywhere("parent_") + anywhere("child_")) +
                   joint("r", kind(3), "b", "c", anywhere("parent_") + anywhere("child_")));
    ASSERT_THAT(loaded.errors, IsEmpty());
    EXPECT_THAT(loaded.warnings,
                testing::Each(AllOf(HasSubstr("is apart by"), HasSubstr("the run starts with body"))));
    EXPECT_THAT(loaded.warnings.size(), testing::Ge(1u));
    for (const JointConfig& j : loaded.scene->joints) {
      const JointGap gap = gap_at_start(loaded.scene->bodies, j);
      EXPECT_LT(gap.m, 1e-12) << j.name;
      EXPECT_LT(gap.rad, 1e-7) << j.name;
    }
    EXPECT_THAT(parse_scene(effective_config_toml(*loaded.scene), "again").warnings, IsEmpty());
  }
}

/// A closed joint stays as it is, also below an open one: a chain moves as a whole.
TEST(ArticulatedScene, BodiesBelowAJointThatIsApartMoveWithIt) {
  const LoadResult loaded = parse_tool(
      body("a", "position = [0.1, 0, 0]\n") + body("b", "position = [0.3, 0, 0]\n") +
      joint("p", "ball", "world", "a") + joint("q", "ball", "a", "b", "parent_position = [0.2, 0, 0]\n"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_THAT(loaded.warnings, ElementsAre(HasSubstr("joint 'p' is apart by 0.1 m")));
  EXPECT_LT((loaded.scene->bodies[0].X_WB.p - Vec3(0, 0, 0)).norm(), 1e-15);
  EXPECT_LT((loaded.scene->bodies[1].X_WB.p - Vec3(0.2, 0, 0)).norm(), 1e-15);
}

TEST(ArticulatedScene, PrescribedJointsNeedADeviceThatMeasuresThem) {
  const std::string tool = body("a", "[body.coupling]\nstiffness = 1\nrotational_stiffness = 1\n") +
                           body("b") + joint("p", "hinge", "world", "a") +
                           joint("q", "hinge", "a", "b", "imposed = true\n");
  EXPECT_THAT(parse_tool(tool).errors, ElementsAre(HasSubstr("'q' is imposed and requires a [device]")));
  const std::string other_device =
      "[[bus]]\nname = \"can0\"\n[device]\nname = \"d\"\n[[device.joint]]\nname = \"p\"\n"
      "[[device.encoder]]\njoint = \"p\"\nbus = \"can0\"\nnode_id = 1\ncounts_per_turn = 4096\n";
  EXPECT_THAT(parse_tool(tool + other_device).errors,
              ElementsAre(HasSubstr("'q' is imposed, but the device has no joint 'q': it has \"p\"")));
}

}  // namespace
}  // namespace godobject::test::test_articulated_scene
