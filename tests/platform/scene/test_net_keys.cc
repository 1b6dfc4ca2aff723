// [[net]] in scene files: values, documented defaults, and errors with their place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "platform/scene/contact/params.h"
#include "platform/scene/net/params.h"
#include "platform/scene/toml.h"

namespace godobject::test_net_keys {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string head = R"([scene]
name = "test"

[[body]]
name = "rod"
mass = 0.1
inertia = [1e-4, 1e-4, 1e-5]
)";

const std::string bag = R"(
[[net]]
name = "bag"
body = "rod"
kind = "capsule"
radius = 0.03
half_length = 0.04
spacing = 0.01
)";

const std::string numbers = R"(mass = 0.02
membrane_stiffness = 100.0
settling_time = 0.05
)";

LoadResult parse(const std::string& text) { return parse_scene(text, testing::TempDir() + "/a.toml"); }

SceneConfig loaded(const std::string& text) {
  const LoadResult result = parse(text);
  EXPECT_THAT(result.errors, IsEmpty());
  EXPECT_THAT(result.warnings, IsEmpty());
  return result.scene.value_or(SceneConfig{});
}

/// Returns the only error.
std::string error_of(const std::string& text) {
  const LoadResult result = parse(text);
  EXPECT_EQ(result.errors.size(), 1U) << testing::PrintToString(result.errors);
  return result.errors.empty() ? "" : result.errors.front();
}

std::string warning_of(const std::string& text) {
  const LoadResult result = parse(text);
  EXPECT_THAT(result.errors, IsEmpty());
  EXPECT_EQ(result.warnings.size(), 1U) << testing::PrintToString(result.warnings);
  return result.warnings.empty() ? "" : result.warnings.front();
}

TEST(NetKeys, DefaultsAreWhatTheDocumentationSays) {
  const SceneConfig scene = loaded(head + bag + numbers);
  ASSERT_EQ(scene.nets.size(), 1U);
  const NetConfig& net = scene.nets[0];
  EXPECT_EQ(net.body, "rod");
  const double area = area_of(net.surface);
  EXPECT_NEAR(net.surface_density, 0.02 / area, 1e-12);
  EXPECT_NEAR(*net.thickness, mean_edge_of(net.surface), 1e-15);
  EXPECT_NEAR(*net.held_stiffness, 5 * std::sqrt(3.0) * 100, 1e-9);
  const double T = 0.05;
  EXPECT_NEAR(*net.anchor_stiffness, 64 / (1.4 * 1.4) * net.surface_density / (T * T), 1e-6);
  // A node on its anchor alone is damped like couplings: g = 1.4 sqrt(k m).
  for (const NetNode& node : scene_nets(scene).nodes)
    EXPECT_NEAR(node.g, 1.4 * std::sqrt(node.k * node.m), 1e-12);
  const double m = 0.02 / static_cast<double>(net.surface.vertices.size()), k = std::sqrt(3.0) / 2 * 100;
  EXPECT_NEAR(net.relaxation_time, 1.4 * std::sqrt(m / 2 / k), 1e-12);
}

const std::string organ = R"(
[[net]]
name = "organ"
kind = "sheet"
length = 0.1
width = 0.08
spacing = 0.01
surface_density = 2.0
membrane_stiffness = 50.0
settling_time = 0.3
rim = true
thickness = 0.012
bending = 0.1

[[net.held]]
position = [0.0, 0.01, 0.0]
radius = 0.02
)";

std::string law(const std::string& a, const std::string& b) {
  return "\n[[contact]]\nmaterials = [\"" + a + "\", \"" + b + "\"]\nstiffness = 1000\n";
}

TEST(NetKeys, WhatIsInEffectReadsBackAsTheSame) {
  const SceneConfig scene = loaded(head + bag + numbers + organ + law("default", "default"));
  const std::string text = effective_config_toml(scene);
  const SceneConfig again = loaded(text);
  EXPECT_EQ(effective_config_toml(again), text);
  const SceneNets a = scene_nets(scene), b = scene_nets(again);
  ASSERT_EQ(a.nodes.size(), b.nodes.size());
  for (std::size_t i = 0; i < a.nodes.size(); ++i) {
    EXPECT_EQ(a.nodes[i].p_B, b.nodes[i].p_B);
    EXPECT_NEAR(a.nodes[i].m, b.nodes[i].m, 1e-15 * a.nodes[i].m);
    EXPECT_NEAR(a.nodes[i].k, b.nodes[i].k, 1e-15 * a.nodes[i].k);
  }
  EXPECT_EQ(a.springs.size(), b.springs.size());
}

TEST(NetKeys, ANetOfAMeshFile) {
  std::ofstream(testing::TempDir() + "/net.obj") << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
  const std::string mesh =
      "\n[[net]]\nname = \"leaf\"\nkind = \"mesh\"\nfile = \"net.obj\"\nscale = 0.1\nrim = true\n";
  const SceneConfig scene = loaded(head + mesh + numbers);
  EXPECT_NEAR(area_of(scene.nets[0].surface), 0.01, 1e-9);
  EXPECT_THAT(error_of(head + mesh + "spacing = 0.1\n" + numbers), HasSubstr("spacing"));
  EXPECT_THAT(error_of(head + "\n[[net]]\nname = \"leaf\"\nkind = \"mesh\"\nrim = true\n" + numbers),
              HasSubstr("'file' is missing: a mesh is read from one"));

  std::ofstream(testing::TempDir() + "/fan.obj")
      << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 -1 0\nf 1 2 3\nf 1 2 4\nf 1 2 5\n";
  const std::string fan = "\n[[net]]\nname = \"fan\"\nkind = \"mesh\"\nfile = \"fan.obj\"\nrim = true\n";
  EXPECT_THAT(error_of(head + fan + numbers),
              testing::AllOf(HasSubstr("a.toml:12:8: "), HasSubstr("3 triangles meet")));
}

TEST(NetKeys, WhatIsWrongIsRefusedWithItsPlace) {
  const auto with = [](const std::string& line) { return head + bag + numbers + line; };
  EXPECT_THAT(
      error_of(head +
               "\n[[net]]\nname = \"x\"\nbody = \"rot\"\nkind = \"sphere\"\nradius = 0.02\nspacing = 0.01\n" +
               numbers),
      testing::AllOf(HasSubstr("a.toml:11:8: "),
                     HasSubstr("\"rot\", which is not a body: admissible is \"world\", \"rod\"")));
  EXPECT_THAT(error_of(with("length = 0.1\n")), HasSubstr("has no meaning for this kind of shape"));
  EXPECT_THAT(error_of(with("surface_density = 0.1\n")), HasSubstr("give the same quantity"));
  EXPECT_THAT(error_of(with("rim = true\n")), HasSubstr("the surface is closed"));
  EXPECT_THAT(error_of(with("stifness = 3\n")), HasSubstr("stifness"));
  EXPECT_THAT(error_of(with("[[net.held]]\nposition = [1.0, 0.0, 0.0]\nradius = 0.01\n")),
              HasSubstr("no node is inside the ball"));
  EXPECT_THAT(error_of(head + bag + numbers + bag + numbers + law("default", "default")),
              HasSubstr("is the name of an earlier net"));
  EXPECT_THAT(error_of(head + bag + numbers + organ),
              HasSubstr("(net 'bag') and 'default' (net 'organ') can meet"));
  EXPECT_THAT(error_of(head + bag + "mass = 0.02\nmembrane_stiffness = -1.0\nsettling_time = 0.1\n"),
              HasSubstr("membrane_stiffness"));
}

const std::string needle = "\n[[body]]\nname = \"needle\"\nmass = 0.02\ninertia = [1e-6, 1e-6, 1e-6]\n";
const std::string tied =
    "\n[[net.attached]]\nbody = \"needle\"\nposition = [0.0, 0.0, 0.07]\nradius = 0.02\n";

TEST(NetKeys, VerticesWithinABallAreAttachedWhereTheyAre) {
  const std::string turned = "position = [0.1, 0.0, 0.0]\norientation_wxyz = [0.6, 0.0, 0.8, 0.0]\n";
  const SceneConfig scene = loaded(head + turned + needle + turned + bag + numbers + tied);
  const SceneNets nets = scene_nets(scene);
  const double k = 5 * std::sqrt(3.0) * 100;
  const double m = 0.02 / static_cast<double>(nets.nodes.size());
  std::size_t within = 0;
  for (const NetNode& node : nets.nodes) within += (node.p_B - Vec3(0, 0, 0.07)).norm() <= 0.02 ? 1 : 0;
  ASSERT_GT(within, 4U);
  EXPECT_EQ(nets.attachments.size(), within);
  for (const NetAttachment& one : nets.attachments) {
    EXPECT_EQ(one.body, 1U);
    EXPECT_LT((one.p_B - nets.nodes[one.node].p_B).norm(), 1e-15) << "both bodies are in one place";
    EXPECT_NEAR(one.k, k, 1e-9);
    EXPECT_NEAR(one.g, 1.4 * std::sqrt(k * m), 1e-9);
  }
  const SceneConfig stated =
      loaded(head + needle + bag + numbers + tied + "stiffness = 50.0\nrelaxation_time = 0.01\n");
  EXPECT_EQ(scene_nets(stated).attachments[0].k, 50);
  EXPECT_EQ(scene_nets(stated).attachments[0].g, 0.5);
  const std::string text = effective_config_toml(stated);
  EXPECT_EQ(effective_config_toml(loaded(text)), text);
}

TEST(NetKeys, AttachmentsThatAreWrongAreRefusedWithTheirPlace) {
  const auto with = [](const std::string& body, const std::string& p, const std::string& more = "") {
    return head + needle + bag + numbers + "\n[[net.attached]]\nbody = \"" + body + "\"\nposition = " + p +
           "\n" + more;
  };
  const std::string tip = "[0.0, 0.0, 0.07]", ball = "radius = 0.02\n";
  EXPECT_THAT(error_of(with("nedle", tip, ball)),
              testing::AllOf(HasSubstr("a.toml:26:8: "),
                             HasSubstr("not a body: admissible is \"world\", \"rod\", \"needle\"")));
  EXPECT_THAT(error_of(with("", tip, ball)), HasSubstr("is \"\", which is not a body"));
  EXPECT_THAT(error_of(with("rod", tip, ball)), HasSubstr("hold nodes there by [[net.held]]"));
  EXPECT_THAT(error_of(with("needle", "[1.0, 0.0, 0.0]", ball)),
              testing::AllOf(HasSubstr("a.toml:28:10: "), HasSubstr("no node is inside the ball")));
  EXPECT_THAT(error_of(with("needle", tip)), HasSubstr("'radius'"));
  EXPECT_THAT(error_of(with("needle", tip, ball + "stiffness = 0.0\n")), HasSubstr("stiffness"));
  EXPECT_THAT(loaded(with("world", tip, ball)).nets[0].attached, testing::SizeIs(1));
  EXPECT_THAT(error_of(with("needle", tip, "radius = 1.0\n")),
              testing::AllOf(HasSubstr("a.toml:25:1: "),
                             HasSubstr("attachments, above the capacity of 256: use smaller balls")));
}

TEST(NetKeys, MoreThanThereIsRoomForIsRefusedWithWhatFits) {
  const std::string fine =
      "\n[[net]]\nname = \"x\"\nkind = \"sphere\"\nradius = 0.05\nspacing = 0.001\nbody = \"rod\"\n";
  EXPECT_THAT(error_of(head + fine + numbers),
              testing::AllOf(HasSubstr("a.toml:13:11: "), HasSubstr("above the capacity of 1536 of 1536"),
                             HasSubstr("m or above fits")));
  std::string many = head;
  for (int i = 0; i < 3; ++i)
    many += "\n[[net]]\nname = \"n" + std::to_string(i) +
            "\"\nbody = \"rod\"\nkind = \"sphere\"\nradius = 0.05\nspacing = 0.008\nmaterial = \"m\"\n" +
            numbers;
  EXPECT_THAT(error_of(many + law("m", "m")), HasSubstr("a spacing of"));
}

TEST(NetKeys, WhatIsUnwiseIsAWarning) {
  const auto with = [](const std::string& line) { return head + bag + numbers + line; };
  EXPECT_THAT(warning_of(with("thickness = 0.004\n")), HasSubstr("pass between the nodes"));
  EXPECT_THAT(warning_of(with("anchor_stiffness = 1.0\nrelaxation_time = 0.0\n")), HasSubstr("creeps back"));
  EXPECT_THAT(warning_of(head + bag + "mass = 0.02\nmembrane_stiffness = 1e6\nsettling_time = 0.05\n"),
              HasSubstr("more than 12 iterations"));
  EXPECT_THAT(
      warning_of(head + "\n[[net]]\nname = \"x\"\nkind = \"sphere\"\nradius = 0.02\nspacing = 0.01\n" +
                 numbers),
      HasSubstr("net 'x' is not held"));
}

TEST(NetKeys, NodesMeetObstaclesAndBodiesOfOtherTools) {
  const std::string ball = R"(
[[obstacle]]
name = "ball"
kind = "sphere"
radius = 0.02
material = "wood"
)";
  const std::string rubber = head + bag + numbers + "material = \"rubber\"\n" + ball;
  EXPECT_THAT(error_of(rubber), HasSubstr("'rubber' (net 'bag') and 'wood' (obstacle 'ball') can meet"));
  const SceneConfig scene = loaded(rubber + law("rubber", "wood"));
  EXPECT_EQ(contact_scope(scene), ContactScope::obstacles);
  EXPECT_EQ(scene.contacts[0].law.ratio, 1.4);

  const std::string shape = "\n[[body.shape]]\nkind = \"sphere\"\nradius = 0.01\nmaterial = \"steel\"\n";
  EXPECT_THAT(loaded(head + shape + bag + numbers + "material = \"rubber\"\n").contacts, IsEmpty())
      << "its own carrier";
  const std::string other = shape + "\n[[body]]\nname = \"jaw\"\nmass = 0.1\ninertia = [1e-4, 1e-4, 1e-5]\n" +
                            shape + law("steel", "steel");
  EXPECT_THAT(error_of(head + other + bag + numbers + "material = \"rubber\"\n"),
              HasSubstr("'rubber' (net 'bag') and 'steel'"));
  EXPECT_EQ(loaded(head + other + bag + numbers + "thickness = 0.0\n").contacts.size(), 1u)
      << "of the shapes; the net touches nothing";
}

}  // namespace
}  // namespace godobject::test_net_keys
