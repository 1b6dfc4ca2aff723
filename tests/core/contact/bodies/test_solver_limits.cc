// Doubts that a step reports about its solver: residuals of contact forces, iterations that were cut off,
// subdivided stages.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/jointed_pile.h"
#include "tests/core/contact/usual_scenes.h"
#include "tests/core/snapping_chain.h"

namespace godobject::test_solver_limits {
namespace {

constexpr std::array doubts{Limited::contact_residual, Limited::newton_cap, Limited::substeps,
                            Limited::net_cap};

/// Steps with each doubt, in the order of doubts.
struct Counts {
  std::array<int, doubts.size()> of{};
  int steps = 0;

  void add(Limited limited) {
    for (std::size_t i = 0; i < doubts.size(); ++i) of[i] += has(limited, doubts[i]) ? 1 : 0;
    ++steps;
  }
};

/// Stiff bricks that are thrown together, with long steps.
template <class I>
void heaps_say_what_misses() {
  Counts counts;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const auto pile = std::make_unique<Pile<FewBodies<I>>>();
    pile->par.h = 5e-3;
    set_law(pile->par, law_of(1e7, random.uniform(0, 1), 0.5));
    pile->add_floor();
    for (int i = 0; i < 8; ++i) {
      const Vec3 from = 0.03 * random.direction() + Vec3(0, 0, 0.05);
      pile->add_brick({.X_WB = {.p = from, .q = random.rotation()},
                       .V_WB = {.w = 20 * random.vector(), .v = -10 * from}});
    }
    for (int n = 0; n < 100; ++n) {
      pile->step();
      const ContactReport& report = pile->out.contacts;
      const Limited limited = pile->out.limited;
      EXPECT_EQ(has(limited, Limited::contact_residual), report.residual_share > doubtful_residual);
      EXPECT_EQ(has(limited, Limited::newton_cap), report.num_stopped > 0);
      if (report.num_stopped > 0) {
        EXPECT_EQ(report.newton_iterations, max_newton_iterations) << seed;
      }
      EXPECT_FALSE(has(limited, Limited::substeps) || has(limited, Limited::net_cap));
      counts.add(limited);
    }
  }
  std::printf("%s: of %d steps of heaps %d miss, %d were stopped\n", I::name, counts.steps, counts.of[0],
              counts.of[1]);
  EXPECT_GT(counts.of[0], 0);
  EXPECT_GT(counts.of[1], 0);
}
TEST(SolverLimits, AreOfHeapsImplicitEuler) { heaps_say_what_misses<ImplicitEuler>(); }
TEST(SolverLimits, AreOfHeapsTrBdf2) { heaps_say_what_misses<TrBdf2>(); }

/// A brick that lies on the floor is solved without doubt.
template <class I>
void rest_is_without_doubt() {
  const auto pile = std::make_unique<Pile<FewBodies<I>>>();
  pile->add_floor();
  pile->add_brick({.X_WB = at(Vec3(0, 0, brick_half.z())), .V_WB = {}});
  Counts counts;
  for (int n = 0; n < 500; ++n) {
    pile->step();
    counts.add(pile->out.limited);
  }
  for (const int steps : counts.of) EXPECT_EQ(steps, 0) << I::name;
}
TEST(SolverLimits, AreNotOfRestImplicitEuler) { rest_is_without_doubt<ImplicitEuler>(); }
TEST(SolverLimits, AreNotOfRestTrBdf2) { rest_is_without_doubt<TrBdf2>(); }

/// A chain that snaps taut needs sub-steps; one that hangs does not.
template <class I>
int subdivided_steps(Real angle) {
  const auto run = std::make_unique<Running<Jointed<I>>>();
  run->par.h = 1e-2;
  build_snapping_chain(*run, 4, angle, true);
  Counts counts;
  for (int n = 0; n < 1000; ++n) {
    run->step();
    counts.add(run->out.limited);
  }
  return counts.of[2];
}
TEST(SolverLimits, AreOfChainsThatSnap) {
  EXPECT_GT(subdivided_steps<ImplicitEuler>(175 * pi / 180), 0);
  EXPECT_GT(subdivided_steps<TrBdf2>(175 * pi / 180), 0);
  EXPECT_EQ(subdivided_steps<ImplicitEuler>(0), 0);
  EXPECT_EQ(subdivided_steps<TrBdf2>(0), 0);
}

}  // namespace
}  // namespace godobject::test_solver_limits
