// Scene files: loaded values equal the text, and errors have their place.
#include "platform/scene/toml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <sstream>

#include "platform/scene/text/key.h"

namespace godobject::test_scene_toml {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string minimal = R"([scene]
name = "test"

[[body]]
name = "tool"
mass = 0.1
inertia = [3e-4, 3e-4, 2e-5]

[body.coupling]
stiffness = 1000
rotational_stiffness = 1
)";

const std::string rig = R"(
[[bus]]
name = "can0"

[device]
name = "arm"

[[device.joint]]
name = "turret"

[[device.encoder]]
joint = "turret"
bus = "can0"
node_id = 1
counts_per_turn = 4096
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

LoadResult parse(const std::string& text) { return parse_scene(text, "a.toml"); }

/// Returns the errors of `minimal` with one piece replaced.
std::vector<std::string> errors_with(const std::string& from, const std::string& to) {
  const LoadResult result = parse(replaced(minimal, from, to));
  EXPECT_FALSE(result.scene.has_value());
  return result.errors;
}

TEST(SceneToml, MinimalSceneHasDefaultsAndTheDefaultDampingRatio) {
  const LoadResult result = parse(minimal);
  ASSERT_THAT(result.errors, IsEmpty());
  EXPECT_THAT(result.warnings, IsEmpty());
  const SceneConfig& scene = *result.scene;
  EXPECT_EQ(scene.name, "test");
  EXPECT_EQ(scene.integrator, "tr-bdf2");
  EXPECT_EQ(scene.step, 1e-3);
  ASSERT_EQ(scene.bodies.size(), 1u);
  ASSERT_TRUE(scene.bodies[0].coupling.has_value());
  EXPECT_DOUBLE_EQ(scene.bodies[0].coupling->g, 1.4 * std::sqrt(0.1 * 1000));
  EXPECT_DOUBLE_EQ(scene.bodies[0].coupling->g_r, 1.4 * std::sqrt(3e-4 * 1));
  EXPECT_FALSE(scene.bodies[0].feedback.has_value());
  EXPECT_FALSE(scene.device.has_value());
}

TEST(SceneToml, UnknownKeyNamesPlaceAndNearestKey) {
  EXPECT_THAT(
      errors_with("mass = 0.1", "mass = 0.1\nvelocty = [0, 0, 0]"),
      ElementsAre("a.toml:7:1: unknown key 'velocty' in [[body]]; the nearest known key is 'velocity'"));
}

TEST(SceneToml, ErrorsAndWarningsHaveTheirPlaces) {
  const LoadResult refused = parse(replaced(minimal, "mass =", "mas = 1\nmass = -"));
  ASSERT_EQ(refused.placed_errors.size(), refused.errors.size());
  for (std::size_t i = 0; i < refused.errors.size(); ++i) {
    const PlacedText& error = refused.placed_errors[i];
    EXPECT_EQ(error.file, "a.toml");
    EXPECT_EQ(format_diagnostic(error.file, error.at.value(), error.text), refused.errors[i]);
  }
  const LoadResult absent = load_scene("no/such.toml");
  ASSERT_EQ(absent.placed_errors.size(), 1u);
  EXPECT_FALSE(absent.placed_errors[0].at);
  EXPECT_EQ(absent.placed_errors[0].file + ": " + absent.placed_errors[0].text, absent.errors.at(0));
}

TEST(SceneToml, UnknownTableIsRefused) {
  const LoadResult result = parse(minimal + "\n[devise]\nname = \"x\"\n");
  EXPECT_THAT(result.errors,
              ElementsAre(AllOf(HasSubstr("a.toml:13:"), HasSubstr("'devise'"), HasSubstr("'device'"))));
}

TEST(SceneToml, MissingRequiredKeyIsRefused) {
  EXPECT_THAT(errors_with("mass = 0.1\n", ""),
              ElementsAre(AllOf(HasSubstr("a.toml:4:"),
                                HasSubstr("required key 'mass' (kg) is missing in [[body]]"))));
  EXPECT_THAT(parse("").errors, ElementsAre(HasSubstr("'scene'"), HasSubstr("'body'")));
}

TEST(SceneToml, WrongTypesAreRefused) {
  EXPECT_THAT(errors_with("mass = 0.1", "mass = \"light\""),
              ElementsAre(AllOf(HasSubstr("a.toml:6:8:"), HasSubstr("must be a number (kg), not a string"))));
  EXPECT_THAT(errors_with("name = \"tool\"", "name = 3"),
              ElementsAre(HasSubstr("must be a string, not an integer")));
  EXPECT_THAT(errors_with("mass = 0.1", "mass = 0.1\nposition = [0, 0]"),
              ElementsAre(HasSubstr("must be an array of 3 numbers (m), not 2 of them")));
  EXPECT_THAT(errors_with("[[body]]", "[body]"), ElementsAre(HasSubstr("write each as [[body]]")));
  EXPECT_THAT(errors_with("[body.coupling]", "[[body.coupling]]"),
              ElementsAre(HasSubstr("written [body.coupling]")));
}

TEST(SceneToml, RangeNanAndInfinityAreRefused) {
  EXPECT_THAT(errors_with("stiffness = 1000", "stiffness = -1"),
              ElementsAre(AllOf(HasSubstr("a.toml:10:13:"),
                                HasSubstr("out of range: admissible is 0 to 1e+13 (N/m)"))));
  EXPECT_THAT(errors_with("mass = 0.1", "mass = nan"), ElementsAre(HasSubstr("'mass' must be finite")));
  EXPECT_THAT(errors_with("mass = 0.1", "mass = 0.1\nvelocity = [0, inf, 0]"),
              ElementsAre(AllOf(HasSubstr("a.toml:7:"), HasSubstr("'velocity' must be finite"))));
}

TEST(SceneToml, InertiaMustBePossible) {
  const std::string diagonal = "[3e-4, 3e-4, 2e-5]";
  EXPECT_THAT(errors_with(diagonal, "[1e-4, 1e-4, 0]"), ElementsAre(HasSubstr("must be positive definite")));
  EXPECT_THAT(errors_with(diagonal, "[[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]"),
              ElementsAre(HasSubstr("must be symmetric")));
  EXPECT_THAT(parse(replaced(minimal, diagonal, "[1e-4, 1e-4, 3e-4]")).warnings,
              ElementsAre(HasSubstr("not that of a solid")));
  const LoadResult full = parse(replaced(minimal, diagonal, "[[1, 0.1, 0], [0.1, 1, 0], [0, 0, 1]]"));
  ASSERT_THAT(full.errors, IsEmpty());
  EXPECT_EQ(full.scene->bodies[0].inertia(0, 1), 0.1);
}

TEST(SceneToml, QuaternionMustBeUnitWithinTolerance) {
  EXPECT_THAT(errors_with("mass = 0.1", "mass = 0.1\norientation_wxyz = [1, 1, 0, 0]"),
              ElementsAre(AllOf(HasSubstr("a.toml:7:"), HasSubstr("its norm is 1.414213562373095"))));
  const LoadResult near =
      parse(replaced(minimal, "mass = 0.1", "mass = 0.1\norientation_wxyz = [0.7071067, 0.7071067, 0, 0]"));
  ASSERT_THAT(near.errors, IsEmpty());
  EXPECT_NEAR(near.scene->bodies[0].X_WB.q.norm(), 1, 1e-15);
}

TEST(SceneToml, DampingIsGivenOnce) {
  EXPECT_THAT(errors_with("stiffness = 1000", "stiffness = 1000\ndamping = 10\ndamping_ratio = 1.5"),
              ElementsAre(HasSubstr("a.toml:12:")));
}

TEST(SceneToml, DampingRatioOutsideThePapersRangeIsAdvisedAgainst) {
  const LoadResult result = parse(replaced(minimal, "stiffness = 1000", "stiffness = 1000\ndamping = 5"));
  EXPECT_TRUE(result.scene.has_value());
  EXPECT_THAT(result.warnings, ElementsAre(AllOf(HasSubstr("a.toml:11:"),
                                                 HasSubstr("0.5 is outside the advised range 1.4 to 2"))));
  EXPECT_THAT(parse(replaced(minimal, "name = \"test\"", "name = \"test\"\nstep = 0.01")).warnings,
              ElementsAre(HasSubstr("above 2 ms")));
}

TEST(SceneToml, FeedbackScalesTheSpringsOfTheCouplingAndKeepsExplicitGains) {
  const LoadResult result = parse(minimal + "[body.feedback]\nscale = 0.5\nrotational_stiffness = 0.25\n");
  ASSERT_THAT(result.errors, IsEmpty());
  const SpringParams& feedback = *result.scene->bodies[0].feedback;
  EXPECT_EQ(feedback.k, 500);
  EXPECT_EQ(feedback.g, 0);  // because the device would need it too: decision 027
  EXPECT_EQ(feedback.k_r, 0.25);
  EXPECT_EQ(feedback.g_r, 0);
}

TEST(SceneToml, DuplicateNamesAreRefused) {
  const LoadResult result = parse(minimal + "\n[[body]]\nname = \"tool\"\nmass = 1\ninertia = [1, 1, 1]\n");
  EXPECT_THAT(result.errors,
              ElementsAre(AllOf(HasSubstr("a.toml:14:"), HasSubstr("is the name of an earlier body"))));
}

TEST(SceneToml, UnknownChoiceNamesTheNearest) {
  const LoadResult result =
      parse(replaced(minimal, "name = \"test\"", "name = \"test\"\nintegrator = \"tr-bdf\""));
  EXPECT_THAT(result.errors, ElementsAre(AllOf(HasSubstr("\"implicit-euler\", \"tr-bdf2\""),
                                               HasSubstr("nearest is \"tr-bdf2\""))));
}

TEST(SceneToml, RigIsRead) {
  const LoadResult result = parse(minimal + rig);
  ASSERT_THAT(result.errors, IsEmpty());
  const RigParams& params = *result.scene->device->rig;
  ASSERT_EQ(params.encoders.size(), 1u);
  EXPECT_EQ(params.encoders[0].bus, 0u);
  EXPECT_DOUBLE_EQ(params.encoders[0].calibration.counts_per_unit, 4096 / (2 * std::numbers::pi));
  EXPECT_DOUBLE_EQ(params.stale_after_s, 3e-3);
}

TEST(SceneToml, BrokenRigsAreRefused) {
  const auto errors = [](const std::string& from, const std::string& to) {
    return parse(minimal + replaced(rig, from, to)).errors;
  };
  EXPECT_THAT(errors("joint = \"turret\"", "joint = \"turet\""),
              testing::Contains(HasSubstr("nearest is \"turret\"")));
  EXPECT_THAT(errors("bus = \"can0\"", "bus = \"can1\""), ElementsAre(HasSubstr("admissible is \"can0\"")));
  EXPECT_THAT(errors("node_id = 1", "node_id = 128"), ElementsAre(HasSubstr("admissible is 1 to 127")));
  EXPECT_THAT(errors("counts_per_turn = 4096", ""), ElementsAre(HasSubstr("'counts_per_unit'")));
  EXPECT_THAT(errors("counts_per_turn = 4096", "counts_per_turn = 4096\nsign = 0"),
              ElementsAre(HasSubstr("must be 1 or -1")));
  EXPECT_THAT(errors("name = \"turret\"", "name = \"turret\"\nkind = \"slider\""),
              ElementsAre(HasSubstr("no meaning on a slider")));
  EXPECT_THAT(errors("[[device.encoder]]", "[[device.joint]]\nname = \"free\"\n[[device.encoder]]"),
              ElementsAre(HasSubstr("joint 'free' is not measured")));
  EXPECT_THAT(
      parse(minimal + rig +
            "[[device.encoder]]\njoint = \"turret\"\nbus = \"can0\"\nnode_id = 1\ncounts_per_unit = 1\n")
          .errors,
      ElementsAre(HasSubstr("taken by another node")));
}

TEST(SceneToml, AllErrorsOfAFileAreReportedInItsOrder) {
  const std::string text = replaced(replaced(minimal, "mass = 0.1", "mass = -1\ncolour = 3"),
                                    "stiffness = 1000", "stiffness = \"stiff\"");
  EXPECT_THAT(parse(text).errors,
              ElementsAre(HasSubstr("a.toml:6:"), HasSubstr("a.toml:7:"), HasSubstr("a.toml:11:")));
}

TEST(SceneToml, SyntaxErrorsAndMissingFilesAreRefused) {
  EXPECT_THAT(parse("[scene\nname = 1").errors, ElementsAre(HasSubstr("a.toml:1:")));
  EXPECT_THAT(parse("[scene]\nname = \"a\"\nname = \"b\"").errors, ElementsAre(HasSubstr("a.toml:3:")));
  EXPECT_THAT(load_scene("no/such.toml").errors, ElementsAre(HasSubstr("no/such.toml: cannot be read")));
}

TEST(SceneToml, NonHapticDeviceHasNoFeedback) {
  const LoadResult result =
      parse(minimal + "[body.feedback]\nscale = 1\n[device]\nname = \"d\"\nkind = \"non-haptic\"\n");
  EXPECT_THAT(result.errors, ElementsAre(HasSubstr("non-haptic")));
}

/// Sets every key of the format to a value that is not its default.
TEST(SceneToml, EffectiveConfigurationLoadsBackAsItself) {
  SceneConfig scene = *parse(minimal + rig).scene;
  scene.about = "quotes \" and \\ and\nlines";
  scene.gravity = Vec3(0.1, -0.0, -9.81);
  scene.bodies[0].inertia << 1, 0.1, 0.2, 0.1, 1.1, 0.3, 0.2, 0.3, 1.2;
  scene.bodies[0].X_WB = {Vec3(1e-300, 1.0 / 3, -2), Quat(0.5, 0.5, -0.5, 0.5)};
  scene.bodies[0].feedback = SpringParams{1, 2, 3, 4};
  scene.device->rig->stale_after_s = 0.1 + 0.2;
  scene.device->rig->drives.push_back(
      {.joint = "turret", .node_id = 7, .status_every_nth_sync = 3, .calibration = {.counts_per_unit = 7}});
  scene.motion = MotionConfig{};
  scene.motion->amplitude = Vec3(0.1, 0.2, 0.3);
  scene.wire = {.seed = 9, .loss_probability = 0.1, .corruption_probability = 0.2, .delay_s = 1e-4};
  const std::string text = effective_config_toml(scene);
  const LoadResult back = parse_scene(text, "printed");
  ASSERT_THAT(back.errors, IsEmpty()) << text;
  EXPECT_EQ(effective_config_toml(*back.scene), text);
  EXPECT_EQ(back.scene->about, scene.about);
  EXPECT_EQ(back.scene->bodies[0].inertia, scene.bodies[0].inertia);
  EXPECT_EQ(back.scene->bodies[0].X_WB.p, scene.bodies[0].X_WB.p);
  EXPECT_EQ(back.scene->bodies[0].X_WB.q.coeffs(), scene.bodies[0].X_WB.q.coeffs());
  EXPECT_EQ(back.scene->bodies[0].coupling->g, scene.bodies[0].coupling->g);
  EXPECT_EQ(back.scene->device->rig->drives[0].node_id, 7);
  EXPECT_EQ(back.scene->wire.delay_s, 1e-4);
}

class ShippedScene : public testing::TestWithParam<std::string> {};

std::vector<std::string> shipped_scenes() {
  std::vector<std::string> paths;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(GODOBJECT_SOURCE_DIR "/sim/scenes")) {
    if (entry.path().extension() == ".toml") paths.push_back(entry.path().string());
  }
  std::ranges::sort(paths);
  return paths;
}

std::string stem(const std::string& path) { return std::filesystem::path(path).stem().string(); }

TEST_P(ShippedScene, LoadsWithoutComplaintAndRoundTrips) {
  const LoadResult result = load_scene(GetParam());
  ASSERT_THAT(result.errors, IsEmpty());
  // The textbook inertia of torque-free is not that of a solid.
  EXPECT_EQ(result.warnings.size(), result.scene->name == "torque-free" ? 1u : 0u);
  EXPECT_EQ(result.scene->name, stem(GetParam()));
  const std::string text = effective_config_toml(*result.scene);
  const auto printed =
      std::filesystem::path(GetParam()).parent_path() / "printed";  // beside the files that it names
  const LoadResult back = parse_scene(text, printed.string());
  ASSERT_THAT(back.errors, IsEmpty()) << text;
  EXPECT_EQ(effective_config_toml(*back.scene), text);
}

INSTANTIATE_TEST_SUITE_P(All, ShippedScene, testing::ValuesIn(shipped_scenes()), [](const auto& test) {
  const std::filesystem::path path(test.param);
  std::string name = stem(path.string());
  if (path.parent_path().filename() == "reference") name += "_reference";
  std::ranges::replace(name, '-', '_');
  return name;
});

std::string scenes_document() {
  std::ifstream file(GODOBJECT_SOURCE_DIR "/docs/scenes.md");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

TEST(SceneReference, DocumentHoldsTheGeneratedTables) {
  const std::string expected =
      "<!-- keys: begin -->\n\n" + scene_reference_markdown() + "\n<!-- keys: end -->";
  EXPECT_THAT(scenes_document(), HasSubstr(expected))
      << "paste the tables of scene_reference_markdown() between the markers";
}

TEST(SceneReference, DocumentDescribesEveryShippedScene) {
  const std::string document = scenes_document();
  for (const std::string& path : shipped_scenes()) EXPECT_THAT(document, HasSubstr(stem(path) + ".toml"));
}

TEST(Key, NumbersAreShortestAndReadBack) {
  EXPECT_EQ(shortest(1), "1.0");
  EXPECT_EQ(shortest(-0.0), "-0.0");
  EXPECT_EQ(shortest(1e-3), "0.001");
  EXPECT_EQ(std::stod(shortest(0.1 + 0.2)), 0.1 + 0.2);
}

TEST(Key, RangesReadAsText) {
  EXPECT_EQ(to_string(Range{0, 1}), "0 to 1");
  EXPECT_EQ(to_string(Range{.min = 0, .min_open = true}), "> 0");
  EXPECT_EQ(to_string(Range{}), "");
}

}  // namespace
}  // namespace godobject::test_scene_toml
