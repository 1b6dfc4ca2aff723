// Shapes that touch others only by the spheres of their body, spheres that start within a solid, and the
// warnings of `check` about both.
#include "platform/scene/checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/contact_config.h"

namespace godobject::test_spheres_alone {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
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

TEST(SpheresAlone, ATrayOnAPostIsPromisedNothing) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box}) {
    const SceneConfig scene = scene_of(tray(), kind);
    const std::vector<SpheresAlone> alone = spheres_alone(scene);
    ASSERT_THAT(alone, SizeIs(1));
    EXPECT_EQ(alone[0].body, "tray");
    EXPECT_EQ(alone[0].other, "obstacle 'post'");
    EXPECT_FALSE(top_speed(scene));
    EXPECT_THAT(top_speed_text(scene), HasSubstr("not bounded"));
    EXPECT_THAT(top_speed_text(scene), Not(HasSubstr("m/s")));
    EXPECT_THAT(what_does_not_pass(scene), HasSubstr("shapes that touch others only with spheres excepted"));
  }
}

TEST(SpheresAlone, SpheresAtTheCornersMeetAPlane) {
  SceneConfig scene = scene_of(tray(), ShapeKind::plane);
  EXPECT_THAT(spheres_alone(scene), IsEmpty());
  EXPECT_STREQ(what_does_not_pass(scene), "nothing");
  EXPECT_EQ(top_speed_text(scene), "no limit: only planes can be touched, and they have no other side");
  scene.bodies[0].spheres.pop_back();
  EXPECT_THAT(spheres_alone(scene), SizeIs(1)) << "one corner goes through";
  scene.bodies[0].spheres.clear();
  EXPECT_THAT(spheres_alone(scene), SizeIs(1));
}

TEST(SpheresAlone, OtherPairsKeepTheirPromise) {
  SceneConfig scene = scene_of(tray(), ShapeKind::sphere);
  scene.bodies.push_back(body_of("tool", 0.1, 1e-5));
  scene.bodies[1].spheres.push_back(sphere_of(0.005));
  ASSERT_TRUE(top_speed(scene));
  EXPECT_THAT(top_speed(scene)->what, HasSubstr("'tool'"));
  EXPECT_THAT(top_speed_text(scene),
              HasSubstr("nothing (shapes that touch others only with spheres excepted)"));
}

TEST(SpheresAlone, AShapeWithinASphereMeetsAll) {
  EXPECT_THAT(spheres_alone(scene_of(ball(0.01, true), ShapeKind::capsule)), IsEmpty());
  EXPECT_THAT(spheres_alone(scene_of(ball(0.01, false), ShapeKind::capsule)), SizeIs(1));
  BodyConfig only_spheres = tray();
  only_spheres.shapes.clear();
  EXPECT_THAT(spheres_alone(scene_of(only_spheres, ShapeKind::capsule)), IsEmpty());
}

TEST(SpheresAlone, AmongBodiesBoxesMeetEachOtherAndShapesWithinSpheresAll) {
  const auto among = [](BodyConfig a, BodyConfig b) {
    SceneConfig scene;
    scene.bodies = {std::move(a), std::move(b)};
    scene.contacts.push_back(default_contact(2e4));
    return spheres_alone(scene);
  };
  EXPECT_THAT(among(tray(), tray()), IsEmpty());
  EXPECT_THAT(among(tray(), ball(0.01, true)), IsEmpty());
  ASSERT_THAT(among(tray(), ball(0.01, false)), SizeIs(1));
  EXPECT_EQ(among(tray(), ball(0.01, false))[0].other, "the shape of body 'ball'");
  BodyConfig bare = tray();
  bare.spheres.clear();
  EXPECT_THAT(among(tray(), bare), SizeIs(1));
  BodyConfig tool = body_of("tool", 0.1, 1e-5);
  tool.spheres.push_back(sphere_of(0.005));
  EXPECT_THAT(among(bare, tool), IsEmpty()) << "spheres meet every shape";
}

TEST(SpheresAlone, SpheresThatBeginInASolidAreFound) {
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box, ShapeKind::plane}) {
    BodyConfig tool = body_of("tool", 0.1, 1e-5);
    tool.spheres.push_back(sphere_of(0.005));
    SceneConfig scene = scene_of(tool, kind);
    EXPECT_EQ(buried_spheres(scene).num, 0u);
    // its highest point is at 0.02 along x in the frame of all but the plane
    const Vec3 out = kind == ShapeKind::plane ? Vec3(0, 0, 0) : Vec3(0.02, 0, 0);
    const Vec3 n = kind == ShapeKind::plane ? Vec3(0, 0, 1) : Vec3(1, 0, 0);
    scene.bodies[0].X_WB.p = out + 0.001 * n;
    EXPECT_EQ(buried_spheres(scene).num, 0u) << "deep, its centre outside";
    scene.bodies[0].X_WB.p = out - 0.003 * n;
    const BuriedSpheres buried = buried_spheres(scene);
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
  EXPECT_EQ(buried_spheres(scene).num, 0u);
  put(Vec3(0.03, 0, half.z() - 1e-4));
  EXPECT_EQ(buried_spheres(scene).num, 1u);
  EXPECT_NEAR(buried_spheres(scene).depth, 0.0041, 1e-9);
}

}  // namespace
}  // namespace godobject::test_spheres_alone
