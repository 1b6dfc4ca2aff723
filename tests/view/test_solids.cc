// The drawn solid of a body without shapes has the body's mass and inertia.
#include "platform/view/drawing.h"

#include <gtest/gtest.h>

#include <random>

#include "platform/scene/toml.h"

namespace godobject::test_solids {
namespace {

/// Returns the principal moments of a solid of uniform density about its own axes.
Vec3 moments_of(const Solid& solid, double m) {
  const double r = solid.size.x(), l = 2 * solid.size.y();
  if (solid.kind == SolidKind::sphere) return Vec3::Constant(0.4 * m * r * r);
  if (solid.kind == SolidKind::cylinder)
    return Vec3(m * (3 * r * r + l * l) / 12, m * (3 * r * r + l * l) / 12, m * r * r / 2);
  const Vec3 sq = solid.size.cwiseAbs2();
  return m / 3 * Vec3(sq.y() + sq.z(), sq.x() + sq.z(), sq.x() + sq.y());
}

Mat3 inertia_of(const Solid& solid, double m) {
  const Mat3 R = solid.X.q.toRotationMatrix();
  return R * moments_of(solid, m).asDiagonal() * R.transpose();
}

TEST(SolidOfInertia, HasThatInertia) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> size(0.01, 0.2), number(-1, 1);
  for (int round = 0; round < 300; ++round) {
    const double m = size(random);
    Solid made{.kind = round % 3 == 0   ? SolidKind::box
                       : round % 3 == 1 ? SolidKind::cylinder
                                        : SolidKind::sphere};
    made.size = Vec3(size(random), size(random), size(random));
    made.X.q = Quat(number(random), number(random), number(random), number(random)).normalized();
    const Mat3 I = inertia_of(made, m);
    const Solid solid = solid_of_inertia(m, I);
    EXPECT_EQ(solid.role, SolidRole::inertia);
    EXPECT_NEAR((inertia_of(solid, m) - I).norm() / I.norm(), 0, 0.02) << round;
  }
}

TEST(Drawing, OfTheGrasperIsItsTube) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/grasper.toml");
  ASSERT_TRUE(loaded.scene.has_value());
  const Drawing drawing = drawing_of(*loaded.scene);
  ASSERT_EQ(drawing.solids.size(), 4u);
  EXPECT_EQ(drawing.solids[1].kind, SolidKind::cylinder);
  EXPECT_NEAR(drawing.solids[1].size.x(), 0.005, 1e-4) << "the radius of a laparoscopic instrument";
  EXPECT_NEAR(drawing.solids[1].size.y(), 0.175, 1e-4);
}

TEST(Drawing, BoundsBallsOfInertiaBesideSolidsWithAShape) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/grasper.toml");
  ASSERT_TRUE(loaded.scene.has_value());
  SceneConfig scene = *loaded.scene;
  const auto radius = [&] { return drawing_of(scene).solids.front().size.x(); };
  const Solid ball = solid_of_inertia(scene.bodies[0].mass, scene.bodies[0].inertia);
  EXPECT_NEAR(ball.size.x(), 0.0224, 1e-4) << "the trocar's, 44 mm across";
  EXPECT_LT(radius(), 0.015);
  EXPECT_GT(radius(), 0.004);
  scene.bodies[0].inertia *= 0.01;
  EXPECT_NEAR(radius(), 0.1 * ball.size.x(), 1e-9) << "small ones stay";
  scene.bodies.resize(1);
  scene.bodies[0].inertia *= 100;
  EXPECT_EQ(radius(), ball.size.x()) << "alone it is all that there is";
}

TEST(Drawing, HasEveryShapeSphereAndObstacleOfTheShippedScenes) {
  for (const char* name : {"lego", "organ", "wall", "grasp", "pendulum", "chain"}) {
    const LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + name + ".toml");
    ASSERT_TRUE(loaded.scene.has_value()) << name;
    std::size_t expected = 0;
    for (const ObstacleConfig& obstacle : loaded.scene->obstacles)
      expected += std::max<std::size_t>(1, obstacle.centres.size());
    for (const BodyConfig& body : loaded.scene->bodies) {
      expected += std::max<std::size_t>(1, body.shapes.size());
      for (const SphereConfig& row : body.spheres) expected += static_cast<std::size_t>(row.count);
    }
    EXPECT_EQ(drawing_of(*loaded.scene).solids.size(), expected) << name;
  }
}

}  // namespace
}  // namespace godobject::test_solids
