// Bodies move alike in every composition: alone in a scene without contacts between bodies, or beside
// unrelated bodies in a scene with them.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>

#include "tests/core/contact/usual_scenes.h"

namespace godobject::test_compositions {
namespace {

#ifdef NDEBUG
constexpr unsigned draws = 40;
#else
constexpr unsigned draws = 5;  // builds with assertions and sanitizers take a hundred times as long
#endif
constexpr Real duration = 0.3;  // s
// Islands are solved one by one, so that all operations on a body are the same. Compilers contract them
// otherwise in each scene type: 1e-16, which each collision multiplies by some hundred.
constexpr Real tolerance = 1e-9;

enum class Unrelated { none, at_rest, in_flight, in_contact };
constexpr const char* name_of(Unrelated unrelated) {
  switch (unrelated) {
    case Unrelated::none: break;
    case Unrelated::at_rest: return "at rest";
    case Unrelated::in_flight: return "in flight";
    case Unrelated::in_contact: return "in contact";
  }
  return "none";
}
/// Unrelated bodies beside which a body moves alike. If contacts of one body change, TR-BDF2 takes implicit
/// Euler stages for all.
template <class I>
constexpr std::array unrelated_to{Unrelated::none, Unrelated::in_flight, Unrelated::at_rest,
                                  Unrelated::in_contact};
template <>
constexpr std::array unrelated_to<TrBdf2>{Unrelated::none, Unrelated::in_flight, Unrelated::at_rest};

struct DrawnBody {
  bool is_ball = false;
  Real m = 0, radius = 0;
  Vec3 half;
  Start start;
};
/// A body on the floor and a box of the world, or on another body.
struct DrawnScene {
  std::vector<DrawnBody> subjects, others;
  Pose X_WF, X_WS;  // floor, step
  ContactLaw law;
  Real h = 1e-3;
};

DrawnBody drawn_body(Random& random, const Vec3& p, Real turn, Real speed) {
  DrawnBody body;
  body.is_ball = random.integer(0, 3) == 0;
  body.m = random.log_uniform(2e-3, 0.1);
  body.radius = random.uniform(0.006, 0.015);
  body.half = Vec3(random.uniform(0.006, 0.02), random.uniform(0.006, 0.02), random.uniform(0.006, 0.015));
  body.start = {.X_WB = at(p, turn * random.vector()),
                .V_WB = {.w = 10 * speed * random.vector(), .v = speed * random.vector()}};
  return body;
}

/// subjects: 1: a body on obstacles; 2: another one beneath it.
DrawnScene drawn(unsigned seed, int subjects, Unrelated unrelated) {
  Random random(seed);
  DrawnScene scene;
  const Real k = random.log_uniform(1e3, 2e4), c = random.uniform(0.05, 1) * 2 * std::sqrt(k * 0.01);
  scene.law = {.k = k, .c = c, .mu = random.uniform(0, 0.8), .k_t = k, .c_t = c};
  scene.h = random.log_uniform(2e-4, 2e-3);
  scene.X_WF = at(Vec3::Zero(), 0.1 * random.vector());
  scene.X_WS = at(Vec3(0.02, 0, 0) + 0.01 * random.vector(), 0.2 * random.vector());
  for (int i = 0; i < subjects; ++i)
    scene.subjects.push_back(drawn_body(
        random, Vec3(0.005 * random.normal(), 0.005 * random.normal(), 0.03 + 0.035 * i), 0.2, 0.1));
  const int num = random.integer(1, 3);
  for (int i = 0; i < num && unrelated != Unrelated::none; ++i) {
    const Vec3 far(-5, 0, 0);
    switch (unrelated) {
      case Unrelated::none: break;
      case Unrelated::at_rest: {
        DrawnBody body = drawn_body(random, Vec3::Zero(), 0, 0);
        body.is_ball = false;
        const Vec3 above(0.1 * i, 0, body.half.z() - body.m * earth_gravity / (4 * k));
        body.start.X_WB = {.p = scene.X_WF.p + scene.X_WF.q * Vec3(far + above), .q = scene.X_WF.q};
        scene.others.push_back(body);
        break;
      }
      case Unrelated::in_flight:
        scene.others.push_back(drawn_body(random, far + Vec3(2 * i, 0, 3), 1, 1));
        break;
      case Unrelated::in_contact:
        scene.others.push_back(drawn_body(random, scene.X_WF.q * far + Vec3(0, 0, 0.03 + 0.04 * i), 1, 0.5));
    }
  }
  return scene;
}

struct Moment {
  Vec3 p, v, w_B;
  Quat q;
};

/// Returns the motion of the subjects, step by step.
template <class S>
std::vector<Moment> run(const DrawnScene& scene) {
  auto pile = std::make_unique<Pile<S>>();
  auto& par = pile->par;
  par.h = scene.h;
  par.gravity_W = Vec3(0, 0, -earth_gravity);
  set_law(par, scene.law);
  add_plane(par, scene.X_WF);
  add_box(par, scene.X_WS, Vec3(0.02, 0.03, 0.015));
  for (const auto* const bodies : {&scene.subjects, &scene.others}) {
    for (const DrawnBody& body : *bodies) {
      if (body.is_ball) pile->add_ball(body.start, body.m, body.radius);
      else pile->add_brick(body.start, body.m, body.half);
    }
  }
  EXPECT_EQ(validate(par), Invalid::nothing);
  std::vector<Moment> moments;
  for (long n = std::lround(duration / par.h); n > 0; --n) {
    pile->step();
    EXPECT_FALSE(any(pile->out.fault));
    for (std::size_t i = 0; i < scene.subjects.size(); ++i) {
      const RigidBodyState& x = pile->at(i);
      moments.push_back({x.X_WB.p, x.v_W, x.w_B, x.X_WB.q});
    }
  }
  return moments;
}

/// A scene of one body that touches the world alone.
template <class I>
struct Alone : TouchingBodies<I, 1> {
  using Contacts = FixedContacts<12, 3, 48>;
};

Real difference(const std::vector<Moment>& a, const std::vector<Moment>& b) {
  constexpr Real size = 0.02;  // m, of a body
  Real most = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    most = std::max({most, (a[i].p - b[i].p).norm() / size, (a[i].v - b[i].v).norm(),
                     size * (a[i].w_B - b[i].w_B).norm(), (a[i].q.coeffs() - b[i].q.coeffs()).norm()});
  return most;
}

/// Returns the scene without the unrelated bodies.
DrawnScene subjects_of(DrawnScene scene) {
  scene.others.clear();
  return scene;
}

template <class I>
struct Compositions : ::testing::Test {
  /// Expects subjects of drawn scenes to move in Reference as beside unrelated bodies.
  template <class Reference>
  static void expect_alike(int subjects, Unrelated unrelated) {
    Real worst = 0;
    for (unsigned n = 0; n < draws; ++n) {
      const DrawnScene scene = drawn(n, subjects, unrelated);
      const Real apart = difference(run<Reference>(subjects_of(scene)), run<FewBodies<I>>(scene));
      EXPECT_LT(apart, tolerance) << "scene " << n << ", beside bodies " << name_of(unrelated);
      worst = std::max(worst, apart);
    }
    std::printf("%s, beside bodies %s: %.1e apart\n", I::name, name_of(unrelated), worst);
  }
};
using Integrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(Compositions, Integrators);

TYPED_TEST(Compositions, MoveABodyOnObstaclesAlike) {
  for (const Unrelated unrelated : unrelated_to<TypeParam>)
    this->template expect_alike<Alone<TypeParam>>(1, unrelated);
}

TYPED_TEST(Compositions, MoveABodyOnABodyAlike) {
  for (const Unrelated unrelated : unrelated_to<TypeParam>)
    this->template expect_alike<FewBodies<TypeParam>>(2, unrelated);
}

TYPED_TEST(Compositions, TipABrickOverAnEdgeAlike) {
  const auto end = [](auto& pile, bool beside) {
    set_law(pile.par, law_of(2e3, 0.5, 0.5));
    pile.par.gravity_W = Vec3(0, 0, -earth_gravity);
    add_box(pile.par, at(Vec3(-0.1, 0, -0.02)), Vec3(0.1, 0.1, 0.02));
    pile.add_brick({.X_WB = at(Vec3(0.002, 0, 0.005)), .V_WB = {}});
    if (beside) pile.add_brick({.X_WB = at(Vec3(5, 0, 0)), .V_WB = {}}, 0.1);
    EXPECT_TRUE(pile.run(1.5));
    return pile.p(0);
  };
  const auto alone = std::make_unique<Pile<Alone<TypeParam>>>();
  const auto two = std::make_unique<Pile<FewBodies<TypeParam>>>();
  const Vec3 a = end(*alone, false), b = end(*two, true);
  EXPECT_LT(a.z(), -1) << "stays on the edge";
  EXPECT_LT((a - b).norm(), tolerance);
}

}  // namespace
}  // namespace godobject::test_compositions
