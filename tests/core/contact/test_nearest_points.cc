// Contacts of a sphere with every kind of shape, on the world or on bodies, against the nearest point by
// brute force. Compared are depth, normal and contact point in the list of a step of either integrator.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/jointed_pile.h"
#include "tests/core/contact/usual_scenes.h"
#include "tests/core/mesh_arrays.h"
#include "tests/oracle/nearest_point.h"

namespace godobject::test_nearest_points {
namespace {

enum class Carrier { obstacle, free, jointed };

/// Kinds of scenes: bodies that touch the world alone, each other, and on joints.
template <class S>
struct InScene : ::testing::Test {};
using Scenes = ::testing::Types<OneTool<ImplicitEuler>, OneTool<TrBdf2>, FewBodies<ImplicitEuler>,
                                FewBodies<TrBdf2>, Jointed<ImplicitEuler>, Jointed<TrBdf2>>;
TYPED_TEST_SUITE(InScene, Scenes);

/// A closed surface of triangles round a point, with bumps and hollows.
struct Lump : MeshArrays {
  Lump(Random& random, Real size) {
    constexpr std::uint32_t rings = 5, around = 8;
    const auto point = [&](Real polar, Real turn) {
      const Real r = size * random.uniform(0.7, 1.3);
      return Vec3(r * std::sin(polar) * std::cos(turn), r * std::sin(polar) * std::sin(turn),
                  r * std::cos(polar));
    };
    vertices.push_back(point(0, 0));
    for (std::uint32_t i = 1; i <= rings; ++i)
      for (std::uint32_t k = 0; k < around; ++k)
        vertices.push_back(point(pi * i / (rings + 1), 2 * pi * k / around));
    vertices.push_back(point(pi, 0));
    const auto of = [&](std::uint32_t ring, std::uint32_t k) { return 1 + ring * around + k % around; };
    const auto last = static_cast<std::uint32_t>(vertices.size() - 1);
    for (std::uint32_t k = 0; k < around; ++k) {
      triangles.push_back({0, of(0, k), of(0, k + 1)});
      for (std::uint32_t i = 0; i + 1 < rings; ++i) {
        triangles.push_back({of(i, k), of(i + 1, k), of(i + 1, k + 1)});
        triangles.push_back({of(i, k), of(i + 1, k + 1), of(i, k + 1)});
      }
      triangles.push_back({of(rings - 1, k), last, of(rings - 1, k + 1)});
    }
    EXPECT_EQ(set_up(size / 4).invalid, MeshInvalid::nothing);
  }
};

/// A shape of a kind as long or flat as it comes, and the same for the oracle.
struct DrawnShape {
  ShapeParams shape;
  oracle::Solid solid;
  Real size = 0;  // m: it is within so far of the origin of its frame
  std::vector<Real> heights{};
  HeightField field{};
  std::unique_ptr<Lump> lump{};

  DrawnShape(ShapeKind kind, Random& random) {
    const auto length = [&]() { return random.log_uniform(2e-3, 0.05); };
    shape.kind = kind;
    switch (kind) {
      case ShapeKind::box:
        for (Real& half : shape.half_extents) half = length();
        solid = oracle::box(shape.half_extents);
        size = shape.half_extents.norm();
        break;
      case ShapeKind::sphere:
        shape.radius = size = length();
        solid = oracle::ball(shape.radius);
        break;
      case ShapeKind::capsule:
        shape.radius = length();
        shape.half_length = length();
        solid = oracle::capsule(shape.radius, shape.half_length);
        size = shape.radius + shape.half_length;
        break;
      case ShapeKind::height_field: {
        const int columns = random.integer(2, 6), rows = random.integer(2, 6);
        const Real spacing = length() / 4;
        for (int k = 0; k < columns * rows; ++k) heights.push_back(spacing * random.normal());
        field = {.height = heights,
                 .columns = static_cast<std::uint32_t>(columns),
                 .rows = static_cast<std::uint32_t>(rows),
                 .spacing = spacing};
        shape.height_field = &field;
        solid = oracle::height_field(heights, columns, rows, spacing);
        size = spacing * (columns + rows);
        break;
      }
      case ShapeKind::mesh:
        size = length();
        lump = std::make_unique<Lump>(random, size / 1.3);
        shape.mesh = &lump->mesh;
        solid = oracle::mesh(lump->vertices, lump->triangles);
        break;
      case ShapeKind::plane: break;
    }
  }
  DrawnShape(const DrawnShape&) = delete;
  DrawnShape& operator=(const DrawnShape&) = delete;
};

Pose drawn_pose(Random& random) { return {.p = 0.1 * random.vector(), .q = random.rotation()}; }
Pose after(const Pose& X_WB, const Pose& X_BS) {
  return {.p = X_WB.p + X_WB.q.toRotationMatrix() * X_BS.p, .q = X_WB.q * X_BS.q};
}

/// Joins body i to the world, where it is.
template <class S>
void join_to_world(Pile<S>& pile, std::size_t i, Random& random) {
  auto& joint = pile.par.bodies[i].joint;
  constexpr std::array kinds{JointKind::hinge,     JointKind::slider, JointKind::cylindrical,
                             JointKind::universal, JointKind::ball,   JointKind::fixed};
  joint.kind = kinds[static_cast<std::size_t>(random.integer(0, 5))];
  joint.parent = world;
  joint.C = {.p = 0.02 * random.vector(), .R = random.rotation().toRotationMatrix()};
  joint.P = {.p = 0.1 * random.vector(), .R = random.rotation().toRotationMatrix()};
  place(pile.x, i, joined(pile.par, pile.x, i, {}));
}

/// A shape on its carrier, and a body of a few spheres about its surface.
template <class S>
struct Meeting {
  static constexpr bool has_joints = uses<typename S::Joints>;
  static constexpr int num_spheres = 5;
  Random random;
  std::unique_ptr<Pile<S>> pile = std::make_unique<Pile<S>>();
  DrawnShape drawn;
  Carrier carrier;
  std::size_t of_tool = 0;
  std::uint32_t surface = 0;
  Pose X_WS;
  std::vector<Vec3> centres;  // of spheres in the world
  std::vector<Real> radii;

  static ShapeKind own_kind(Random& random) {
    constexpr std::array kinds{ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
    return kinds[static_cast<std::size_t>(random.integer(0, 2))];
  }
  Pose in_world(const Vec3& p_S) const { return after(X_WS, {.p = p_S, .q = Quat::Identity()}); }
  Vec3 in_shape(const Vec3& p_W) const { return X_WS.q.toRotationMatrix().transpose() * (p_W - X_WS.p); }

  /// A point near the surface; outside: in no case within it.
  Vec3 near_surface(Real radius, bool outside) {
    for (int n = 0; n < 10000; ++n) {
      const Vec3 p_S = (drawn.size + radius) * random.uniform(0, 1) * random.direction() +
                       (drawn.shape.kind == ShapeKind::height_field ? drawn.size / 4 : 0) * Vec3(1, 1, 0);
      const Real distance = oracle::nearest_point(drawn.solid, p_S).distance;
      if (distance < radius && distance > (outside ? 0.3 * radius : -radius)) return p_S;
    }
    ADD_FAILURE() << "no point near the surface";
    return Vec3::Zero();
  }

  Meeting(unsigned seed, ShapeKind kind, Carrier on, bool own_shape)
      : random(seed), drawn(kind, random), carrier(on) {
    set_law(pile->par, {.k = 1e-6, .c = 0, .mu = 0, .k_t = 0, .c_t = 0});
    const std::size_t num_carriers = on == Carrier::obstacle ? 0 : 1;
    of_tool = num_carriers == 0 ? 0 : static_cast<std::size_t>(random.integer(0, 1));
    const std::size_t of_carrier = 1 - of_tool;
    for (std::size_t i = 0; i < 1 + num_carriers; ++i)
      pile->add(solid_ball(1, 0.05), {.X_WB = drawn_pose(random), .V_WB = {}});
    if constexpr (has_joints) {
      if (on == Carrier::jointed) join_to_world(*pile, of_carrier, random);
      if (random.integer(0, 1) == 0) join_to_world(*pile, of_tool, random);
    }
    drawn.shape.X_WS = drawn_pose(random);
    X_WS = on == Carrier::obstacle ? drawn.shape.X_WS : after(pile->at(of_carrier).X_WB, drawn.shape.X_WS);
    place_tool(own_shape, on == Carrier::obstacle ? world : of_carrier);
  }

  void place_tool(bool own_shape, std::size_t of_carrier) {
    const Pose X_WB = pile->at(of_tool).X_WB;
    const auto on_tool = [&](const Vec3& p_W) {
      return Vec3(X_WB.q.toRotationMatrix().transpose() * (p_W - X_WB.p));
    };
    const bool outside = own_shape && drawn.shape.kind == ShapeKind::box;
    for (int s = 0; s < num_spheres; ++s) {
      const Real radius = random.log_uniform(1e-3, 0.01);
      centres.push_back(in_world(near_surface(radius, outside)).p);
      radii.push_back(radius);
      add_sphere(pile->par, of_tool, on_tool(centres.back()), radius);
    }
    const Surface touched{.body = of_carrier, .shape = drawn.shape};
    auto& contacts = pile->par.contacts;
    if (of_carrier == world || of_carrier < of_tool) contacts.surfaces[contacts.num_surfaces++] = touched;
    if (own_shape) {
      // outside all else, so that it is no part of the contacts
      Surface own;
      own.body = of_tool;
      own.shape.kind = own_kind(random);
      own.shape.radius = own.shape.half_length = 1e-4;
      own.shape.half_extents = Vec3::Constant(1e-4);
      own.shape.X_WS = {.p = on_tool(in_world(2 * drawn.size * random.direction()).p),
                        .q = random.rotation()};
      contacts.surfaces[contacts.num_surfaces++] = own;
    }
    if (of_carrier != world && of_carrier > of_tool) {
      surface = static_cast<std::uint32_t>(contacts.num_surfaces);
      contacts.surfaces[contacts.num_surfaces++] = touched;
    }
  }

  /// Compares the list of a step, in which nothing moves; returns the number of contacts.
  int check() {
    constexpr auto spheres =
        static_cast<std::uint32_t>(std::tuple_size_v<decltype(pile->par.contacts.surfaces)>);
    EXPECT_EQ(validate(pile->par), Invalid::nothing);
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    const auto& near = pile->w.contacts.near;
    int compared = 0;
    for (std::uint32_t s = 0; s < num_spheres; ++s) {
      const oracle::NearestPoint expected = oracle::nearest_point(drawn.solid, in_shape(centres[s]));
      const Vec3 n_W = X_WS.q.toRotationMatrix() * expected.n;
      const NearContact* at = nullptr;
      for (std::size_t i = 0; i < near.size; ++i)
        if (near.list[i].of == spheres + s && near.list[i].on == surface) at = &near.list[i];
      EXPECT_TRUE(at) << "sphere " << s << " at a distance of " << expected.distance;
      if (!at) continue;
      EXPECT_EQ(at->a, of_tool);
      EXPECT_NEAR(at->d, radii[s] - expected.distance, 1e-9);
      EXPECT_LT((at->n_W - n_W).norm(), 1e-6) << "distance " << expected.distance;
      EXPECT_LT((at->p_W - (centres[s] - radii[s] * n_W)).norm(), 1e-8);
      ++compared;
    }
    return compared;
  }
};

TYPED_TEST(InScene, EverySphereMeetsTheNearestPointOfEveryShape) {
  using S = TypeParam;
#ifdef NDEBUG
  constexpr unsigned draws = 200;
#else
  constexpr unsigned draws = 5;  // builds with assertions and sanitizers take a hundred times as long
#endif
  int compared = 0;
  for (const ShapeKind kind :
       {ShapeKind::sphere, ShapeKind::box, ShapeKind::capsule, ShapeKind::height_field, ShapeKind::mesh})
    for (const Carrier on : {Carrier::obstacle, Carrier::free, Carrier::jointed})
      for (const bool own_shape : {false, true}) {
        const bool on_body = on != Carrier::obstacle;
        if (on_body && (!is_carried(kind) || !S::Contacts::between_bodies)) continue;
        if (on == Carrier::jointed && !Meeting<S>::has_joints) continue;
        if (own_shape && !S::Contacts::between_bodies) continue;
        for (unsigned seed = 0; seed < draws; ++seed) {
          SCOPED_TRACE(::testing::Message()
                       << "shape " << static_cast<int>(kind) << ", carrier " << static_cast<int>(on)
                       << ", own shape " << own_shape << ", seed " << seed);
          Meeting<S> meeting(seed, kind, on, own_shape);
          compared += meeting.check();
          if (::testing::Test::HasFailure()) return;
        }
      }
  std::printf("%d contacts\n", compared);
  EXPECT_GT(compared, static_cast<int>(4 * 5 * draws));
}

}  // namespace
}  // namespace godobject::test_nearest_points
