// Contacts in scene files: the core gets their values, and errors are reported with their place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "platform/scene/contact/params.h"
#include "platform/scene/toml.h"

namespace godobject::test_contact_scene {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string scene_and_brick = R"([scene]
name = "test"

[[body]]
name = "brick"
mass = 0.0025
inertia = [7e-8, 2e-7, 2.6e-7]
position = [0, 0, 0.1]

[[body.sphere]]
position = [-0.01, 0, 0]
radius = 0.002
material = "plastic"
count = 3
spacing = [0.01, 0, 0]

[[body.shape]]
kind = "box"
half_extents = [0.016, 0.008, 0.005]
material = "plastic"
)";

const std::string board = R"(
[[obstacle]]
name = "board"
kind = "plane"
material = "wood"
)";

std::string contact(const std::string& a, const std::string& b, const std::string& more = "") {
  return "\n[[contact]]\nmaterials = [\"" + a + "\", \"" + b + "\"]\nstiffness = 1000\n" + more;
}

const std::string brick_on_board = scene_and_brick + board + contact("wood", "plastic", "friction = 0.3\n");

/// Parses text as a scene in the directory of tests, where its files are.
LoadResult parse(const std::string& text) { return parse_scene(text, testing::TempDir() + "/a.toml"); }

SceneConfig loaded(const std::string& text) {
  const LoadResult result = parse(text);
  EXPECT_THAT(result.errors, IsEmpty());
  EXPECT_THAT(result.warnings, IsEmpty());
  return result.scene.value_or(SceneConfig{});
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

/// Writes a file with this text to the directory of tests and returns its name.
std::string written(const std::string& name, const std::string& text) {
  const std::string file = "godobject_" + name;
  std::ofstream(testing::TempDir() + "/" + file) << text;
  return file;
}

TEST(ContactScene, TellsTheCoreSpheresSurfacesAndLaws) {
  const SceneContacts contacts = scene_contacts(loaded(brick_on_board));
  ASSERT_EQ(contacts.spheres.size(), 3u);
  EXPECT_EQ(contacts.spheres[0].p_B, Vec3(-0.01, 0, 0));
  EXPECT_EQ(contacts.spheres[2].p_B, Vec3(0.01, 0, 0));
  EXPECT_EQ(contacts.spheres[2].radius, 0.002);
  ASSERT_EQ(contacts.surfaces.size(), 2u) << "the plane, and the brick's box, which boxes of the world meet";
  EXPECT_EQ(contacts.surfaces[0].body, world);
  EXPECT_EQ(contacts.surfaces[0].shape.kind, ShapeKind::plane);
  const ContactLaw law = contacts.laws[contacts.surfaces[0].material][contacts.spheres[0].material];
  EXPECT_EQ(law.k, 1000);
  EXPECT_EQ(law.c, 0);
  EXPECT_EQ(law.ratio, 1.4);
  EXPECT_EQ(law.mu, 0.3);
  EXPECT_EQ(law.k_t, law.k);
  EXPECT_EQ(law.c_t, 0);
  EXPECT_EQ(law.ratio_t, 1.4);
  EXPECT_EQ(contacts.laws[contacts.spheres[0].material][contacts.surfaces[0].material], law);
}

TEST(ContactScene, DampingAndTangentAreTakenAsGiven) {
  const SceneConfig scene = loaded(
      scene_and_brick + board +
      contact("wood", "plastic",
              "damping = 3\ntangential_stiffness = 7\ntangential_damping = 0\npush_out_speed = 0.2\n"));
  const ContactLaw law = scene_contacts(scene).laws[0][1];
  EXPECT_EQ(law.c, 3);
  EXPECT_EQ(law.k_t, 7);
  EXPECT_EQ(law.c_t, 0);
  EXPECT_EQ(law.ratio, 0);
  EXPECT_EQ(law.ratio_t, 0);
  EXPECT_EQ(law.push_out, 0.2);
}

TEST(ContactScene, DampingIsGivenAsANumberOrAsARatio) {
  const auto law_with = [](const std::string& keys) {
    return scene_contacts(loaded(scene_and_brick + board + contact("wood", "plastic", keys))).laws[0][1];
  };
  struct Case {
    std::string keys;
    double c, ratio, c_t, ratio_t;
  };
  for (const Case& of : {Case{"damping = 3\n", 3, 0, 3, 0}, Case{"damping_ratio = 3\n", 0, 3, 0, 3},
                         Case{"tangential_damping = 3\n", 0, 1.4, 3, 0},
                         Case{"damping = 3\ntangential_damping_ratio = 2\n", 3, 0, 0, 2},
                         Case{"damping_ratio = 0\n", 0, 0, 0, 0}}) {
    const ContactLaw law = law_with(of.keys);
    EXPECT_EQ(law.c, of.c) << of.keys;
    EXPECT_EQ(law.ratio, of.ratio) << of.keys;
    EXPECT_EQ(law.c_t, of.c_t) << of.keys;
    EXPECT_EQ(law.ratio_t, of.ratio_t) << of.keys;
  }
}

TEST(ContactScene, LikeTakesAllButNamePlaceAndVelocity) {
  const std::string like = "\n[[body]]\nname = \"b2\"\nlike = \"brick\"\nposition = [0, 0, 0.2]\n";
  const SceneConfig scene = loaded(replaced(brick_on_board, "\n[[obstacle]]", like + "\n[[obstacle]]") +
                                   contact("plastic", "plastic"));
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[1].name, "b2");
  EXPECT_EQ(scene.bodies[1].mass, 0.0025);
  EXPECT_EQ(scene.bodies[1].inertia, scene.bodies[0].inertia);
  EXPECT_EQ(scene.bodies[1].X_WB.p.z(), 0.2);
  ASSERT_EQ(scene.bodies[1].spheres.size(), 1u);
  ASSERT_EQ(scene.bodies[1].shapes.size(), 1u);
  const SceneContacts contacts = scene_contacts(scene);
  ASSERT_EQ(contacts.spheres.size(), 6u);
  EXPECT_EQ(contacts.spheres[3].body, 1u);
  ASSERT_EQ(contacts.surfaces.size(), 3u);
  EXPECT_EQ(contacts.surfaces[1].body, 0u);
  EXPECT_EQ(contacts.surfaces[2].body, 1u);
}

TEST(ContactScene, LikeReplacesWhatIsGiven) {
  const std::string like =
      "\n[[body]]\nname = \"b2\"\nlike = \"brick\"\nmass = 0.003\n\n[[body.sphere]]\nradius = 0.005\n"
      "material = \"plastic\"\n";
  const SceneConfig scene = loaded(replaced(brick_on_board, "\n[[obstacle]]", like + "\n[[obstacle]]") +
                                   contact("plastic", "plastic"));
  EXPECT_EQ(scene.bodies[1].mass, 0.003);
  ASSERT_EQ(scene.bodies[1].spheres.size(), 1u);
  EXPECT_EQ(scene.bodies[1].spheres[0].radius, 0.005);
  EXPECT_EQ(scene.bodies[1].shapes.size(), 1u);
}

TEST(ContactScene, LikeNeedsAnEarlierBody) {
  EXPECT_THAT(
      parse(scene_and_brick + "\n[[body]]\nname = \"b2\"\nlike = \"block\"\n").errors,
      ElementsAre(AllOf(HasSubstr("a.toml:24:"),
                        HasSubstr("\"block\", which is not an earlier body: name a body above this one"))));
  EXPECT_THAT(parse(scene_and_brick + "\n[[body]]\nname = \"b2\"\nlike = \"b2\"\n").errors,
              ElementsAre(HasSubstr("which is not an earlier body")));
}

TEST(ContactScene, EffectiveConfigurationReadsBackAsTheSame) {
  const std::string centres = written("centres.csv", "x,y,z\n0,0,0\n0.1,0,0\n");
  const SceneConfig scene =
      loaded(brick_on_board +
             "\n[[obstacle]]\nname = \"peg\"\nkind = \"capsule\"\nradius = 0.01\nhalf_length = 0.05\n"
             "material = \"wood\"\n\n[[obstacle]]\nname = \"organ\"\nkind = \"sphere\"\nradius = 0.02\n"
             "material = \"wood\"\nfile = \"" +
             centres + "\"\n");
  const std::string text = effective_config_toml(scene);
  const SceneConfig again = loaded(text);
  EXPECT_EQ(effective_config_toml(again), text);
  EXPECT_EQ(again.bodies[0].spheres[0].count, 3);
  EXPECT_EQ(again.obstacles[2].centres.size(), 2u);
  EXPECT_EQ(again.contacts[0].law, scene.contacts[0].law);
}

TEST(ContactScene, APairWithoutALawIsNamedWithItsUses) {
  EXPECT_THAT(parse(scene_and_brick + board).errors,
              ElementsAre(AllOf(HasSubstr("a.toml:1:"), HasSubstr("'plastic' (sphere of body 'brick')"),
                                HasSubstr("'wood' (obstacle 'board')"),
                                HasSubstr("materials = [\"plastic\", \"wood\"]"))));
}

TEST(ContactScene, SpheresOfOneToolDoNotMeet) {
  const std::string second =
      "\n[[body]]\nname = \"b2\"\nlike = \"brick\"\n\n[[body]]\nname = \"b3\"\nlike = \"brick\"\n";
  const std::string bodies = replaced(brick_on_board, "\n[[obstacle]]", second + "\n[[obstacle]]");
  const auto joint = [](const std::string& name, const std::string& parent, const std::string& child) {
    return "\n[[joint]]\nname = \"" + name + "\"\nkind = \"ball\"\nparent = \"" + parent + "\"\nchild = \"" +
           child + "\"\nparent_position = [0, 0, 0]\n";
  };
  const auto scope = [](const std::string& text) {
    const LoadResult result = parse(text);
    EXPECT_THAT(result.errors, IsEmpty());
    return contact_scope(result.scene.value());
  };
  const std::string tool = joint("j1", "b3", "b2") + joint("j2", "b2", "brick");
  EXPECT_EQ(scope(bodies + tool), ContactScope::obstacles) << "no law of plastic against plastic is needed";
  EXPECT_THAT(parse(bodies).errors, ElementsAre(HasSubstr("'plastic' (shape of body 'b2')")));
  const std::string hung =
      joint("j1", "world", "b2") + joint("j2", "world", "brick") + contact("plastic", "plastic");
  EXPECT_EQ(scope(bodies + hung), ContactScope::bodies) << "joined through the world only";
  EXPECT_EQ(scope(scene_and_brick), ContactScope::none);
}

TEST(ContactScene, RestitutionSetsTheDamping) {
  const auto damping_at = [](const std::string& key) {
    return scene_contacts(loaded(scene_and_brick + board + contact("wood", "plastic", key))).laws[0][1].ratio;
  };
  EXPECT_NEAR(damping_at("restitution = 1\n"), 0, 1e-12);
  // critical damping, c = 2 sqrt(k m), leaves exp(-2)
  EXPECT_NEAR(damping_at("restitution = 0.1353352832366127\n"), 2, 1e-5);
  EXPECT_GT(damping_at("restitution = 0.1\n"), damping_at("restitution = 0.2\n"));
  EXPECT_TRUE(std::isfinite(damping_at("restitution = 1e-9\n")));
}

TEST(ContactScene, WrongContactsAreRefused) {
  const auto errors = [](const std::string& more) { return parse(scene_and_brick + board + more).errors; };
  EXPECT_THAT(errors(contact("wood", "plastic") + contact("plastic", "wood")),
              ElementsAre(HasSubstr("'materials' are those of an earlier [[contact]]")));
  EXPECT_THAT(
      errors(contact("wood", "plastic", "friction = 1\ntangential_stiffness = 0\ntangential_damping = 0\n")),
      ElementsAre(HasSubstr("must not both be zero if friction is above 0")));
  EXPECT_THAT(errors(replaced(contact("wood", "plastic"), "1000", "0")),
              ElementsAre(AllOf(HasSubstr("'stiffness' is 0,"), HasSubstr("> 0 (N/m)"))));
  for (const char* damping : {"damping = 1\n", "damping_ratio = 1\n"})
    EXPECT_THAT(errors(contact("wood", "plastic", std::string("restitution = 0.5\n") + damping)),
                ElementsAre(HasSubstr("'restitution' sets the damping")));
  for (const char* restitution : {"restitution = 0\n", "restitution = 1.5\n", "restitution = -1\n"})
    EXPECT_THAT(errors(contact("wood", "plastic", restitution)), ElementsAre(HasSubstr("'restitution' is")));
  EXPECT_THAT(parse(brick_on_board + contact("wood", "plstic")).warnings,
              ElementsAre(HasSubstr("has 'plstic', which no sphere, shape, obstacle or net has")));
}

TEST(ContactScene, DimensionsBelongToTheKind) {
  const auto errors = [](const std::string& keys) {
    return parse(replaced(brick_on_board, "kind = \"plane\"\n", keys)).errors;
  };
  EXPECT_THAT(errors("kind = \"sphere\"\n"), ElementsAre(HasSubstr("'radius' is missing")));
  EXPECT_THAT(errors("kind = \"plane\"\nradius = 1\n"),
              ElementsAre(AllOf(HasSubstr("a.toml:25:"), HasSubstr("'radius' has no meaning"))));
  EXPECT_THAT(errors("kind = \"box\"\nhalf_extents = [1, 0, 1]\n"),
              Contains(HasSubstr("out of range: admissible is > 0 (m)")));
  EXPECT_THAT(errors("kind = \"mesh\"\n"), ElementsAre(HasSubstr("'file' is missing")));
  EXPECT_THAT(errors("kind = \"cube\"\n"), Contains(HasSubstr("\"cube\"; admissible is \"plane\", \"box\"")));
  EXPECT_THAT(parse(replaced(scene_and_brick, "kind = \"box\"", "kind = \"mesh\"")).errors,
              ElementsAre(HasSubstr("admissible is \"box\", \"sphere\", \"capsule\"")));
}

TEST(ContactScene, AtMostEightMaterials) {
  std::string text = scene_and_brick + board + contact("wood", "plastic");
  for (int i = 0; i < 7; ++i) {
    const std::string name = "m" + std::to_string(i);
    text += "\n[[obstacle]]\nname = \"" + name + "\"\nkind = \"plane\"\nmaterial = \"" + name + "\"\n" +
            contact(name, "plastic");
  }
  EXPECT_THAT(parse(text).errors, ElementsAre(HasSubstr("has 9 materials; at most 8")));
}

TEST(ContactScene, FilesAreRelativeToTheScene) {
  written("heights.csv", "0, 0.1, 0\n0, 0.2, 0\n");
  const std::string scene_file = testing::TempDir() + "/scene.toml";
  const std::string text =
      replaced(brick_on_board, "kind = \"plane\"",
               "kind = \"height-field\"\nspacing = 0.5\nfile = \"godobject_heights.csv\"");
  const LoadResult result = parse_scene(text, scene_file);
  ASSERT_THAT(result.errors, IsEmpty());
  const SceneContacts contacts = scene_contacts(*result.scene);
  ASSERT_EQ(contacts.surfaces.size(), 2u);
  ASSERT_TRUE(is_valid(contacts.surfaces[0].shape));
  EXPECT_EQ(contacts.surfaces[0].shape.height_field->columns, 3u);
  EXPECT_EQ(contacts.surfaces[0].shape.height_field->point(1, 1), Vec3(0.5, 0.5, 0.2));
  EXPECT_THAT(parse_scene(replaced(text, "godobject_heights", "godobject_nothing"), scene_file).errors,
              ElementsAre(AllOf(HasSubstr("scene.toml:26:"), HasSubstr("'file' cannot be read"))));
}

TEST(ContactScene, ManySpheresFromOneFile) {
  const std::string centres = written("centres.csv", "x,y,z\n0,0,0\n0.1,0,0\n0,0.2,0\n");
  const std::string text =
      replaced(brick_on_board, "kind = \"plane\"",
               "kind = \"sphere\"\nradius = 0.05\nposition = [0, 0, 1]\n"
               "orientation_wxyz = [0.7071067811865476, 0, 0, 0.7071067811865476]\nfile = \"" +
                   centres + "\"");
  const SceneContacts contacts = scene_contacts(loaded(text));
  ASSERT_EQ(contacts.surfaces.size(), 4u);
  EXPECT_TRUE(contacts.surfaces[1].shape.X_WS.p.isApprox(Vec3(0, 0.1, 1), 1e-12));
  EXPECT_TRUE(contacts.surfaces[2].shape.X_WS.p.isApprox(Vec3(-0.2, 0, 1), 1e-12));
  EXPECT_EQ(contact_counts(loaded(text)).surfaces, 4u);
  EXPECT_EQ(contact_counts(loaded(text)).spheres, 3u);
}

}  // namespace
}  // namespace godobject::test_contact_scene
