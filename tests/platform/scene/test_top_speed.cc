// The top speed printed by check: below it a wall holds, and far above it a sphere passes through.
#include "platform/scene/checks.h"

#include "core/contact/candidates.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "platform/engine/engine.h"
#include "tests/support/contact_config.h"

namespace godobject::test_top_speed {
namespace {

using testing::HasSubstr;

constexpr double r = 0.005, wall = 0.01;  // m

/// Returns a sphere in front of a wall of 1 cm in the plane x = 0.
SceneConfig sphere_and_wall(double stiffness) {
  SceneConfig scene;
  scene.name = "wall";
  scene.bodies.push_back(body_of("tool", 0.1, 1e-5));
  scene.bodies[0].spheres.push_back(sphere_of(r));
  scene.obstacles.push_back(obstacle_of("wall", ShapeKind::box));
  scene.obstacles[0].shape.half_extents = Vec3(wall / 2, 0.5, 0.5);
  scene.contacts.push_back(default_contact(stiffness));
  return scene;
}

/// True if the tool is beyond the wall after `duration`. phase: start, in steps before the wall.
bool passes(SceneConfig scene, double speed, double phase, const char* integrator) {
  scene.integrator = integrator;
  scene.bodies[0].X_WB.p = Vec3(-0.03 - phase * speed * scene.step, 0, 0);
  scene.bodies[0].V_WB.v = Vec3(speed, 0, 0);
  std::string why_not;
  const BodySample sample;
  const std::unique_ptr<Engine> engine = make_engine(scene, {&sample, 1}, why_not);
  EXPECT_TRUE(engine) << why_not;
  if (!engine) return true;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(engine->step({&sample, 1}).fault, Fault::none);
  return engine->view(0).X_WB.p.x() > 0;
}

bool passes_at_any_phase(const SceneConfig& scene, double speed) {
  for (const char* integrator : integrator_names)
    for (double phase = 0; phase < 1; phase += 0.1)
      if (passes(scene, speed, phase, integrator)) return true;
  return false;
}

TEST(TopSpeed, IsTheSmallerOfTravelAndEnergy) {
  SceneConfig scene = sphere_and_wall(2e4);
  const SpeedBound soft = top_speed(scene).value();
  EXPECT_NEAR(soft.travel, (r + wall / 2) / 1e-3, 1e-9);
  EXPECT_NEAR(soft.energy, (r + wall / 2) * std::sqrt(2e4 / 0.1), 1e-9);
  EXPECT_EQ(soft.top(), soft.energy);
  EXPECT_EQ(soft.what, "sphere of body 'tool' and obstacle 'wall'");
  EXPECT_EQ(soft.hand, std::numeric_limits<double>::infinity()) << "no hand";
  scene.contacts[0].law.k = 1e6;
  EXPECT_EQ(top_speed(scene)->top(), top_speed(scene)->travel);
  scene.bodies[0].coupling = SpringParams{.k = 1e6};
  EXPECT_NEAR(top_speed(scene)->hand, 2 * (r + wall / 2), 1e-12);
}

TEST(TopSpeed, SaysNothingOfNodesOfNets) {
  SceneConfig scene = sphere_and_wall(2e4);
  EXPECT_STREQ(what_does_not_pass(scene), "nothing");
  const double top = top_speed(scene)->top();
  scene.nets.emplace_back().thickness = 1e-4;  // thinner than all others in the bound
  EXPECT_THAT(what_does_not_pass(scene), HasSubstr("nodes of nets"));
  EXPECT_EQ(top_speed(scene)->top(), top);
}

TEST(TopSpeed, IsThatOfTheThinnestPair) {
  SceneConfig scene = sphere_and_wall(2e4);
  scene.obstacles.push_back(obstacle_of("ground", ShapeKind::plane));
  EXPECT_THAT(top_speed(scene)->what, HasSubstr("'wall'"));
  scene.obstacles.push_back(obstacle_of("wire", ShapeKind::capsule));
  scene.obstacles[2].shape.radius = 0.001;
  scene.obstacles[2].shape.half_length = 1;
  EXPECT_THAT(top_speed(scene)->what, HasSubstr("'wire'"));
  EXPECT_NEAR(top_speed(scene)->travel, (r + 0.001) / 1e-3, 1e-9);
}

TEST(TopSpeed, OfAPrescribedBodyIsItsTravelAgainstBodiesThatItCanPush) {
  SceneConfig scene = sphere_and_wall(2e4);
  scene.bodies[0].coupling = SpringParams{.k = 1e3};
  scene.coupling = CouplingMode::imposed;
  EXPECT_FALSE(top_speed(scene)) << "no wall stops it";
  scene.obstacles.clear();  // they stop the brick
  scene.bodies.push_back(body_of("brick", 0.1, 1e-5));
  scene.bodies[1].spheres.push_back(sphere_of(0.002));
  const SpeedBound bound = top_speed(scene).value();
  EXPECT_THAT(bound.what, HasSubstr("'brick'"));
  EXPECT_EQ(bound.top(), bound.travel);
  EXPECT_NEAR(bound.travel, (0.002 + r) / 1e-3, 1e-9);
}

TEST(TopSpeed, OfTwoToolsIsThatOfTheirReducedMass) {
  SceneConfig scene = sphere_and_wall(1e4);
  scene.obstacles.clear();
  scene.bodies.push_back(scene.bodies[0]);
  scene.bodies[1].name = "other";
  scene.bodies[1].mass = 0.3;
  const SpeedBound bound = top_speed(scene).value();
  EXPECT_NEAR(bound.energy, 2 * r * std::sqrt(1e4 / 0.075), 1e-9);
  scene.joints.push_back(hinge_of("tool", "other"));
  EXPECT_FALSE(top_speed(scene)) << "one tool, and nothing to touch";
}

TEST(TopSpeed, OfBoxesOnTwoBodiesIsThatOfTheirEdges) {
  SceneConfig scene = sphere_and_wall(1e9);
  scene.bodies.push_back(body_of("brick", 0.1, 1e-5));
  for (BodyConfig& body : scene.bodies) {
    body.shapes.resize(1);
    body.shapes[0].kind = ShapeKind::box;
    body.shapes[0].half_extents = Vec3(0.02, 0.008, 0.03);
  }
  scene.bodies[1].shapes[0].half_extents = Vec3(0.004, 0.02, 0.02);
  const SpeedBound bound = top_speed(scene).value();
  EXPECT_NEAR(bound.top(), 0.3 * 0.004 / scene.step, 1e-9);
  EXPECT_EQ(bound.what, "boxes of bodies 'tool' and 'brick'");
  // at a depth of half their half thickness they are not pushed back
  scene.contacts[0].law.k = 1e3;
  scene.bodies[1].mass = 0.3;
  const SpeedBound soft = top_speed(scene).value();
  EXPECT_EQ(soft.what, bound.what);
  EXPECT_NEAR(soft.top(), 0.002 * std::sqrt(1e3 / 0.075), 1e-9);
}

TEST(TopSpeed, OfAMeshUsesItsThinnestPlace) {
  MeshData slab;
  for (int i = 0; i < 8; ++i)
    slab.vertices.emplace_back(i & 1 ? 0.01 : 0.0, i & 2 ? 1.0 : 0.0, i & 4 ? 1.0 : 0.0);
  slab.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  EXPECT_NEAR(thinnest(slab), 0.01, 1e-12);
  SceneConfig scene = sphere_and_wall(1e8);
  scene.obstacles[0].shape.kind = ShapeKind::mesh;
  scene.obstacles[0].mesh = slab;
  EXPECT_NEAR(top_speed(scene)->travel, (r + 0.005) / 1e-3, 1e-9) << "half of 1 cm";
  scene.bodies[0].spheres[0].radius = 0.001;
  EXPECT_NEAR(top_speed(scene)->travel, (0.001 + (1 + contact_reach) * 0.001) / 1e-3, 1e-9)
      << "as far as queries reach";
}

TEST(TopSpeed, AWallOfOneCentimetreHoldsAHandsSpeed) {
  const SceneConfig scene = sphere_and_wall(5e3);
  const double top = top_speed(scene)->top();
  ASSERT_GT(top, advised_top_speed);
  EXPECT_FALSE(passes_at_any_phase(scene, advised_top_speed));
  EXPECT_FALSE(passes_at_any_phase(scene, 0.99 * top));
}

TEST(TopSpeed, OfAStiffWallIsTheTravelOfAStep) {
  const SceneConfig scene = sphere_and_wall(1e7);
  const double top = top_speed(scene)->top();
  ASSERT_EQ(top, top_speed(scene)->travel);
  EXPECT_FALSE(passes_at_any_phase(scene, 0.99 * top));
}

TEST(TopSpeed, FarAboveWhatItsSpringStopsTheSpherePasses) {
  const SceneConfig soft = sphere_and_wall(5e3);
  EXPECT_TRUE(passes_at_any_phase(soft, 3 * top_speed(soft)->top()));
}

/// The motion of a step through the world is swept (decision 042), so the bound of the travel is
/// conservative.
TEST(TopSpeed, AboveTheTravelOfAStepAStiffWallHoldsAllTheSame) {
  const SceneConfig stiff = sphere_and_wall(1e7);
  const SpeedBound bound = top_speed(stiff).value();
  ASSERT_GT(bound.energy, 5 * bound.travel);
  for (const double times : {1.5, 2.0, 4.0, 8.0})
    EXPECT_FALSE(passes_at_any_phase(stiff, times * bound.travel)) << times;
}

}  // namespace
}  // namespace godobject::test_top_speed
