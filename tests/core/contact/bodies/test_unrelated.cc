// Bodies move alike alone and beside unrelated bodies of the scene, before or behind them in its list. Their
// law is a damping ratio, and the masses of all bodies are drawn. TR-BDF2 is not covered: it retakes a step
// for all bodies if a contact of one changes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/core/contact/bodies/jointed_pile.h"

namespace godobject::test_unrelated {
namespace {

#ifdef NDEBUG
constexpr unsigned draws = 40;
#else
constexpr unsigned draws = 2;  // builds with assertions and sanitizers take a hundred times as long
#endif
constexpr Real duration = 0.3;  // s
// Rounding, which collisions multiply. Compilers contract operations on lanes and loops differently.
constexpr Real tolerance = 1e-12;

enum class Unrelated { in_flight, at_rest, bouncing };
constexpr std::array unrelated_names{"in flight", "at rest", "bouncing"};

/// A scene of one or two bodies, one above the other, above a floor and a box of the world. The unrelated
/// ones are 5 m away.
struct DrawnScene {
  struct Body {
    Real m = 0, radius = 0;  // ball if radius > 0
    Vec3 half = Vec3::Zero();
    Start start;
  };
  std::vector<Body> subjects, others;
  Pose X_WF, X_WS;  // floor, box
  ContactLaw law;
  Real h = 1e-3;
};

DrawnScene::Body drawn_body(Random& random, const Vec3& p, Real turn, Real speed) {
  DrawnScene::Body body;
  body.m = random.log_uniform(2e-3, 0.1);
  if (random.integer(0, 3) == 0) body.radius = random.uniform(0.006, 0.015);
  body.half = Vec3(random.uniform(0.006, 0.02), random.uniform(0.006, 0.02), random.uniform(0.006, 0.015));
  body.start = {.X_WB = at(p, turn * random.vector()),
                .V_WB = {.w = 10 * speed * random.vector(), .v = speed * random.vector()}};
  return body;
}

DrawnScene::Body drawn_other(Random& random, const DrawnScene& scene, Unrelated kind, int i) {
  const Vec3 far = scene.X_WF.p + scene.X_WF.q * Vec3(-5, 0.2 * i, 0);
  if (kind == Unrelated::in_flight) return drawn_body(random, far + Vec3(0, 0, 3), 1, 1);
  if (kind == Unrelated::bouncing) return drawn_body(random, far + Vec3(0, 0, 0.04), 1, 0.5);
  DrawnScene::Body body = drawn_body(random, Vec3::Zero(), 0, 0);
  body.radius = 0;
  const Vec3 above(0, 0, body.half.z() - body.m * earth_gravity / (4 * scene.law.k));
  body.start.X_WB = {.p = far + scene.X_WF.q * above, .q = scene.X_WF.q};
  return body;
}

DrawnScene drawn(unsigned seed, Unrelated kind) {
  Random random(seed);
  DrawnScene scene;
  const Real k = random.log_uniform(1e3, 2e4), ratio = random.uniform(0.1, 2);
  scene.law = {.k = k, .mu = random.uniform(0, 0.8), .k_t = k, .ratio = ratio, .ratio_t = ratio};
  scene.h = random.log_uniform(2e-4, 2e-3);
  scene.X_WF = at(Vec3::Zero(), 0.1 * random.vector());
  scene.X_WS = at(Vec3(0.02, 0, 0) + 0.01 * random.vector(), 0.2 * random.vector());
  for (int i = random.integer(0, 1); i >= 0; --i)
    scene.subjects.push_back(drawn_body(
        random, Vec3(0.005 * random.normal(), 0.005 * random.normal(), 0.03 + 0.035 * i), 0.2, 0.1));
  for (int i = random.integer(0, 2); i >= 0; --i) scene.others.push_back(drawn_other(random, scene, kind, i));
  return scene;
}

struct Moment {
  Vec3 p, v, w_B;
  Quat q;
};

/// Returns the motion of the subjects, step by step. before, behind: with the others there in the list.
template <class I>
std::vector<Moment> run(const DrawnScene& scene, bool before, bool behind) {
  auto pile = std::make_unique<JointedPileOf<I>>();
  auto& par = pile->par;
  par.h = scene.h;
  par.gravity_W = Vec3(0, 0, -earth_gravity);
  set_law(par, scene.law);
  add_plane(par, scene.X_WF);
  add_box(par, scene.X_WS, Vec3(0.02, 0.03, 0.015));
  const auto add = [&](const std::vector<DrawnScene::Body>& bodies) {
    for (const DrawnScene::Body& body : bodies) {
      if (body.radius > 0) pile->add_ball(body.start, body.m, body.radius);
      else pile->add_brick(body.start, body.m, body.half);
    }
  };
  if (before) add(scene.others);
  const std::size_t first = par.num_bodies;
  add(scene.subjects);
  if (behind) add(scene.others);
  EXPECT_EQ(validate(par), Invalid::nothing);
  std::vector<Moment> moments;
  for (long n = std::lround(duration / par.h); n > 0; --n) {
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    for (std::size_t i = 0; i < scene.subjects.size(); ++i) {
      const RigidBodyState& x = pile->at(first + i);
      moments.push_back({x.X_WB.p, x.v_W, x.w_B, x.X_WB.q});
    }
  }
  return moments;
}

/// Returns the largest difference of positions and velocities, in units of a body's size and m/s.
Real difference(const std::vector<Moment>& a, const std::vector<Moment>& b) {
  constexpr Real size = 0.02;  // m
  Real most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, (a[i].p - b[i].p).norm() / size, (a[i].v - b[i].v).norm(),
                     size * (a[i].w_B - b[i].w_B).norm(), (a[i].q.coeffs() - b[i].q.coeffs()).norm()});
  return most;
}

template <class I>
void expect_alike(Unrelated kind) {
  Real worst = 0;
  int num_apart = 0;
  for (unsigned n = 0; n < draws; ++n) {
    const DrawnScene scene = drawn(n, kind);
    const std::vector<Moment> alone = run<I>(scene, false, false);
    for (const bool before : {false, true}) {
      const Real apart = difference(alone, run<I>(scene, before, !before));
      EXPECT_LT(apart, tolerance) << "scene " << n << ", others " << (before ? "before" : "behind");
      num_apart += !(apart < tolerance);
      worst = std::max(worst, apart);
    }
  }
  std::printf("%s, beside bodies %s: %.1e apart, %d of %u\n", I::name,
              unrelated_names[static_cast<std::size_t>(kind)], worst, num_apart, 2 * draws);
}

template <class I>
struct BesideUnrelated : ::testing::Test {};
using Integrators = ::testing::Types<ImplicitEuler>;
TYPED_TEST_SUITE(BesideUnrelated, Integrators);

TYPED_TEST(BesideUnrelated, InFlight) { expect_alike<TypeParam>(Unrelated::in_flight); }
TYPED_TEST(BesideUnrelated, AtRest) { expect_alike<TypeParam>(Unrelated::at_rest); }
TYPED_TEST(BesideUnrelated, Bouncing) { expect_alike<TypeParam>(Unrelated::bouncing); }

}  // namespace
}  // namespace godobject::test_unrelated
