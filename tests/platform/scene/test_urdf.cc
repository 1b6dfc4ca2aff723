// Import of robot descriptions: merged links, frames, limits, shapes, errors by name.
#if __has_include(<tinyxml2.h>)  // otherwise the program has no import

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "hal/base/format.h"
#include "platform/scene/joint/joints.h"
#include "platform/scene/toml.h"
#include "platform/scene/urdf/urdf.h"
#include "platform/simulated/session.h"
#include "tests/support/mesh_files.h"
#include "tests/support/program.h"
#include "tests/support/share.h"

namespace godobject::test::test_urdf {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

constexpr double pi = std::numbers::pi;

struct Imported {
  std::string toml;
  std::vector<std::string> errors, warnings;
  LoadResult loaded{};

  const SceneConfig& scene() const { return loaded.scene.value(); }
  const BodyConfig& body(const std::string& name) const {
    return scene().bodies.at(body_named(scene(), name).value());
  }
  const JointConfig& joint(const std::string& name) const {
    return *std::ranges::find(scene().joints, name, &JointConfig::name);
  }
};

Imported imported(const std::string& xml, const std::string& file = "a.urdf",
                  const std::string& folder = ".") {
  Diagnostics log(file);
  Imported result;
  const std::optional<UrdfRobot> robot = read_urdf(xml, log);
  if (robot) {
    const std::vector<UrdfGroup> groups = groups_of(*robot, log);
    if (log.ok()) result.toml = scene_of_urdf(*robot, groups, folder, log);
  }
  result.errors = log.errors();
  result.warnings = log.warnings();
  if (log.ok()) result.loaded = parse_scene(result.toml, folder + "/a.toml");
  return result;
}

/// Imports a robot of which the scene must have neither errors nor warnings.
Imported accepted(const std::string& elements) {
  Imported result = imported("<robot name=\"r\">" + elements + "</robot>");
  EXPECT_THAT(result.errors, IsEmpty());
  EXPECT_THAT(result.loaded.errors, IsEmpty()) << result.toml;
  EXPECT_THAT(result.loaded.warnings, IsEmpty()) << result.toml;
  return result;
}

std::string triple(const Vec3& x) { return shortest(x.x()) + " " + shortest(x.y()) + " " + shortest(x.z()); }
std::string inertial(double mass, const Vec3& com, const std::string& rpy, const Vec3& moments) {
  return "<inertial><origin xyz=\"" + triple(com) + "\" rpy=\"" + rpy + "\"/><mass value=\"" +
         shortest(mass) + "\"/><inertia ixx=\"" + shortest(moments.x()) + "\" iyy=\"" +
         shortest(moments.y()) + "\" izz=\"" + shortest(moments.z()) + "\"/></inertial>";
}
std::string link(const std::string& name, const std::string& content) {
  return "<link name=\"" + name + "\">" + content + "</link>\n";
}
std::string heavy(const std::string& name, const std::string& more = "") {
  return link(name, inertial(1, Vec3::Zero(), "0 0 0", Vec3(0.02, 0.02, 0.02)) + more);
}
std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& more = "") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
         "\"/><child link=\"" + child + "\"/>" + more + "</joint>\n";
}
std::string collision(const std::string& shape, const std::string& origin = "") {
  return "<collision>" + origin + "<geometry>" + shape + "</geometry></collision>";
}

// ---- inertia --------------------------------------------------------------------------------------

/// Two links of 2 kg and 1 kg, the second turned by a right angle, with centres 0.3 m, 0.1 m apart.
TEST(UrdfImport, FixedJointsAreMergedByTheClosedForm) {
  const Imported robot = accepted(
      link("world", "") + link("a", inertial(2, Vec3::Zero(), "0 0 0", Vec3(0.02, 0.03, 0.04))) +
      link("b", inertial(1, Vec3(0.1, 0, 0), "0 0 0", Vec3(0.001, 0.002, 0.0025)) +
                    collision("<sphere radius=\"0.05\"/>", "<origin xyz=\"0.2 0 0\"/>")) +
      link("frame", "") + joint("hinge", "continuous", "world", "a") +
      joint("weld", "fixed", "a", "b", "<origin xyz=\"0.3 0 0\" rpy=\"0 0 " + shortest(pi / 2) + "\"/>") +
      joint("tip", "fixed", "b", "frame"));
  ASSERT_THAT(robot.scene().bodies, SizeIs(1));
  const BodyConfig& body = robot.body("a");
  EXPECT_DOUBLE_EQ(body.mass, 3);
  const Vec3 c(0.1, 0.1 / 3, 0);
  EXPECT_LT((body.X_WB.p - c).norm(), 1e-15);
  const double reduced = 2.0 / 3;  // m_1 m_2 / (m_1 + m_2)
  Mat3 I = Mat3::Zero();
  I.diagonal() = Vec3(0.022 + reduced * 0.01, 0.031 + reduced * 0.09, 0.0425 + reduced * 0.1);
  I(0, 1) = I(1, 0) = -reduced * 0.03;
  EXPECT_LT((body.inertia - I).cwiseAbs().maxCoeff(), 1e-15) << body.inertia;
  ASSERT_THAT(body.shapes, SizeIs(1));
  EXPECT_LT((body.shapes.front().X.p - (Vec3(0.3, 0.2, 0) - c)).norm(), 1e-15);
  EXPECT_THAT(robot.toml, AllOf(HasSubstr("# with link b, by joint weld"), HasSubstr("# with link frame")));
}

TEST(UrdfImport, TurnedPrincipalAxesGiveTheFullTensor) {
  const Imported robot =
      accepted(link("base", "") +
               link("a", inertial(1, Vec3(0.1, 0.2, 0.3), "0 0 " + shortest(pi / 4), Vec3(0.1, 0.2, 0.25))) +
               joint("hinge", "continuous", "base", "a"));
  Mat3 I = Mat3::Zero();
  I.diagonal() = Vec3(0.15, 0.15, 0.25);
  I(0, 1) = I(1, 0) = -0.05;
  EXPECT_LT((robot.body("a").inertia - I).cwiseAbs().maxCoeff(), 1e-16);
  EXPECT_EQ(robot.body("a").X_WB.p, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(robot.body("a").X_WB.q.w(), 1);
}

// ---- motion ---------------------------------------------------------------------------------------

constexpr const char* double_pendulum = R"(
[scene]
name = "double"
gravity = [0.0, 0.0, -9.81]
[[body]]
name = "upper"
mass = 0.2
inertia = [1.5e-3, 1.5e-3, 1e-5]
position = [-0.13980586289508393, 0.0, -0.05435366317150104]
orientation_wxyz = [0.8253356149096783, 0.0, 0.5646424733950354, 0.0]
[[body]]
name = "lower"
mass = 0.1
inertia = [6e-4, 6e-4, 1e-5]
position = [-0.37877820683541474, 0.0, -0.09582287691344961]
orientation_wxyz = [0.6599831458849822, 0.0, 0.7512804051402927, 0.0]
[[joint]]
name = "shoulder"
child = "upper"
axis = [0.0, 1.0, 0.0]
child_position = [0.0, 0.0, 0.15]
[[joint]]
name = "elbow"
parent = "upper"
child = "lower"
axis = [0.0, 1.0, 0.0]
parent_position = [0.0, 0.0, -0.15]
child_position = [0.0, 0.0, 0.1]
)";

/// Two rods at 1.2 rad and 1.7 rad, described twice, swing for 1 s.
TEST(UrdfImport, ADoublePendulumSwingsAsItsScene) {
  const Imported robot = accepted(
      link("world", "") +
      link("upper", inertial(0.2, Vec3(0, 0, -0.15), "0 0 0", Vec3(1.5e-3, 1.5e-3, 1e-5))) +
      link("lower", inertial(0.1, Vec3(0, 0, -0.1), "0 0 0", Vec3(6e-4, 6e-4, 1e-5))) +
      joint("shoulder", "continuous", "world", "upper", "<origin rpy=\"0 1.2 0\"/><axis xyz=\"0 1 0\"/>") +
      joint("elbow", "continuous", "upper", "lower",
            "<origin xyz=\"0 0 -0.3\" rpy=\"0 0.5 0\"/><axis xyz=\"0 2 0\"/>"));
  const LoadResult by_hand = parse_scene(double_pendulum, "hand.toml");
  ASSERT_TRUE(by_hand.scene) << by_hand.errors.front();
  EXPECT_THAT(by_hand.warnings, IsEmpty());
  std::vector<CycleRecord> end;
  for (const SceneConfig& scene : {robot.scene(), *by_hand.scene}) {
    const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
    ASSERT_NE(made.session, nullptr) << made.errors.front();
    end.push_back(made.session->at_start());
    for (int i = 0; i < 1000; ++i) made.session->cycle(end.back());
  }
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    EXPECT_LT((end[0].bodies[i].X_WB.p - end[1].bodies[i].X_WB.p).norm(), 1e-12);
    EXPECT_LT(end[0].bodies[i].X_WB.q.angularDistance(end[1].bodies[i].X_WB.q), 1e-12);
    EXPECT_LT((end[0].bodies[i].V_WB.w - end[1].bodies[i].V_WB.w).norm(), 1e-11);
  }
  EXPECT_GT((end[0].bodies[1].X_WB.p - by_hand.scene->bodies[1].X_WB.p).norm(), 0.05);
}

// ---- joints ---------------------------------------------------------------------------------------

const std::string gripper_hand =
    link("hand", inertial(0.7, Vec3(0, 0, 0.03), "0 0 0", Vec3(1e-3, 2.5e-3, 1.7e-3)) +
                     collision("<box size=\"0.04 0.2 0.06\"/>", "<origin xyz=\"0 0 0.03\"/>") + "<visual/>");
std::string jaw(const std::string& name, const std::string& turn, const std::string& more) {
  return link(name, inertial(0.015, Vec3::Zero(), "0 0 0", Vec3(2.1e-6, 2.5e-6, 6e-7)) +
                        collision("<box size=\"0.02 0.01 0.04\"/>")) +
         joint(name + "_slide", "prismatic", "hand", name,
               "<origin xyz=\"0 0 0.06\" rpy=\"0 0 " + turn +
                   "\"/><axis xyz=\"0 1 0\"/><limit lower=\"0\" upper=\"0.04\" effort=\"20\" "
                   "velocity=\"0.2\"/>" +
                   more);
}

TEST(UrdfImport, AGripperKeepsAxesAndLimitsOfItsJaws) {
  const Imported robot = accepted(gripper_hand + jaw("left", "0", "") + jaw("right", shortest(pi), ""));
  const SceneConfig& scene = robot.scene();
  ASSERT_THAT(scene.bodies, SizeIs(3));
  EXPECT_EQ(robot.joint("hand_to_world").kind, JointKind::fixed);
  for (const auto& [name, sign] : {std::pair("left", 1), std::pair("right", -1)}) {
    const JointConfig& slide = robot.joint(std::string(name) + "_slide");
    EXPECT_EQ(slide.kind, JointKind::slider);
    EXPECT_LT((robot.body(name).X_WB.q * (slide.X_BC.q * Vec3::UnitZ()) - sign * Vec3::UnitY()).norm(),
              1e-15);
    ASSERT_THAT(slide.stops, SizeIs(1));
    EXPECT_EQ(slide.stops[0].params.lower, 0);
    EXPECT_EQ(slide.stops[0].params.upper, 0.04);
    EXPECT_DOUBLE_EQ(slide.stops[0].params.width, 4e-4);
    EXPECT_DOUBLE_EQ(slide.stops[0].params.k, 20 / 4e-4);
  }
  EXPECT_THAT(robot.toml,
              HasSubstr("Left out, because scenes have no key for them: <visual> (1), velocity of "
                        "<limit> (2)."));
  std::string why_not;
  const std::vector<BodySample> samples(3);
  EXPECT_TRUE(make_engine(scene, samples, why_not)) << why_not;
}

TEST(UrdfImport, MimicBecomesAGear) {
  const Imported robot =
      accepted(gripper_hand + jaw("left", "0", "") +
               jaw("right", "3.14", "\n<mimic joint=\"left_slide\" multiplier=\"0.5\" offset=\"0.01\"/>"));
  ASSERT_THAT(robot.scene().gears, SizeIs(1));
  const GearConfig& gear = robot.scene().gears[0];
  EXPECT_EQ(gear.name, "right_slide_gear");
  EXPECT_EQ(gear.a, "left_slide");
  EXPECT_EQ(gear.b, "right_slide");
  EXPECT_EQ(gear.ratio, 0.5);
  EXPECT_FALSE(gear.stiffness);
  EXPECT_NEAR(gear.offset.value(), 0.01, 1e-15);
  EXPECT_THAT(robot.toml, HasSubstr("# starts with joint right_slide where its <mimic> puts it"));
  std::string why_not;
  const std::vector<BodySample> samples(3);
  EXPECT_TRUE(make_engine(robot.scene(), samples, why_not)) << why_not;
}

TEST(UrdfImport, MimicOfNothingIsRefused) {
  const auto errors = [](const std::string& left, const std::string& right) {
    return imported("<robot name=\"r\">\n" + gripper_hand + jaw("left", "0", left) +
                    jaw("right", "3.14", right) + "</robot>")
        .errors;
  };
  EXPECT_THAT(errors("", "<mimic joint=\"x\"/>"),
              ElementsAre(HasSubstr("'x' by <mimic>, which does not exist")));
  EXPECT_THAT(errors("", "<mimic joint=\"right_slide\"/>"),
              ElementsAre(HasSubstr("follows itself by <mimic>")));
  EXPECT_THAT(errors("<mimic joint=\"right_slide\"/>", "<mimic joint=\"left_slide\"/>"),
              ElementsAre(HasSubstr("follows itself by <mimic>"), HasSubstr("follows itself by <mimic>")));
  EXPECT_THAT(errors("", "<mimic joint=\"left_slide\" multiplier=\"0\"/>"),
              ElementsAre(HasSubstr("with multiplier 0")));
}

/// A jaw whose multiplier turns it out of its limits of 0 to 0.04 m, as some published grippers have.
TEST(UrdfImport, MimicBeyondTheLimitsOfItsJointIsAWarning) {
  const auto warnings = [](const std::string& multiplier) {
    return imported("<robot name=\"r\">\n" + gripper_hand + jaw("left", "0", "") +
                    jaw("right", "3.14", "<mimic joint=\"left_slide\" multiplier=\"" + multiplier + "\"/>") +
                    "</robot>")
        .warnings;
  };
  EXPECT_THAT(warnings("1"), IsEmpty());
  EXPECT_THAT(
      warnings("-1"),
      ElementsAre(HasSubstr("joint 'right_slide' follows joint 'left_slide' from -0.04 to 0, beyond its "
                            "own limits of 0 to 0.04")));
}

TEST(UrdfImport, AJointStartsAtTheLimitNearestToZero) {
  const Imported robot = accepted(
      link("base", "") + heavy("arm") +
      joint("elbow", "revolute", "base", "arm",
            "<axis xyz=\"0 0 1\"/><limit lower=\"-2\" upper=\"-0.5\" effort=\"80\" velocity=\"2\"/>"));
  EXPECT_NEAR(coordinates_at_start(robot.scene().bodies, robot.scene().joints[0])[0], -0.5, 1e-15);
  EXPECT_THAT(robot.toml, HasSubstr("# starts with joint elbow at its limit nearest to zero"));
}

TEST(UrdfImport, RootsAreFixedFreeOrTheWorldItself) {
  EXPECT_EQ(
      accepted(heavy("base") + heavy("arm") + joint("j", "continuous", "base", "arm")).joint("j").parent,
      "base");
  const Imported free = accepted(link("map", "") + heavy("tool") +
                                 joint("j", "floating", "map", "tool", "<origin xyz=\"1 2 3\"/>"));
  EXPECT_THAT(free.scene().joints, IsEmpty());
  EXPECT_EQ(free.body("tool").X_WB.p, Vec3(1, 2, 3));
  const Imported stand = accepted(link("world", "") + heavy("table") + heavy("arm") +
                                  joint("feet", "fixed", "world", "table", "<origin xyz=\"0 0 1\"/>") +
                                  joint("j", "continuous", "table", "arm"));
  EXPECT_EQ(stand.joint("feet").kind, JointKind::fixed);
  EXPECT_EQ(stand.joint("j").parent, "table");
}

// ---- shapes ---------------------------------------------------------------------------------------

TEST(UrdfImport, ShapesOfMovingLinksAreSolidsOrLeftOutByName) {
  const Imported robot = imported(
      "<robot name=\"r\">" + link("world", "") +
      heavy("a", collision("<box size=\"0.2 0.4 0.6\"/>") +
                     collision("<cylinder radius=\"0.1\" length=\"0.5\"/>", "<origin rpy=\"0 1 0\"/>") +
                     collision("<cylinder radius=\"0.1\" length=\"0.1\"/>") +
                     collision("<mesh filename=\"package://p/a.dae\"/>")) +
      joint("j", "continuous", "world", "a") + "</robot>");
  const std::vector<ShapeConfig>& shapes = robot.body("a").shapes;
  ASSERT_THAT(shapes, SizeIs(2));
  EXPECT_EQ(shapes[0].half_extents, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(shapes[1].kind, ShapeKind::capsule);
  EXPECT_EQ(shapes[1].radius, 0.1);
  EXPECT_EQ(shapes[1].half_length, 0.15);
  EXPECT_NEAR(shapes[1].X.q.angularDistance(Quat(Eigen::AngleAxisd(1, Vec3::UnitY()))), 0, 1e-15);
  EXPECT_THAT(robot.warnings, ElementsAre(HasSubstr("link 'a': cylinder shorter than wide is left out"),
                                          HasSubstr("link 'a': mesh 'a.dae' is left out")));
  EXPECT_THAT(robot.toml, HasSubstr("# left out: mesh 'a.dae' of link a"));
}

TEST(UrdfImport, ContactPointsWithoutARadiusAreLeftOutByName) {
  const Imported robot =
      imported("<robot name=\"r\">" + heavy("a", collision("<sphere radius=\"0.0\"/>")) + "</robot>");
  EXPECT_THAT(robot.loaded.errors, IsEmpty()) << robot.toml;
  EXPECT_THAT(robot.body("a").shapes, IsEmpty());
  EXPECT_THAT(robot.warnings, ElementsAre(HasSubstr("link 'a': a sphere of radius 0 is left out")));
  EXPECT_THAT(robot.toml, HasSubstr("<sphere> of radius 0 (1)"));
}

class UrdfMesh : public ProgramTest {};

TEST_F(UrdfMesh, ShapesOfTheWorldAreObstacles) {
  write("cube.stl", cube_stl());
  write("hole.stl", "solid hole\nendsolid hole\n");
  const Imported robot =
      imported("<robot name=\"r\">" + link("world", "") +
                   link("floor", collision("<mesh filename=\"cube.stl\" scale=\"0.5 0.5 0.5\"/>") +
                                     collision("<box size=\"1 1 1\"/>") +
                                     collision("<mesh filename=\"cube.stl\" scale=\"1 1 2\"/>") +
                                     collision("<mesh filename=\"hole.stl\"/>") +
                                     collision("<mesh filename=\"../cube.stl\"/>")) +
                   link("post", collision("<sphere radius=\"0.1\"/>")) +
                   heavy("a", collision("<sphere radius=\"0.1\"/>")) + joint("j", "continuous", "post", "a") +
                   joint("k", "fixed", "world", "floor", "<origin xyz=\"0 0 -2\"/>") +
                   joint("l", "fixed", "world", "post") + "</robot>",
               path("a.urdf"), path(""));
  EXPECT_THAT(robot.loaded.errors, IsEmpty()) << robot.toml;
  ASSERT_THAT(robot.scene().obstacles, SizeIs(2));
  EXPECT_EQ(robot.scene().obstacles[0].name, "floor");
  EXPECT_EQ(robot.scene().obstacles[0].mesh.triangles.size(), 12u);
  EXPECT_EQ(robot.scene().obstacles[0].scale, 0.5);
  EXPECT_EQ(robot.scene().obstacles[1].name, "floor_2");
  EXPECT_EQ(robot.scene().obstacles[1].shape.X.p, Vec3(0, 0, -2));
  ASSERT_THAT(robot.scene().contacts, SizeIs(1));
  EXPECT_DOUBLE_EQ(robot.scene().contacts[0].law.k, 9.81e4);
  EXPECT_THAT(robot.warnings, SizeIs(4));
  EXPECT_THAT(robot.warnings, Contains(HasSubstr("scales differ")));
  EXPECT_THAT(robot.warnings, Contains(HasSubstr("link 'post': shape is left out")));
}

TEST(UrdfImport, TakesFramesAndBasesWithAMassOfZeroAndWarnsOfInertiaThatNoSolidHas) {
  const std::string weightless = inertial(0, Vec3::Zero(), "0 0 0", Vec3::Zero());
  const Imported robot =
      imported("<robot name=\"r\">" + link("base", weightless) + link("flange", weightless) +
               link("arm", inertial(1, Vec3::Zero(), "0 0 0", Vec3(1, 1, 2.1))) +
               joint("j", "continuous", "base", "arm") + joint("k", "fixed", "arm", "flange") + "</robot>");
  EXPECT_THAT(robot.loaded.errors, IsEmpty()) << robot.toml;
  ASSERT_THAT(robot.scene().bodies, SizeIs(1));
  EXPECT_EQ(robot.scene().bodies[0].mass, 1);
  EXPECT_THAT(robot.warnings,
              Contains(HasSubstr("link 'arm' has principal moments of inertia 1, 1, 2.1 kg m^2")));
}

// ---- errors ---------------------------------------------------------------------------------------

struct Wrong {
  std::string elements, error;
};

TEST(UrdfImport, EveryErrorNamesItsElementAndTheRemedy) {
  const std::string base = link("base", ""), arm = heavy("arm"), ok = joint("j", "continuous", "base", "arm");
  const auto of_mass = [&](double m) { return inertial(m, Vec3::Zero(), "0 0 0", Vec3::Ones()); };
  const auto limited = [&](const std::string& limit) {
    return base + arm + joint("j", "revolute", "base", "arm", limit);
  };
  const std::vector<Wrong> cases{
      {base + link("arm", of_mass(0)) + ok, "link 'arm' moves by joint 'j' and has no mass"},
      {base + link("arm", of_mass(-2)) + ok, "link 'arm' has a mass of -2 kg: give"},
      {base + link("arm", inertial(1, Vec3::Zero(), "0 0 0", Vec3(0, 1, 1))) + ok, "each must be above 0"},
      {base + link("arm", "<inertial><mass value=\"1\"/></inertial>") + ok, "<inertial> has no <inertia"},
      {base + link("arm", "<inertial/>") + ok, "<inertial> has no <mass"},
      {base + link("arm", inertial(1, Vec3::Zero(), "0 0 x", Vec3::Ones())) + ok,
       "'rpy' of <origin> is '0 0 x': give three finite numbers"},
      {base + link("arm", inertial(1, Vec3::Zero(), "0 0 nan", Vec3::Ones())) + ok, "finite numbers"},
      {base + link("arm", "") + ok, "link 'arm' moves by joint 'j' and has no mass: add <inertial>"},
      {base, "no link has mass"},
      {"", "has no links"},
      {base + arm + heavy("arm") + ok, "link 'arm' has the name of an earlier link"},
      {base + arm + heavy("b") + ok + joint("j", "fixed", "arm", "b"),
       "joint 'j' has the name of an earlier"},
      {base + heavy("an arm") + joint("j", "continuous", "base", "an arm"), "has the name 'an arm': rename"},
      {base + arm + joint("j", "continuous", "bsae", "arm"),
       "names link 'bsae', which does not exist: did you "
       "mean 'base'?"},
      {base + arm + ok + joint("k", "fixed", "base", "arm"), "is the child of joints 'j' and 'k'"},
      {base + arm + ok + heavy("b"), "link 'b' is a second root beside 'base'"},
      {base + arm + ok + heavy("b") + heavy("c") + joint("k", "fixed", "b", "c") +
           joint("l", "fixed", "c", "b"),
       "link 'b' is in a loop of joints"},
      {arm + joint("j", "fixed", "arm", "arm"), "joint 'j' is in a loop, and no link is a root"},
      {heavy("world"), "link 'world' is the ground in scenes, and here it has mass: rename it"},
      {base + arm + joint("j", "planar", "base", "arm"),
       "has the type 'planar', which scenes do not have: use"},
      {base + arm + "<joint name=\"j\" type=\"fixed\"><child link=\"arm\"/></joint>",
       "joint 'j' has no <parent"},
      {base + arm + joint("j", "continuous", "base", "arm", "<axis xyz=\"0 0 0\"/>"), "axis of length zero"},
      {limited(""), "joint 'j' has no <limit>: add lower, upper and effort"},
      {limited("<limit lower=\"1\" upper=\"-1\" effort=\"1\"/>"),
       "limits from 1 to -1 rad: lower must be below"},
      {limited("<limit lower=\"-1\" upper=\"1\" effort=\"0\"/>"), "an effort limit of 0 N m: must be > 0"},
      {limited("<limit lower=\"-1\" upper=\"1\"/>"), "<limit> has no attribute 'effort'"},
      {base + heavy("arm", collision("<sphere radius=\"-1\"/>")) + ok,
       "'radius' of <sphere> is -1: must be > 0"},
      {base + heavy("arm", collision("<box size=\"1 1\"/>")) + ok, "'size' of <box> is '1 1': give three"},
      {base + heavy("arm", collision("<box size=\"1 1 0\"/>")) + ok, "each number of a <box> must be > 0"},
      {base + heavy("arm", collision("<cone/>")) + ok, "has a shape <cone>: use <box>"},
      {base + heavy("arm", collision("")) + ok, "has no shape in <geometry>"},
      {base + arm + joint("j", "continuous", "base", "arm", "<origin xyz=\"${x} 0 0\"/>"),
       "run  xacro a.urdf.xacro > a.urdf  and import"},
      {"<xacro:include filename=\"b\"/>", "element <xacro:include> is xacro"},
      {"<link", "is not well-formed XML"},
  };
  for (const Wrong& wrong : cases) {
    const Imported robot = imported("<robot name=\"r\">\n" + wrong.elements + "</robot>");
    EXPECT_THAT(robot.errors, Contains(HasSubstr(wrong.error))) << wrong.elements;
    EXPECT_THAT(robot.errors, Each(testing::MatchesRegex("a.urdf:[0-9]+:1: .*"))) << wrong.elements;
    EXPECT_EQ(robot.toml, "");
  }
  EXPECT_THAT(imported("<sdf/>").errors, ElementsAre(HasSubstr("begins with 'sdf'")));
  EXPECT_THAT(imported("").errors, SizeIs(1));
}

TEST(UrdfImport, AllErrorsAreListedInTheOrderOfTheFile) {
  const Imported robot = imported("<robot name=\"r\">\n<link name=\"a b\"/>\n" +
                                  link("arm", inertial(-2, Vec3::Zero(), "0 0 0", Vec3(0, 1, 3))) +
                                  joint("j", "screw", "base", "arm") + "</robot>");
  EXPECT_THAT(robot.errors,
              ElementsAre(HasSubstr("a.urdf:2:1: a link has the name 'a b'"),
                          HasSubstr("a.urdf:3:1: link 'arm' has"), HasSubstr("a.urdf:3:1: link 'arm' has"),
                          HasSubstr("a.urdf:4:1: joint 'j'"), HasSubstr("a.urdf:4:1: joint 'j'")));
}

TEST(UrdfImport, UnknownElementsAreReported) {
  const Imported robot = imported("<robot name=\"r 1\">" + heavy("a") + "<linc/><gazebo/></robot>");
  EXPECT_THAT(robot.warnings, ElementsAre(HasSubstr("element <linc> is left out")));
  EXPECT_THAT(robot.toml, AllOf(HasSubstr("<gazebo> (1), <linc> (1)"), HasSubstr("name = \"r_1\"")));
  EXPECT_THAT(robot.loaded.errors, IsEmpty());
}

// ---- random trees ---------------------------------------------------------------------------------

struct RandomRobot {
  std::string xml;
  double mass = 0;
  std::vector<Eigen::Isometry3d> X_WL;  // frames of links at the start
  std::vector<std::string> types;       // of the joint of each link
  std::vector<Vec3> axes;               // in link axes
  std::vector<std::pair<double, double>> limits;
};

RandomRobot random_robot(std::mt19937& random, int num_links) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return Vec3(unit(random), unit(random), unit(random)); };
  const auto text = [](const Vec3& x) { return "\"" + triple(x) + "\""; };
  RandomRobot robot;
  robot.xml = "<robot name=\"r\">" + link("l0", "");
  robot.X_WL.push_back(Eigen::Isometry3d::Identity());
  robot.types.emplace_back("root");
  robot.axes.push_back(Vec3::UnitX());
  robot.limits.emplace_back();
  for (int i = 1; i < num_links; ++i) {
    const double mass = std::exp(2 * unit(random));
    const Vec3 parts = vector().cwiseAbs() + Vec3::Constant(0.1);  // of a solid: I_x = y^2 + z^2, ...
    const Vec3 moments =
        mass * 0.01 * Vec3(parts.y() + parts.z(), parts.z() + parts.x(), parts.x() + parts.y());
    const Vec3 p = vector(), rpy = 3 * vector(), axis = vector();
    const auto type = std::string(urdf_joint_kinds.at(random() % urdf_joint_kinds.size()));
    const int parent = static_cast<int>(random() % static_cast<unsigned>(i));
    const double lower = unit(random), upper = lower + 0.1 + std::abs(unit(random));
    const std::string name = std::to_string(i);
    robot.xml += "<link name=\"l" + name + "\"><inertial><origin xyz=" + text(vector()) +
                 " rpy=" + text(vector()) + "/><mass value=\"" + shortest(mass) + "\"/><inertia ixx=\"" +
                 shortest(moments.x()) + "\" iyy=\"" + shortest(moments.y()) + "\" izz=\"" +
                 shortest(moments.z()) + "\"/></inertial></link>\n";
    robot.xml += joint("j" + name, type, "l" + std::to_string(parent), "l" + name,
                       "<origin xyz=" + text(p) + " rpy=" + text(rpy) + "/><axis xyz=" + text(axis) +
                           "/><limit effort=\"10\" lower=\"" + shortest(lower) + "\" upper=\"" +
                           shortest(upper) + "\"/>");
    Eigen::Isometry3d X = robot.X_WL[static_cast<std::size_t>(parent)] * Eigen::Translation3d(p) *
                          Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) *
                          Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) *
                          Eigen::AngleAxisd(rpy.x(), Vec3::UnitX());
    const double q = lower > 0 ? lower : upper < 0 ? upper : 0;
    if (type == "revolute") X = X * Eigen::AngleAxisd(q, axis.normalized());
    if (type == "prismatic") X = X * Eigen::Translation3d(q * axis.normalized());
    robot.mass += mass;
    robot.X_WL.push_back(X);
    robot.types.push_back(type);
    robot.axes.push_back(axis.normalized());
    robot.limits.emplace_back(lower, upper);
  }
  robot.xml += "</robot>";
  return robot;
}

TEST(UrdfImport, RandomTreesKeepMassAxesAndLimits) {
  std::mt19937 random(7);
  Share share;
  for (int draw = 0; draw < 200; ++draw) {
    const RandomRobot robot = random_robot(random, 2 + draw % 12);
    if (!share.takes()) continue;
    const Imported result = imported(robot.xml);
    ASSERT_THAT(result.errors, IsEmpty()) << robot.xml;
    ASSERT_THAT(result.loaded.errors, IsEmpty()) << result.toml;
    EXPECT_THAT(result.loaded.warnings, Not(Contains(HasSubstr("apart")))) << result.toml;
    double mass = 0;
    for (const BodyConfig& body : result.scene().bodies) mass += body.mass;
    EXPECT_NEAR(mass, robot.mass, 1e-12 * robot.mass);
    std::size_t num_moving = 0;
    for (std::size_t i = 1; i < robot.types.size(); ++i) {
      if (robot.types[i] == "fixed") continue;
      const BodyConfig& body = result.body("l" + std::to_string(i));
      EXPECT_LT((body.X_WB.q.toRotationMatrix() - robot.X_WL[i].linear()).norm(), 1e-12);
      if (robot.types[i] == "floating") continue;
      ++num_moving;
      const JointConfig& hinge = result.joint("j" + std::to_string(i));
      const Quat to_world = body.X_WB.q * hinge.X_BC.q;
      EXPECT_LT((to_world * Vec3::UnitZ() - robot.X_WL[i].linear() * robot.axes[i]).norm(), 1e-12);
      EXPECT_LT((body.X_WB.p + body.X_WB.q * hinge.X_BC.p - robot.X_WL[i].translation()).norm(), 1e-12);
      EXPECT_LT(gap_at_start(result.scene().bodies, hinge).m, 1e-12);
      ASSERT_EQ(hinge.stops.size(), robot.types[i] == "continuous" ? 0u : 1u);
      if (hinge.stops.empty()) continue;
      EXPECT_EQ(hinge.stops[0].params.lower, robot.limits[i].first);
      EXPECT_EQ(hinge.stops[0].params.upper, robot.limits[i].second);
    }
    const auto moves = [](const JointConfig& j) { return j.kind != JointKind::fixed; };
    EXPECT_EQ(static_cast<std::size_t>(std::ranges::count_if(result.scene().joints, moves)), num_moving);
  }
}

/// Damaged descriptions are refused, or give a scene that is accepted.
TEST(UrdfImport, DamagedDescriptionsGiveErrorsOrAScene) {
  const std::string whole = "<robot name=\"r\">" + gripper_hand + jaw("left", "0", "") +
                            joint("weld", "fixed", "left", "tip") + link("tip", "") + "</robot>";
  ASSERT_THAT(imported(whole).errors, IsEmpty());
  std::mt19937 random(11);
  int num_refused = 0, num_accepted = 0;
  for (int draw = 0; draw < 4000; ++draw) {
    std::string xml = whole;
    for (auto k = random() % 3; k < 3; ++k) {
      const std::size_t at = random() % xml.size(), from = random() % xml.size();
      switch (random() % 4) {
        case 0: xml.erase(at, random() % 8); break;
        case 1: xml.insert(at, xml.substr(from, random() % 30)); break;
        case 2: xml[at] = static_cast<char>(random() % 256); break;
        default: xml[at] = "0123456789-.e \"<>/"[random() % 18];
      }
    }
    const Imported robot = imported(xml);
    ++(robot.errors.empty() ? num_accepted : num_refused);
    EXPECT_EQ(robot.errors.empty(), !robot.toml.empty());
    if (robot.errors.empty()) {
      EXPECT_THAT(robot.loaded.errors, IsEmpty()) << xml << robot.toml;
    }
  }
  EXPECT_GT(num_refused, 1000) << num_accepted;
  EXPECT_GT(num_accepted, 100);
}

// ---- the verb -------------------------------------------------------------------------------------

class UrdfVerb : public ProgramTest {};

TEST_F(UrdfVerb, WritesAFileOrStandardOutputAndNothingOnErrors) {
  const std::string good = write("good.urdf", "<robot name=\"r\">" + link("world", "") + heavy("arm") +
                                                  joint("j", "continuous", "world", "arm") + "</robot>");
  const ProgramResult printed = run_program("import " + good);
  EXPECT_EQ(printed.exit_code, 0);
  EXPECT_TRUE(parse_scene(printed.output, "a.toml").scene) << printed.output;
  EXPECT_EQ(run_program("import " + good + " --out " + path("a.toml")).exit_code, 0);
  EXPECT_EQ(read_file(path("a.toml")), printed.output);

  const ProgramResult again = run_program("import " + good + " --out " + path("a.toml"));
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.output, HasSubstr("exists and is kept"));
  EXPECT_EQ(read_file(path("a.toml")), printed.output);

  const std::string bad = write("bad.urdf", "<robot name=\"r\">" + link("arm", "") + "</robot>");
  const ProgramResult refused = run_program("import " + bad + " --out " + path("b.toml"));
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.output, HasSubstr("bad.urdf:1:1: no link has mass"));
  EXPECT_FALSE(std::filesystem::exists(path("b.toml")));
  EXPECT_EQ(run_program("import " + path("missing.urdf")).exit_code, 2);
  EXPECT_EQ(run_program("import").exit_code, 2);
}

}  // namespace
}  // namespace godobject::test::test_urdf

#endif
