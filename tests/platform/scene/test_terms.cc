// Springs, forces, gears and loops of scene files: their parameters, and errors of bad ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/scene/joint/joints.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_scene_terms {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string bodies() { return body("a") + body("b") + body("c"); }
std::vector<std::string> errors_of(const std::string& text) { return parse_tool(bodies() + text).errors; }
std::string table(const std::string& kind, const std::string& name, const std::string& keys) {
  return "[[" + kind + "]]\nname = \"" + name + "\"\n" + keys;
}
std::string hinges() { return joint("p", "hinge", "world", "a") + joint("q", "hinge", "world", "b"); }

TEST(SceneTerms, SpringHasTheLengthOfItsPlaceByDefault) {
  const LoadResult loaded = parse_tool(
      bodies() + table("spring", "s", "b = \"b\"\nposition_a = [0.0, 0.0, 0.3]\nstiffness = 50.0\n") +
      table("spring", "t", "a = \"a\"\nb = \"b\"\nstiffness = 5.0\nrest_length = 0.0\ndamping = 0.1\n"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_DOUBLE_EQ(*loaded.scene->springs[0].rest_length, 0.3);
  EXPECT_EQ(loaded.scene->springs[0].a, "world");
  EXPECT_DOUBLE_EQ(*loaded.scene->springs[1].rest_length, 0);
}

TEST(SceneTerms, BadSpringsAreRefused) {
  EXPECT_THAT(errors_of(table("spring", "s", "b = \"x\"\nstiffness = 1.0\n")),
              ElementsAre(AllOf(HasSubstr("'b'"), HasSubstr("is \"x\", which is not a body"))));
  EXPECT_THAT(errors_of(table("spring", "s", "a = \"b\"\nb = \"b\"\nstiffness = 1.0\n")),
              ElementsAre(HasSubstr("is the body of the other end")));
  EXPECT_THAT(errors_of(table("spring", "s", "b = \"b\"\n")), ElementsAre(HasSubstr("stiffness")));
  EXPECT_THAT(errors_of(table("spring", "s", "b = \"b\"\nstiffness = 1.0\n") +
                        table("force", "s", "body = \"b\"\nforce = [1.0, 0.0, 0.0]\n")),
              ElementsAre(HasSubstr("is the name of an earlier joint, spring, force or gear")));
  EXPECT_THAT(errors_of(table("force", "f", "body = \"world\"\nforce = [1.0, 0.0, 0.0]\n")),
              ElementsAre(HasSubstr("which is not a body")));
}

TEST(SceneTerms, StartPlacesTheChildAndItsChildren) {
  const LoadResult loaded =
      parse_tool(bodies() + joint("p", "slider", "world", "a", "axis = [1.0, 0.0, 0.0]\nstart = 0.2\n") +
                 joint("q", "hinge", "a", "b", "parent_position = [0.1, 0.0, 0.0]\nstart = 0.5\n"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_THAT(loaded.warnings, IsEmpty());
  const std::vector<BodyConfig>& placed = loaded.scene->bodies;
  EXPECT_LT((placed[0].X_WB.p - Vec3(0.2, 0, 0)).norm(), 1e-15);
  EXPECT_LT((placed[1].X_WB.p - Vec3(0.3, 0, 0)).norm(), 1e-15);
  EXPECT_NEAR(coordinates_at_start(placed, loaded.scene->joints[1])[0], 0.5, 1e-15);
}

TEST(SceneTerms, TwoPlacesOfABodyMustAgree) {
  const std::string placed = body("d", "position = [0.2, 0.0, 0.0]\n");
  const auto errors = [&](const std::string& start) {
    return errors_of(placed +
                     joint("p", "slider", "world", "d", "axis = [1.0, 0.0, 0.0]\nstart = " + start + "\n"));
  };
  EXPECT_THAT(errors("0.2"), IsEmpty());
  EXPECT_THAT(errors("0.3"), ElementsAre(HasSubstr("places body 'd' elsewhere than its own position")));
  EXPECT_THAT(errors_of(joint("p", "ball", "world", "a", "start = 0.1\n")),
              ElementsAre(HasSubstr("has no meaning for a joint without named coordinates")));
  EXPECT_THAT(errors_of(joint("p", "hinge", "world", "a", "start_second = 0.1\n")),
              ElementsAre(HasSubstr("has no meaning for a joint of one coordinate")));
}

TEST(SceneTerms, GearHoldsTheCoordinatesOfTheStart) {
  const std::string joints = joint("p", "hinge", "world", "a", "start = 0.4\n") +
                             joint("q", "hinge", "world", "b", "start = -0.1\n");
  const auto gear = [&](const std::string& keys) {
    return parse_tool(bodies() + joints + table("gear", "g", "a = \"p\"\nb = \"q\"\nratio = 0.5\n" + keys));
  };
  const LoadResult loaded = gear("");
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_NEAR(*loaded.scene->gears[0].offset, -0.3, 1e-15);
  EXPECT_THAT(gear("offset = -0.3\n").errors, IsEmpty());
  EXPECT_THAT(
      gear("offset = 0.0\n").errors,
      ElementsAre(AllOf(HasSubstr("is 0, but the bodies are placed with -0.3"), HasSubstr("`start`"))));
  EXPECT_THAT(gear("offset = 0.0\nstiffness = 3.0\n").errors, IsEmpty())
      << "a compliant gear may start loaded";
}

TEST(SceneTerms, BadGearsAreRefused) {
  const auto errors = [&](const std::string& keys) { return errors_of(hinges() + table("gear", "g", keys)); };
  EXPECT_THAT(errors("a = \"p\"\nb = \"r\"\nratio = 1.0\n"), ElementsAre(HasSubstr("\"r\"")));
  EXPECT_THAT(errors("a = \"p\"\nb = \"p\"\nratio = 1.0\n"), ElementsAre(HasSubstr("the same coordinate")));
  EXPECT_THAT(errors("a = \"p\"\nb = \"q\"\nratio = 0.0\n"), ElementsAre(HasSubstr("[[joint.spring]]")));
  EXPECT_THAT(errors("a = \"p\"\nb = \"q\"\nratio = 1.0\ndamping = 1.0\n"),
              ElementsAre(HasSubstr("has no effect on a rigid gear")));
  EXPECT_THAT(errors("a = \"p\"\nb = \"q\"\n"), ElementsAre(HasSubstr("ratio")));
}

TEST(SceneTerms, AJointOfAnUnknownBodyIsTheOnlyError) {
  for (const std::string child : {"x", "world", ""})
    for (const std::string start : {"", "start = 0.4\n"}) {
      const std::string joints =
          joint("p", "hinge", "world", "a", start) + joint("q", "hinge", "world", child, start);
      const std::string gear = table("gear", "g", "a = \"p\"\nb = \"q\"\nratio = 0.5\n");
      EXPECT_THAT(errors_of(joints + gear), ElementsAre(HasSubstr("child"))) << child << start;
    }
}

TEST(SceneTerms, AnEmptyNameIsNoBody) {
  for (const char* end : {"a = \"\"\nb = \"b\"\n", "a = \"a\"\nb = \"\"\n"})
    EXPECT_THAT(errors_of(table("spring", "s", std::string(end) + "stiffness = 1.0\n")),
                ElementsAre(HasSubstr("not a body")));
  EXPECT_THAT(errors_of(table("force", "f", "body = \"\"\nforce = [1.0, 0.0, 0.0]\n")),
              ElementsAre(HasSubstr("not a body")));
}

TEST(SceneTerms, JointSpringsActOnOneCoordinate) {
  const std::string spring = "[[joint.spring]]\nstiffness = 2.0\nrest = 0.3\n";
  const LoadResult loaded = parse_tool(bodies() + joint("p", "hinge", "world", "a", spring));
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_EQ(loaded.scene->joints[0].springs[0].coordinate, "p");
  EXPECT_THAT(errors_of(joint("p", "hinge", "world", "a", spring + spring)),
              ElementsAre(HasSubstr("has an earlier spring")));
  EXPECT_THAT(errors_of(joint("p", "ball", "world", "a", spring)),
              ElementsAre(HasSubstr("has no coordinate for a spring")));
}

TEST(SceneTerms, LastJointOfALoopClosesIt) {
  const std::string chain =
      joint("p", "hinge", "world", "a") + joint("q", "hinge", "a", "b") + joint("r", "hinge", "b", "c");
  const LoadResult loaded = parse_tool(bodies() + chain + joint("s", "hinge", "world", "c"));
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_EQ(loaded.scene->joints.size(), 3u);
  ASSERT_EQ(loaded.scene->loops.size(), 1u);
  EXPECT_EQ(loaded.scene->loops[0].name, "s");
  EXPECT_THAT(errors_of(chain + joint("s", "hinge", "world", "c", "parent_position = [0.01, 0.0, 0.0]\n")),
              ElementsAre(AllOf(HasSubstr("'s' closes a loop"), HasSubstr("0.01 m and 0 rad apart"))));
  EXPECT_THAT(errors_of(chain + joint("s", "hinge", "world", "c",
                                      "[[joint.stop]]\nlower = 0.0\nstiffness = 1.0\nwidth = 0.1\n")),
              ElementsAre(AllOf(HasSubstr("closes a loop with joints \"p\", \"q\", \"r\""),
                                HasSubstr("list it before one of the others"))));
}

TEST(SceneTerms, FreedomsAndRedundantConstraintsAreCounted) {
  const auto of = [](const std::string& name) { return mobility_at_start(load_shipped(name)); };
  const Mobility four_bar = of("four-bar.toml");  // a plane loop of hinges: two rows count of five
  EXPECT_EQ(four_bar.num_freedoms, 1u);
  EXPECT_EQ(four_bar.num_constraints, 5u);
  EXPECT_EQ(four_bar.num_redundant, 3u);
  const Mobility scissors = of("scissors.toml");
  EXPECT_EQ(scissors.num_freedoms, 1u);
  EXPECT_EQ(scissors.num_constraints, 2u);
  EXPECT_EQ(scissors.num_redundant, 0u);
  const Mobility driver = of("needle-driver.toml");  // roll, pitch, yaw, grip, and a free needle
  EXPECT_EQ(driver.num_freedoms, 4u + 6u);
  EXPECT_EQ(of("pendulum.toml").num_freedoms, 1u);
}

TEST(SceneTerms, AreWrittenAsTheyAreRead) {
  const std::string text =
      bodies() + joint("p", "hinge", "world", "a", "start = 0.4\n[[joint.spring]]\nstiffness = 2.0\n") +
      joint("q", "hinge", "a", "b") + joint("r", "hinge", "b", "c") + joint("s", "hinge", "a", "c") +
      table("spring", "k", "b = \"b\"\nposition_a = [0.0, 0.0, 0.3]\nstiffness = 50.0\n") +
      table("force", "f", "body = \"b\"\nforce = [1.0, 0.0, 0.0]\n") +
      table("gear", "g", "a = \"p\"\nb = \"q\"\nratio = 0.5\n");
  LoadResult loaded = parse_tool(text);
  ASSERT_THAT(loaded.errors, IsEmpty());
  const std::string written = effective_config_toml(*loaded.scene);
  const LoadResult again = parse_scene(written, "again.toml");
  ASSERT_THAT(again.errors, IsEmpty()) << written;
  EXPECT_EQ(effective_config_toml(*again.scene), written);
  EXPECT_EQ(again.scene->loops.size(), 1u);
  EXPECT_EQ(again.scene->gears.size() + again.scene->springs.size() + again.scene->forces.size(), 3u);
  EXPECT_EQ(term_names(*again.scene), (std::vector<std::string>{"k", "g", "s"}));
}

}  // namespace
}  // namespace godobject::test::test_scene_terms
