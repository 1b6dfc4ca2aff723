// Shapes that touch meshes only by points and spheres, spheres that start within a solid, and the warnings of
// `check` about both.
#include "platform/scene/checks.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/scene/contact/params.h"
#include "tests/support/contact_config.h"

namespace godobject::test_spheres_alone {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const Vec3 half(0.05, 0.04, 0.005);
constexpr double r = 0.002;  // m

/// Returns a tray of one box with a sphere at each corner, tangent to its faces.
BodyConfig tray() {
  BodyConfig body = body_of("tray", 1, 1e-3);
  body.shapes.resize(1);
  body.shapes[0].kind = ShapeKind::box;
  body.shapes[0].half_extents = half;
  for (int k = 0; k < 8; ++k)
    body.spheres.push_back(sphere_of(
        r, (half - Vec3::Constant(r)).cwiseProduct(Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1))));
  return body;
}
/// Returns a body of one ball shape. with_sphere: true for a sphere of the same size in it.
BodyConfig ball(double radius, bool with_sphere) {
  BodyConfig body = body_of("ball", 1, 1e-3);
  body.shapes.resize(1);
  body.shapes[0].kind = ShapeKind::sphere;
  body.shapes[0].radius = radius;
  if (with_sphere) body.spheres.push_back(sphere_of(radius));
  return body;
}
SceneConfig scene_of(BodyConfig body, ShapeKind obstacle) {
  SceneConfig scene;
  scene.bodies.push_back(std::move(body));
  scene.bodies[0].X_WB.p = Vec3(0, 0, 1);
  scene.obstacles.push_back(obstacle_of("post", obstacle));
  scene.obstacles[0].shape.radius = 0.02;
  scene.obstacles[0].shape.half_length = 0.02;
  scene.obstacles[0].shape.half_extents = Vec3::Constant(0.02);
  scene.contacts.push_back(default_contact(2e4));
  return scene;
}

TEST(SpheresAlone, ATrayOnAMeshIsPromisedNothing) {
  const SceneConfig scene = scene_of(tray(), ShapeKind::mesh);
  const std::vector<SpheresAlone> alone = spheres_alone(scene);
  ASSERT_THAT(alone, SizeIs(1));
  EXPECT_EQ(alone[0].body, "tray");
  EXPECT_EQ(alone[0].other, "obstacle 'post'");
  EXPECT_THAT(what_does_not_pass(scene), HasSubstr("shapes against meshes excepted"));
  EXPECT_THAT(spheres_alone(scene_of(tray(), ShapeKind::height_field)), SizeIs(1));
}

TEST(SpheresAlone, ATrayOnAPostIsPromisedASpeed) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box}) {
    const SceneConfig scene = scene_of(tray(), kind);
    EXPECT_THAT(spheres_alone(scene), IsEmpty());
    const std::optional<SpeedBound> bound = top_speed(scene);
    ASSERT_TRUE(bound);
    // the post's points go through the thin tray, or the tray's spheres through the post
    const double post = kind == ShapeKind::box ? 0 : 0.02;
    EXPECT_NEAR(bound->travel, std::min({post + half.z(), 0.02, r + 0.02}) / scene.step, 1e-9);
    EXPECT_STREQ(what_does_not_pass(scene), "nothing");
  }
}

TEST(SpheresAlone, AShapeMeetsAPlaneWithoutSpheres) {
  SceneConfig scene = scene_of(tray(), ShapeKind::plane);
  EXPECT_THAT(spheres_alone(scene), IsEmpty());
  EXPECT_STREQ(what_does_not_pass(scene), "nothing");
  EXPECT_EQ(top_speed_text(scene), "no limit: only planes can be touched, and they have no other side");
  scene.bodies[0].spheres.clear();
  EXPECT_THAT(spheres_alone(scene), IsEmpty());
  EXPECT_EQ(contact_scope(scene), ContactScope::obstacles);
}

TEST(SpheresAlone, OtherPairsKeepTheirPromise) {
  SceneConfig scene = scene_of(tray(), ShapeKind::mesh);
  scene.bodies.push_back(body_of("tool", 0.1, 1e-5));
  scene.bodies[1].spheres.push_back(sphere_of(0.005));
  EXPECT_THAT(spheres_alone(scene), SizeIs(1));
  EXPECT_THAT(what_does_not_pass(scene), HasSubstr("nothing (shapes against meshes excepted)"));
}

TEST(SpheresAlone, AShapeWithinASphereMeetsAll) {
  EXPECT_THAT(spheres_alone(scene_of(ball(0.01, true), ShapeKind::mesh)), IsEmpty());
  EXPECT_THAT(spheres_alone(scene_of(ball(0.01, false), ShapeKind::mesh)), IsEmpty()) << "its centre touches";
  BodyConfig only_spheres = tray();
  only_spheres.shapes.clear();
  EXPECT_THAT(spheres_alone(scene_of(only_spheres, ShapeKind::mesh)), IsEmpty());
  BodyConfig within = tray();
  within.spheres = {sphere_of(half.norm())};
  EXPECT_THAT(spheres_alone(scene_of(within, ShapeKind::mesh)), IsEmpty());
  within.spheres = {sphere_of(0.99 * half.norm())};
  EXPECT_THAT(spheres_alone(scene_of(within, ShapeKind::mesh)), SizeIs(1));
}

TEST(SpheresAlone, ShapesWithoutSpheresNeedALawForTheirMaterial) {
  SceneConfig scene;
  scene.bodies = {ball(0.01, false), tray()};
  scene.bodies[0].shapes[0].material = "glass";
  scene.bodies[1].spheres.clear();
  EXPECT_EQ(contact_scope(scene), ContactScope::bodies);
  const std::vector<MaterialPair> pairs = pairs_that_meet(scene);
  ASSERT_THAT(pairs, SizeIs(1));
  EXPECT_EQ(pairs[0].a.material, "glass");
}

TEST(SpheresAlone, SpheresThatBeginInASolidAreFound) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box, ShapeKind::plane}) {
    BodyConfig tool = body_of("tool", 0.1, 1e-5);
    tool.spheres.push_back(sphere_of(0.005));
    SceneConfig scene = scene_of(tool, kind);
    EXPECT_EQ(buried_solids(scene).num, 0u);
    // its highest point is at 0.02 along x in the frame of all but the plane
    const Vec3 out = kind == ShapeKind::plane ? Vec3(0, 0, 0) : Vec3(0.02, 0, 0);
    const Vec3 n = kind == ShapeKind::plane ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
    scene.bodies[0].X_WB.p = out + 0.001 * n;
    EXPECT_EQ(buried_solids(scene).num, 0u) << "deep, its centre outside";
    scene.bodies[0].X_WB.p = out - 0.003 * n;
    const BuriedSolids buried = buried_solids(scene);
    EXPECT_EQ(buried.num, 1u);
    EXPECT_NEAR(buried.depth, 0.008, 1e-9);
    EXPECT_EQ(buried.deepest, "sphere of body 'tool' in obstacle 'post'");
  }
}

TEST(SpheresAlone, SpheresOfATurnedBodyThatBeginInAnotherBodyAreFound) {
  SceneConfig scene;
  scene.bodies = {tray(), body_of("tool", 0.1, 1e-5)};
  scene.contacts.push_back(default_contact(2e4));
  scene.bodies[0].X_WB = {.p = Vec3(1, 2, 3), .q = Quat(Eigen::AngleAxisd(1, Vec3(1, 2, 3).normalized()))};
  scene.bodies[1].spheres.push_back(sphere_of(0.004, Vec3(0, 0, 0.1)));
  scene.bodies[1].X_WB.q = Quat(Eigen::AngleAxisd(2, Vec3::UnitX()));
  const auto put = [&](const Vec3& p) {
    scene.bodies[1].X_WB.p =
        scene.bodies[0].X_WB.p + scene.bodies[0].X_WB.q * p - scene.bodies[1].X_WB.q * Vec3(0, 0, 0.1);
  };
  put(Vec3(0.03, 0, half.z() + 1e-4));
  EXPECT_EQ(buried_solids(scene).num, 0u);
  put(Vec3(0.03, 0, half.z() - 1e-4));
  EXPECT_EQ(buried_solids(scene).num, 1u);
  EXPECT_NEAR(buried_solids(scene).depth, 0.0041, 1e-9);
}

TEST(SpheresAlone, ShapesThatBeginInASolidAreFound) {
  for (const ShapeKind own : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box})
    for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box, ShapeKind::plane}) {
      BodyConfig tool = body_of("tool", 0.1, 1e-5);
      ShapeConfig shape;
      shape.kind = own;
      if (own == ShapeKind::box) shape.half_extents = Vec3(0.002, 0.003, 0.004);
      else shape.radius = 0.002;
      if (own == ShapeKind::capsule) shape.half_length = 0.004;
      tool.shapes.push_back(shape);
      SceneConfig scene = scene_of(tool, kind);
      EXPECT_EQ(buried_solids(scene).num, 0u);
      // its highest point is at 0.02 along x in the frame of all but the plane
      const bool is_plane = kind == ShapeKind::plane;
      const Vec3 n = is_plane ? Vec3(0, 0, 1) : Vec3(1, 0, 0), out = (is_plane ? 0 : 0.02) * n;
      const double half = !is_plane || own == ShapeKind::sphere ? 0.002
                          : own == ShapeKind::box               ? 0.004
                                                                : 0.006;
      scene.bodies[0].X_WB.p = out + (half - 0.001) * n;
      EXPECT_EQ(buried_solids(scene).num, 0u) << "touches, with no centre inside";
      scene.bodies[0].X_WB.p = out - 0.003 * n;
      const BuriedSolids buried = buried_solids(scene);
      EXPECT_EQ(buried.num, 1u);
      EXPECT_GE(buried.depth, 0.003 + 0.99 * half);
      EXPECT_EQ(buried.deepest, "shape of body 'tool' in obstacle 'post'");
    }
}

}  // namespace
}  // namespace godobject::test_spheres_alone
