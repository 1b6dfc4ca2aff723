// Scenes with contacts as compiled compositions: the smallest that covers them, and its results.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>

#include "platform/engine/engine.h"
#include "tests/support/contact_config.h"

namespace godobject::test_contact_engine {
namespace {

using testing::HasSubstr;

constexpr double m = 0.1, g = 9.81, k = 5000;

/// A body on three spheres above the plane z = 0.
SceneConfig stool() {
  SceneConfig scene;
  scene.name = "stool";
  scene.gravity = Vec3(0, 0, -g);
  scene.bodies.push_back(body_of("stool", m, 1e-4));
  scene.bodies[0].X_WB.p.z() = 0.05;
  for (const Vec3& foot : {Vec3(0.05, 0, -0.04), Vec3(-0.025, 0.043, -0.04), Vec3(-0.025, -0.043, -0.04)})
    scene.bodies[0].spheres.push_back(sphere_of(0.01, foot));
  scene.obstacles.push_back(obstacle_of("ground", ShapeKind::plane));
  scene.contacts.push_back(default_contact(k));
  scene.contacts[0].law.c = scene.contacts[0].law.c_t = 20;
  scene.contacts[0].law.mu = 0.5;
  return scene;
}

std::unique_ptr<Engine> engine_of(const SceneConfig& scene) {
  std::string why_not;
  const std::vector<BodySample> samples(scene.bodies.size());
  std::unique_ptr<Engine> engine = make_engine(scene, samples, why_not);
  EXPECT_TRUE(engine) << why_not;
  return engine;
}

std::string why_none(const SceneConfig& scene) {
  std::string why_not;
  const std::vector<BodySample> samples(scene.bodies.size());
  EXPECT_EQ(make_engine(scene, samples, why_not), nullptr);
  return why_not;
}

bool has_contact_bytes(const Composition& c) {
  return std::ranges::find(c.parts, "contacts", &PartBytes::name) != c.parts.end();
}

TEST(ContactEngine, ContactsCarryTheWeightAndAreReported) {
  for (const char* integrator : integrator_names) {
    SceneConfig scene = stool();
    scene.integrator = integrator;
    const std::unique_ptr<Engine> engine = engine_of(scene);
    ASSERT_TRUE(engine);
    const BodySample none;
    StepReport report;
    for (int i = 0; i < 2000; ++i) report = engine->step({&none, 1});
    EXPECT_EQ(report.fault, Fault::none);
    EXPECT_EQ(report.contacts.num_contacts, 3u);
    EXPECT_NEAR(report.contacts.deepest, m * g / (3 * k), 2e-3 * m * g / (3 * k));
    EXPECT_LT(report.contacts.residual, 1e-5 * m * g);
    const BodyView view = engine->view(0);
    EXPECT_NEAR(view.contact_W.f.z(), m * g, 1e-4 * m * g);
    EXPECT_NEAR(view.contact_W.tau.norm(), 0, 1e-5);
  }
}

TEST(ContactEngine, ListsTheContactsThatBearAForce) {
  for (const char* integrator : integrator_names) {
    SceneConfig scene = stool();
    scene.integrator = integrator;
    const std::unique_ptr<Engine> engine = engine_of(scene);
    ASSERT_TRUE(engine);
    std::array<ContactView, 8> list;
    EXPECT_EQ(engine->contacts(list), 0u) << "before the first step";
    const BodySample none;
    for (int i = 0; i < 2000; ++i) static_cast<void>(engine->step({&none, 1}));
    ASSERT_EQ(engine->contacts(list), 3u);
    EXPECT_EQ(engine->contacts(std::span(list).first(2)), 2u) << "as far as there is room";
    Wrench sum;
    const BodyView body = engine->view(0);
    for (const ContactView& contact : std::span(list).first(3)) {
      EXPECT_EQ(contact.a, 0u);
      EXPECT_EQ(contact.b, world);
      EXPECT_EQ(contact.surface, 0u);
      EXPECT_NEAR((contact.n_W - Vec3::UnitZ()).norm(), 0, 1e-12);
      EXPECT_NEAR(contact.p_W.z(), 0, 1e-3);
      sum.f += contact.F_W;
      sum.tau += (contact.p_W - body.X_WB.p).cross(contact.F_W);
    }
    EXPECT_NEAR((sum.f - body.contact_W.f).norm(), 0, 1e-9) << integrator;
    EXPECT_NEAR((sum.tau - body.contact_W.tau).norm(), 0, 1e-6) << integrator;
  }
}

TEST(ContactEngine, EnergyHasGravityAndTheSpringsOfContacts) {
  const std::unique_ptr<Engine> engine = engine_of(stool());
  ASSERT_TRUE(engine);
  EXPECT_NEAR(engine->energy().total, m * g * 0.05, 1e-12) << "at rest in the air";
  const BodySample none;
  for (int i = 0; i < 3000; ++i) static_cast<void>(engine->step({&none, 1}));
  const double depth = m * g / (3 * k);
  const double z = engine->view(0).X_WB.p.z();
  EXPECT_NEAR(engine->energy().total, m * g * z + 3 * 0.5 * k * depth * depth,
              1e-2 * 3 * 0.5 * k * depth * depth);
}

TEST(ContactEngine, ASceneWithoutContactsHasNoneOfTheirBytes) {
  const std::unique_ptr<Engine> with = engine_of(stool());
  EXPECT_EQ(with->composition().contacts, ContactScope::obstacles);
  EXPECT_TRUE(has_contact_bytes(with->composition()));
  SceneConfig scene = stool();
  scene.obstacles.clear();
  const std::unique_ptr<Engine> without = engine_of(scene);
  EXPECT_EQ(without->composition().contacts, ContactScope::none) << "its spheres have nothing to touch";
  EXPECT_FALSE(has_contact_bytes(without->composition()));
}

TEST(ContactEngine, SaysWhichNumberIsTooLarge) {
  SceneConfig scene = stool();
  scene.bodies[0].spheres[0].count = 20000;
  EXPECT_THAT(why_none(scene), AllOf(HasSubstr("20002 spheres; the largest holds"), HasSubstr("contacts"),
                                     Not(HasSubstr("bodies;"))));
  scene = stool();
  scene.obstacles[0].shape.kind = ShapeKind::sphere;
  scene.obstacles[0].shape.radius = 0.01;
  scene.obstacles[0].centres.resize(5000, Vec3(0, 0, -1));
  EXPECT_THAT(why_none(scene), HasSubstr("5000 surfaces of obstacles and shapes; the largest holds"));
}

/// One stool on another, on a hinge.
SceneConfig hinged_stools() {
  SceneConfig scene = stool();
  scene.bodies.push_back(scene.bodies[0]);
  scene.bodies[1].name = "upper";
  scene.bodies[1].X_WB.p.z() = 0.15;
  scene.joints.push_back(hinge_of("stool", "upper"));
  scene.joints[0].X_BP.p.z() = 0.1;
  return scene;
}

TEST(ContactEngine, AnArticulatedToolTouchesObstaclesOnly) {
  SceneConfig scene = hinged_stools();
  EXPECT_EQ(engine_of(scene)->composition().contacts, ContactScope::obstacles);
  EXPECT_TRUE(engine_of(scene)->composition().joints);
}

TEST(ContactEngine, AnArticulatedToolAndAFreeBodyTouchEachOther) {
  SceneConfig scene = hinged_stools();
  scene.bodies.push_back(body_of("ball", m, 1e-5));
  scene.bodies[2].spheres.push_back(sphere_of(0.01, Vec3::Zero()));
  for (const char* name : integrator_names) {
    scene.integrator = name;
    EXPECT_EQ(engine_of(scene)->composition().contacts, ContactScope::bodies);
    EXPECT_TRUE(engine_of(scene)->composition().joints);
    EXPECT_EQ(engine_of(scene)->composition().integrator, name);
  }
}

TEST(ContactEngine, RunsAreEqualBitForBit) {
  const std::unique_ptr<Engine> a = engine_of(stool()), b = engine_of(stool());
  const BodySample none;
  for (int i = 0; i < 200; ++i) {
    static_cast<void>(a->step({&none, 1}));
    static_cast<void>(b->step({&none, 1}));
    ASSERT_EQ(a->state_hash(), b->state_hash());
  }
}

}  // namespace
}  // namespace godobject::test_contact_engine
