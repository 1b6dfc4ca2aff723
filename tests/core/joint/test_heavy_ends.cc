// Heavy bodies at the end of light ones, which snap taut within a step: the energy does not increase, and the
// joints hold (39).
#include <memory>

#include <gtest/gtest.h>

#include "tests/core/joint/grasper_tool.h"
#include "tests/core/joint/heavy_ends.h"
#include "tests/core/joint/usual_scene.h"

namespace godobject::test_heavy_ends {
namespace {

template <class I>
class HeavyEnds : public ::testing::Test {};
TYPED_TEST_SUITE(HeavyEnds, BothIntegrators);

TYPED_TEST(HeavyEnds, ReleasedChainsGainNothing) {
  for (const Real ratio : {100.0, 500.0, 1000.0, 2000.0, 10000.0})
    for (std::size_t links = 2; links <= 5; ++links)
      for (const Real degrees : {90.0, 115.0, 160.0}) {
        const Swung w = released_chain<TypeParam>(links, ratio, degrees * pi / 180);
        EXPECT_FALSE(w.fault) << links << " links, " << ratio << ", " << degrees;
        EXPECT_LT(w.gain, 1e-3) << links << " links, " << ratio << ", " << degrees;
        EXPECT_LT(w.drift, 1e-5) << links << " links, " << ratio << ", " << degrees;
      }
}

/// Chains on ball joints with one heavy end, trees of hinges with random masses, and the same thrown.
enum class Kind { chain, tree, thrown };

template <class I>
Swung random_case(Kind kind, unsigned seed, int finer = 1) {
  using S = Articulated<I>;
  Random random(2 * seed + static_cast<unsigned>(kind));
  const auto run = std::make_unique<Running<S>>();
  run->par.h = random.log_uniform(1e-4, 5e-3);
  run->par.num_bodies = static_cast<std::size_t>(random.integer(2, 8));
  run->par.gravity_W = Vec3(0, 0, -9.81);
  const Real size = random.log_uniform(0.02, 0.3), spread = random.log_uniform(1, 1e4);
  for (std::size_t i = 0; i < run->par.num_bodies; ++i) {
    add_random_body(run->par, i, size, random);
    BodyParams<S>& b = run->par.bodies[i];
    const bool end = i + 1 == run->par.num_bodies;
    const Real drawn = random.log_uniform(1, spread);
    const Real m = 0.05 * (kind != Kind::chain ? drawn : end ? spread : 1);
    const Mat3 I_B = b.body.I_B / b.body.m * m;
    b.body = rigid_body(m, I_B);
    if (kind == Kind::chain) {
      b.joint.kind = JointKind::ball;
      b.joint.parent = i == 0 ? world : i - 1;
    }
    if (kind == Kind::tree && b.joint.kind == JointKind::free) b.joint.kind = JointKind::ball;
    // sliding bodies fall for ever
    if (b.joint.kind == JointKind::slider || b.joint.kind == JointKind::cylindrical)
      b.joint.kind = JointKind::hinge;
  }
  place_randomly(run->par, run->x, size, kind == Kind::thrown ? random.log_uniform(1, 100) : 0, random);
  const int steps = finer * static_cast<int>(std::min(1.0 / run->par.h, 2000.0));
  run->par.h /= finer;
  return swing(*run, steps);
}

TYPED_TEST(HeavyEnds, RandomToolsGainNothing) {
  for (const Kind kind : {Kind::chain, Kind::tree, Kind::thrown})
    for (unsigned seed = 0; seed < 300; ++seed) {
      const Swung w = random_case<TypeParam>(kind, seed);
      EXPECT_FALSE(w.fault) << "kind " << static_cast<int>(kind) << ", seed " << seed;
      // a gain of implicit Euler where joints push for long is its first order: it falls with the step
      const bool first_order = TypeParam::order == 1 && w.gain >= 1e-3 && w.gain < 1e-2;
      const Real bound = first_order ? 0.3 * w.gain : 1e-3;
      const Real gain = first_order ? random_case<TypeParam>(kind, seed, 4).gain : w.gain;
      EXPECT_LT(gain, bound) << "kind " << static_cast<int>(kind) << ", seed " << seed;
      EXPECT_LT(w.drift, 1e-5) << "kind " << static_cast<int>(kind) << ", seed " << seed;
    }
}

}  // namespace
}  // namespace godobject::test_heavy_ends
