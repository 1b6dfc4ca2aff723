// Drawn scenes of boxes, balls and capsules on obstacles end alike up to rounding: in any order, rotated,
// mirrored or translated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <numeric>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_symmetries {
namespace {

#ifdef NDEBUG
constexpr unsigned draws = 30;
#else
constexpr unsigned draws = 3;  // builds with assertions and sanitizers take a hundred times as long
#endif
constexpr Real duration = 0.08;  // s
// Sums in another order differ by 1e-16. Each of two or three collisions in the duration multiplies that by
// some hundred.
constexpr Real tolerance = 1e-9;

struct DrawnBody {
  enum class Kind { ball, brick, shape } kind = Kind::brick;
  Real m = 0, radius = 0;
  ShapeParams shape{};  // without spheres
  Vec3 half;
  Start start;
};
struct DrawnScene {
  std::vector<DrawnBody> bodies;
  std::vector<ShapeParams> obstacles;
  ContactLaw law;
  Real h = 1e-3;
};

/// Turns floor and step into a plane and a ball or capsule, and some bodies into shapes without spheres.
void draw_shapes(DrawnScene& scene, Random& random) {
  constexpr std::array kinds{ShapeKind::sphere, ShapeKind::capsule, ShapeKind::box};
  const auto shape = [&](ShapeKind kind) {
    const Real radius = random.uniform(0.006, 0.015);
    return ShapeParams{.kind = kind,
                       .half_extents = Vec3(random.uniform(0.006, 0.02), random.uniform(0.006, 0.02), radius),
                       .radius = kind == ShapeKind::box ? 0 : radius,
                       .half_length = kind == ShapeKind::capsule ? random.uniform(0.006, 0.02) : 0};
  };
  ShapeParams& step = scene.obstacles[1];
  const Pose X = step.X_WS;
  step = shape(kinds[static_cast<std::size_t>(random.integer(0, 2))]);
  step.X_WS = X;
  for (DrawnBody& body : scene.bodies) {
    if (random.integer(0, 2) == 0) continue;
    body.kind = DrawnBody::Kind::shape;
    body.shape = shape(kinds[static_cast<std::size_t>(random.integer(0, 2))]);
  }
}

DrawnScene drawn(unsigned seed, bool with_shapes) {
  Random random(seed);
  DrawnScene scene;
  const Real k = random.log_uniform(1e3, 2e4), c = random.uniform(0.05, 1) * 2 * std::sqrt(k * 0.01);
  scene.law = {.k = k, .c = c, .mu = random.uniform(0, 0.8), .k_t = k, .c_t = c};
  scene.h = random.log_uniform(2e-4, 2e-3);
  ShapeParams floor, step;
  floor.X_WS = at(Vec3(0, 0, 0), 0.1 * random.vector());
  step.kind = ShapeKind::box;
  step.X_WS = at(Vec3(0.02, 0, 0) + 0.01 * random.vector(), random.vector());
  step.half_extents = Vec3(0.02, 0.03, 0.015);
  scene.obstacles = {floor, step};
  const int num = random.integer(2, 5);
  for (int i = 0; i < num; ++i) {
    DrawnBody body;
    if (random.integer(0, 3) == 0) body.kind = DrawnBody::Kind::ball;
    body.m = random.log_uniform(5e-3, 0.1);
    body.radius = random.uniform(0.006, 0.015);
    body.half = Vec3(random.uniform(0.006, 0.02), random.uniform(0.006, 0.02), random.uniform(0.006, 0.02));
    body.start = {
        .X_WB = at(Vec3(0.02 * random.normal(), 0.02 * random.normal(), 0.05 + 0.04 * i), random.vector()),
        .V_WB = {.w = 3 * random.vector(), .v = Vec3(0, 0, -1) + 0.3 * random.vector()}};
    scene.bodies.push_back(body);
  }
  if (with_shapes) draw_shapes(scene, random);
  return scene;
}

/// An isometry x -> M x + t, and an order of bodies and obstacles.
struct Change {
  Mat3 M = Mat3::Identity();
  Vec3 t = Vec3::Zero();
  std::vector<std::size_t> bodies{}, obstacles{};  // places to which they move; empty: their own

  Real side() const { return M.determinant() < 0 ? -1 : 1; }
  /// Mirrors a frame together with its body: mirrored twice it is right-handed.
  Mat3 mirror() const { return Vec3(side(), 1, 1).asDiagonal(); }
  Pose of(const Pose& X) const {
    return {.p = M * X.p + t, .q = Quat(Mat3(M * X.q.toRotationMatrix() * mirror()))};
  }
};

struct End {
  Vec3 p, v, w_W;
  Mat3 R;
};

/// Returns the ends of the bodies, in the order of the drawn scene and turned back.
template <class I>
std::vector<End> run(const DrawnScene& scene, const Change& change, std::size_t& contacts) {
  auto pile = std::make_unique<Pile<FewBodies<I>>>();
  auto& par = pile->par;
  par.h = scene.h;
  par.gravity_W = change.M * Vec3(0, 0, -earth_gravity);
  set_law(par, scene.law);
  const auto order = [](const std::vector<std::size_t>& places, std::size_t num) {
    std::vector<std::size_t> from(num);
    for (std::size_t i = 0; i < num; ++i) from[places.empty() ? i : places[i]] = i;
    return from;
  };
  for (const std::size_t o : order(change.obstacles, scene.obstacles.size())) {
    ShapeParams shape = scene.obstacles[o];
    shape.X_WS = change.of(shape.X_WS);
    par.contacts.surfaces.at(par.contacts.num_surfaces++) = {.shape = shape};
  }
  const std::vector<std::size_t> from = order(change.bodies, scene.bodies.size());
  for (const std::size_t i : from) {
    const DrawnBody& body = scene.bodies[i];
    const Twist& V = body.start.V_WB;
    const Start start{.X_WB = change.of(body.start.X_WB),
                      .V_WB = {.w = change.side() * change.M * V.w, .v = change.M * V.v}};
    switch (body.kind) {
      case DrawnBody::Kind::ball: pile->add_ball(start, body.m, body.radius); break;
      case DrawnBody::Kind::brick: pile->add_brick(start, body.m, body.half); break;
      case DrawnBody::Kind::shape: pile->carry(pile->add(solid_box(body.m, body.half), start), body.shape);
    }
  }
  EXPECT_EQ(validate(par), Invalid::nothing);
  for (long n = std::lround(duration / par.h); n > 0; --n) {
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    contacts += pile->out.contacts.num_contacts;
  }
  std::vector<End> ends(from.size());
  for (std::size_t k = 0; k < from.size(); ++k) {
    const RigidBodyState& x = pile->at(k);
    const Mat3 R = x.X_WB.q.toRotationMatrix(), back = change.M.transpose();
    ends[from[k]] = {.p = back * (x.X_WB.p - change.t),
                     .v = back * x.v_W,
                     .w_W = change.side() * back * R * x.w_B,
                     .R = back * R * change.mirror()};
  }
  return ends;
}

Real difference(const std::vector<End>& a, const std::vector<End>& b) {
  constexpr Real size = 0.02;  // m, of a body
  Real most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, (a[i].p - b[i].p).norm() / size, (a[i].v - b[i].v).norm(),
                     size * (a[i].w_W - b[i].w_W).norm(), (a[i].R - b[i].R).norm()});
  return most;
}

template <class I>
struct Symmetries : ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Symmetries, Integrators);

template <class TypeParam>
void expect_symmetries(bool with_shapes) {
  Random random(7);
  std::size_t contacts = 0;
  Real worst = 0;
  for (unsigned n = 0; n < draws; ++n) {
    const DrawnScene scene = drawn(n, with_shapes);
    const std::vector<End> ends = run<TypeParam>(scene, {}, contacts);
    Change order, turn, mirror, shift;
    order.bodies.resize(scene.bodies.size());
    std::iota(order.bodies.begin(), order.bodies.end(), 0);
    std::rotate(order.bodies.begin(), order.bodies.begin() + random.integer(1, int(scene.bodies.size()) - 1),
                order.bodies.end());
    std::swap(order.bodies[0], order.bodies.back());
    if (scene.bodies.size() == 2) order.bodies = {1, 0};
    order.obstacles = {1, 0};
    turn.M = random.rotation().toRotationMatrix();
    mirror.M = random.rotation().toRotationMatrix() * Vec3(-1, 1, 1).asDiagonal();
    shift.t = 0.1 * random.vector();
    const std::array<std::pair<const char*, const Change*>, 4> changes{
        {{"order", &order}, {"rotation", &turn}, {"mirror", &mirror}, {"translation", &shift}}};
    for (const auto& [name, change] : changes) {
      const Real apart = difference(run<TypeParam>(scene, *change, contacts), ends);
      EXPECT_LT(apart, tolerance) << name << " of scene " << n << ", " << scene.bodies.size() << " bodies";
      worst = std::max(worst, apart);
    }
  }
  std::printf("worst difference %.1e, %zu contacts\n", worst, contacts);
  EXPECT_GT(contacts, 300u * draws);
}

TYPED_TEST(Symmetries, OfDrawnScenes) { expect_symmetries<TypeParam>(false); }
TYPED_TEST(Symmetries, OfDrawnShapesWithoutSpheres) { expect_symmetries<TypeParam>(true); }

}  // namespace
}  // namespace godobject::test_symmetries
