// A sphere on several faces of a mesh or height field. In valleys and pits it is held as by the planes of
// these faces. Forces do not jump over edges, and edges of flat surfaces are not felt.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/usual_scenes.h"
#include "tests/core/contact/valley.h"

namespace godobject::test_valleys {
namespace {

#ifdef NDEBUG
constexpr int draws = 400;
#else
constexpr int draws = 20;  // builds with assertions and sanitizers take a hundred times as long
#endif

using namespace valley;

template <class I>
struct InValley : ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(InValley, Integrators);

/// Result of pressing a tool of one sphere into obstacles.
struct Pressed {
  Vec3 p, F;
  Real speed = 0;
};
template <class I>
Pressed press(const std::vector<ShapeParams>& obstacles, const Vec3& start, const Vec3& target, Real k,
              const ContactLaw& law) {
  auto run = std::make_unique<Running<OneTool<I>>>();
  auto& par = run->par;
  par.bodies[0].body = solid_ball(0.05, 0.01);
  par.bodies[0].coupling = spring(par.bodies[0].body, k, 1);
  par.bodies[0].device.rise = 0;
  add_sphere(par, 0, Vec3::Zero(), radius);
  for (const ShapeParams& shape : obstacles)
    par.contacts.surfaces.at(par.contacts.num_surfaces++) = {.shape = shape};
  set_law(par, law);
  EXPECT_EQ(validate(par), Invalid::nothing);
  place(run->x, 0, {.X_WB = at(start), .V_WB = {}});
  engage_at(run->x, 0, Target{.X_WD = at(start), .V_WD = {}});
  constexpr int on_the_way = 300, steps = 1500;
  for (int n = 1; n <= steps; ++n) {
    const Real share = std::min(1.0, Real(n) / on_the_way);
    run->device().target.X_WD = at(start + share * (target - start));
    run->device().target.V_WD = {.w = Vec3::Zero(),
                                 .v = n < on_the_way ? Vec3((target - start) / 0.3) : Vec3(Vec3::Zero())};
    run->step();
    EXPECT_FALSE(any(run->out.fault));
  }
  return {.p = run->body().X_WB.p, .F = run->out.bodies[0].contact.F_W.f, .speed = run->body().v_W.norm()};
}

/// In meshes and height fields as on the planes of their faces, with slopes of 2 to 60 degrees.
TYPED_TEST(InValley, ASphereRestsAsOnTwoPlanes) {
  Random random(1);
  for (int n = 0; n < draws / 10; ++n) {
    const Real left = random.log_uniform(2, 60) * pi / 180, right = random.log_uniform(2, 60) * pi / 180;
    const Valley valley(left, right, random);
    const Real k = 2e4, k_c = random.log_uniform(100, 2000);
    const ContactLaw law{.k = k, .c = 40, .mu = 0, .k_t = k, .c_t = 40};
    // pressed along a direction between the normals, so that both faces bear
    const Real share = random.uniform(0.35, 0.65);
    const Vec3 along = (share * valley.n_left() + (1 - share) * valley.n_right()).normalized();
    const Vec3 start(0, random.uniform(-radius, radius), 2 * radius / std::cos(std::max(left, right)));
    const Real pressed = 0.02 * radius * k / k_c;
    const Vec3 target = Vec3(0, start.y(), radius / std::cos((left + right) / 2)) - pressed * along;
    SCOPED_TRACE(::testing::Message() << n << ": slopes " << left * 180 / pi << ", " << right * 180 / pi);
    const auto run = [&](const std::vector<ShapeParams>& obstacles) {
      return press<TypeParam>(obstacles, start, target, k_c, law);
    };
    const Pressed on_planes = run({Valley::plane(valley.n_left()), Valley::plane(valley.n_right())});
    for (const ShapeParams& shape : {valley.mesh(), valley.height_field()}) {
      const Pressed in_valley = run({shape});
      EXPECT_LT((in_valley.F - on_planes.F).norm(), 1e-6 * on_planes.F.norm()) << int(shape.kind);
      EXPECT_LT((in_valley.p - on_planes.p).norm(), 1e-6 * radius) << int(shape.kind);
      EXPECT_LT(in_valley.speed, 1e-9) << int(shape.kind);
    }
  }
}

/// The law is so soft that the centre ends below the lowest line of the valley.
TYPED_TEST(InValley, ASphereIsHeldByBothFacesBelowTheirEdge) {
  Random random(6);
  for (int n = 0; n < draws / 80; ++n) {
    const Real slope = random.uniform(15, 60) * pi / 180;
    const Valley valley(slope, slope, random);
    const ContactLaw law{.k = 500, .c = 20, .mu = 0, .k_t = 500, .c_t = 20};
    const Vec3 start(0, random.uniform(-radius, radius), 1.2 * radius / std::cos(slope));
    // deeper than the radius, by the stiffness of two planes
    const Real below = random.uniform(0.1, 0.4) * radius, k_c = 500;
    const Real F_z = 2 * law.k * std::cos(slope) * (radius + below * std::cos(slope));
    const Vec3 target(0, start.y(), -below - F_z / k_c);
    const Pressed held = press<TypeParam>({valley.mesh()}, start, target, k_c, law);
    EXPECT_NEAR(held.p.z(), -below, 1e-6 * radius) << "slope " << slope;
    EXPECT_LT(held.speed, 1e-9);
  }
}

/// With friction the end depends on the way, but it is a rest.
TYPED_TEST(InValley, ASphereRestsWithFriction) {
  Random random(2);
  for (int n = 0; n < draws / 10; ++n) {
    const Valley valley(random.log_uniform(2, 60) * pi / 180, random.log_uniform(2, 60) * pi / 180, random);
    const Real mu = random.uniform(0, 0.8);
    const ContactLaw law{.k = 2e4, .c = 40, .mu = mu, .k_t = 2e4, .c_t = 40};
    const Vec3 start(0, 0, 2 * radius / std::cos(std::max(valley.left, valley.right)));
    const Vec3 target(random.uniform(-1, 1) * radius, random.uniform(-1, 1) * radius, -radius);
    SCOPED_TRACE(n);
    for (const ShapeParams& shape : {valley.mesh(), valley.height_field()})
      EXPECT_LT(press<TypeParam>({shape}, start, target, 1000, law).speed, 1e-9);
  }
}

/// Search of one sphere at rest on a mesh.
struct Search {
  using Part = FixedContacts<1, 1, 32>;
  Part::Params par;
  Part::State before;
  ContactFinder<Part, 1> w;
  NearContacts<Part::max_contacts> near;

  explicit Search(const Solid& solid) {
    par.num_spheres = par.num_surfaces = 1;
    par.spheres[0].radius = radius;
    par.surfaces[0].shape.kind = ShapeKind::mesh;
    par.surfaces[0].shape.mesh = &solid.mesh;
  }
  void find(const Vec3& p) {
    w.at[0].p_W = w.at[0].a_W = p;
    w.at[0].R_WB = Mat3::Identity();
    w.at[0].V = {};
    find_contacts(par, before, 1, 1e-3, w, near);
  }
  /// Returns the sum of depths times normals, m.
  Vec3 pushed() const {
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = 0; i < near.size; ++i) sum += std::max(near.list[i].d, 0.0) * near.list[i].n_W;
    return sum;
  }
};

/// Pits of 3 to 6 faces; depths are those of the faces' planes.
TEST(Valleys, ASphereTouchesEveryFaceOfAPit) {
  Random random(3);
  std::size_t compared = 0;
  for (int n = 0; n < draws; ++n) {
    Solid pit;
    const auto sides = static_cast<std::uint32_t>(random.integer(3, 6));
    pit.vertices.push_back(Vec3::Zero());
    for (const bool below : {false, true})
      for (std::uint32_t k = 0; k < sides; ++k) {
        const Real turn = 2 * pi * k / sides;
        const Real z = below ? -6 * radius : 10 * radius * std::tan(random.log_uniform(5, 60) * pi / 180);
        pit.vertices.push_back({10 * radius * std::cos(turn), 10 * radius * std::sin(turn), z});
      }
    const std::uint32_t last = 2 * sides + 1;
    pit.vertices.push_back(Vec3(0, 0, -6 * radius));
    for (std::uint32_t k = 0; k < sides; ++k) {
      const std::uint32_t a = 1 + k, b = 1 + (k + 1) % sides;
      pit.triangles.push_back({0, a, b});
      pit.triangles.push_back({last, b + sides, a + sides});
      pit.add_quad(b, a, a + sides, b + sides);
    }
    pit.set_up(3 * radius);
    Search search(pit);
    const Vec3 p = 1.2 * radius * (Vec3::UnitZ() + 0.3 * random.vector());
    const std::vector<oracle::NearestPoint> expected = oracle::nearest_points(pit.twin(), p);
    search.find(p);
    for (const oracle::NearestPoint& face : expected) {
      if (!(face.distance > 0 && face.distance < radius) || oracle::nearest_point(pit.twin(), p).distance < 0)
        continue;
      int found = 0;
      for (std::size_t i = 0; i < search.near.size; ++i) {
        const NearContact& c = search.near.list[i];
        if (std::abs(radius - c.d - face.distance) < 1e-12 && (c.n_W - face.n).norm() < 1e-9) ++found;
      }
      EXPECT_EQ(found, 1) << n << ": " << sides << " sides, distance " << face.distance;
      ++compared;
    }
  }
  EXPECT_GT(compared, static_cast<std::size_t>(draws));
}

/// Over drawn profiles of concave and convex edges, forces change with the way alone.
TEST(Valleys, ForcesDoNotJumpOverEdges) {
  Random random(4);
  Real worst = 0;
  for (int n = 0; n < draws / 4; ++n) {
    std::vector<Vec3> profile{Vec3::Zero()};
    Real slope = 0;
    for (int k = 0; k < 4; ++k) {
      const Real turn = random.log_uniform(1.5, 50) * pi / 180 * (random.integer(0, 1) == 0 ? -1 : 1);
      if (std::abs(slope + turn) < 1) slope += turn;
      const Real length = radius * random.uniform(2, 4);
      profile.push_back(profile.back() + length * Vec3(std::cos(slope), 0, std::sin(slope)));
    }
    std::vector<Real> ys{-4 * radius};
    while (ys.back() < 4 * radius) ys.push_back(ys.back() + radius * random.uniform(0.5, 4));
    const auto solid = block_below(profile, ys);
    Search search(*solid);
    const Real depth = radius * random.log_uniform(0.001, 0.2), y = radius * random.uniform(-1, 1);
    // over each inner edge, along the face before it and then along the next one
    for (std::size_t k = 1; k + 1 < profile.size(); ++k) {
      const Vec3 in = (profile[k] - profile[k - 1]).normalized(),
                 out = (profile[k + 1] - profile[k]).normalized();
      const Vec3 above = in.cross(Vec3::UnitY());
      constexpr int steps = 4000;
      const Real way = 2.5 * radius / steps;
      Vec3 before = Vec3::Zero();
      for (int s = 0; s <= steps; ++s) {
        const Vec3 along = s < steps / 2 ? in : Vec3((in + out).normalized());
        const Vec3 p = profile[k] + Vec3(0, y, 0) + (s - steps / 2) * way * along + (radius - depth) * above;
        search.find(p);
        const Vec3 pushed = search.pushed();
        if (s > 0) worst = std::max(worst, (pushed - before).norm() / way);
        if (s > 0) {
          ASSERT_LT((pushed - before).norm(), 8 * way)
              << n << ", edge " << k << ", step " << s << ", depth " << depth / radius;
        }
        before = pushed;
      }
    }
  }
  std::printf("forces change by at most %.2f k times the way\n", worst);
}

/// A plane of drawn triangles, turned: rounding alone bends its edges.
TEST(Valleys, EdgesOfAFlatSurfaceAreNotFelt) {
  Random random(5);
  for (int n = 0; n < draws / 4; ++n) {
    std::vector<Vec3> profile{Vec3::Zero()};
    std::vector<Real> ys{-6 * radius};
    while (profile.back().x() < 12 * radius)
      profile.push_back(profile.back() + radius * random.uniform(0.2, 2) * Vec3::UnitX());
    while (ys.back() < 6 * radius) ys.push_back(ys.back() + radius * random.uniform(0.2, 2));
    auto solid = block_below(profile, ys);
    const Mat3 R = random.rotation().toRotationMatrix();
    for (Vec3& v : solid->vertices) v = R * v;
    solid->set_up(2 * radius);
    Search search(*solid);
    for (int k = 0; k < 200; ++k) {
      const Real d = radius * random.uniform(-0.2, 0.9);
      const Vec3 p = R * Vec3(random.uniform(3, 9) * radius, random.uniform(-3, 3) * radius, radius - d);
      search.find(p);
      ASSERT_EQ(search.near.size, 1u) << n;
      ASSERT_NEAR(search.near.list[0].d, d, 5e-15);
      ASSERT_LT((search.near.list[0].n_W - R * Vec3::UnitZ()).norm(), 1e-12);
    }
  }
}

}  // namespace
}  // namespace godobject::test_valleys
