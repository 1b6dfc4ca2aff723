// Implausible units: a warning names the quantity, its unit and the bounds, for every kind of body.
#include "platform/scene/checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "platform/scene/toml.h"
#include "tests/support/mesh_files.h"

namespace godobject::test_plausible {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns a homogeneous box of 1000 kg/m^3, with quantities scaled by wrong units.
BodyConfig box_body(const Vec3& half, double mass_units = 1, double length_units = 1,
                    double inertia_units = 1) {
  BodyConfig body;
  body.name = "tool";
  body.mass = mass_units * 8 * half.prod() * 1000;
  const Vec3 squares = half.cwiseProduct(half);
  const Vec3 I = body.mass / mass_units / 3 * (Vec3::Constant(squares.sum()) - squares);
  body.inertia = inertia_units * Mat3(I.asDiagonal());
  ShapeConfig shape;
  shape.half_extents = Vec3(length_units * half);
  body.shapes = {shape};
  return body;
}

Vec3 some_half_extents(std::mt19937& random) {
  std::uniform_real_distribution<double> log_size(std::log(0.002), std::log(0.2));
  return {std::exp(log_size(random)), std::exp(log_size(random)), std::exp(log_size(random))};
}

TEST(Plausible, HomogeneousBoxesAre) {
  std::mt19937 random(1);
  for (int i = 0; i < 1000; ++i) {
    const BodyConfig body = box_body(some_half_extents(random));
    EXPECT_EQ(doubt_of_gyration(body), "");
    EXPECT_EQ(doubt_of_density(body), "");
  }
}

TEST(Plausible, GramsMillimetresAndTheirInertiasAreNot) {
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    const Vec3 half = some_half_extents(random);
    EXPECT_THAT(doubt_of_density(box_body(half, 1000, 1, 1000)), HasSubstr("a density of 1e+06 kg/m^3"));
    EXPECT_THAT(doubt_of_density(box_body(half, 1, 1000)), HasSubstr("kg/m^3"));
    EXPECT_THAT(doubt_of_gyration(box_body(half, 1, 1000)), HasSubstr("a radius of gyration of"));
    EXPECT_THAT(doubt_of_gyration(box_body(half, 1, 1, 1e4)), HasSubstr("kg m^2"));  // kg cm^2
    EXPECT_THAT(doubt_of_gyration(box_body(half, 1, 1, 1e6)), HasSubstr("kg m^2"));  // kg mm^2
    EXPECT_THAT(doubt_of_gyration(box_body(half, 1, 1, 1e-4)), HasSubstr("kg m^2"));
  }
}

/// A steel rod given by spheres along it, or by its inertia alone.
TEST(Plausible, ARodOfSpheresAndOneWithoutAny) {
  BodyConfig rod;
  rod.name = "rod";
  rod.mass = 0.08;
  rod.inertia = Vec3(8.1667e-4, 8.1667e-4, 1e-6).asDiagonal();
  EXPECT_EQ(doubt_of_density(rod), "");
  EXPECT_EQ(doubt_of_gyration(rod), "");  // it has no extent
  rod.spheres.push_back(
      {.p_B = Vec3(0, 0, -0.17), .radius = 0.005, .count = 35, .spacing = Vec3(0, 0, 0.01)});
  EXPECT_EQ(doubt_of_density(rod), "");
  EXPECT_EQ(doubt_of_gyration(rod), "");
  rod.mass *= 1e3;  // g
  EXPECT_THAT(doubt_of_density(rod), HasSubstr("body 'rod'"));
  EXPECT_EQ(doubt_of_gyration(rod), doubt_of_gyration(rod));
  rod.mass = 8e-5;  // t
  EXPECT_THAT(doubt_of_gyration(rod), HasSubstr("radius of gyration of 3.2 m"));
}

TEST(Plausible, SurfacesAndMeshes) {
  EXPECT_EQ(doubt_of_density(1, 0.005), "");
  EXPECT_THAT(doubt_of_density(101, 0.005), HasSubstr("101 kg/m^2"));
  EXPECT_THAT(doubt_of_density(1e-3, 0.005), HasSubstr("0.2 kg/m^3"));
  EXPECT_THAT(doubt_of_density(99, 0.003), HasSubstr("3.3e+04 kg/m^3"));
  EXPECT_EQ(doubt_of_density(1, 0), "");  // it has no contacts and no thickness
  MeshData mesh{.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.2, 0}}, .triangles = {{0, 1, 2}}};
  EXPECT_EQ(doubt_of_size(mesh, "obstacle 'liver'"), "");
  for (Vec3& p : mesh.vertices) p *= 1000;
  EXPECT_THAT(doubt_of_size(mesh, "obstacle 'liver'"),
              AllOf(HasSubstr("obstacle 'liver' is 200 m"), HasSubstr("scale")));
  for (Vec3& p : mesh.vertices) p *= 1e-7;
  EXPECT_THAT(doubt_of_size(mesh, "net 'bag'"), HasSubstr("net 'bag' is 2e-05 m"));
}

TEST(Plausible, WarningsOfAFileHaveTheirPlace) {
  const std::string text =
      "[scene]\nname = \"s\"\n[[body]]\nname = \"tool\"\nmass = 100.0\ninertia = [1e-5, 1e-5, 1e-5]\n"
      "[[body.sphere]]\nradius = 0.01\n";
  const LoadResult result = parse_scene(text, "a.toml");
  EXPECT_THAT(result.errors, IsEmpty());
  EXPECT_THAT(
      result.warnings,
      testing::ElementsAre(AllOf(HasSubstr("a.toml:5:8: 'mass'"), HasSubstr("kg/m^3")),
                           AllOf(HasSubstr("a.toml:6:11: 'inertia'"), HasSubstr("radius of gyration"))));
  const std::string net =
      "[scene]\nname = \"s\"\n[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [1e-3, 1e-3, 1e-3]\n"
      "[[net]]\nname = \"sheet\"\nkind = \"sheet\"\nlength = 20.0\nwidth = 20.0\nspacing = 2.0\n"
      "surface_density = 500.0\nmembrane_stiffness = 1e4\nsettling_time = 0.5\nbody = \"b\"\n";
  EXPECT_THAT(
      parse_scene(net, "n.toml").warnings,
      testing::IsSupersetOf({HasSubstr("500 kg/m^2 of surface density"), HasSubstr("net 'sheet' is 21 m")}));
}

}  // namespace
}  // namespace godobject::test_plausible
