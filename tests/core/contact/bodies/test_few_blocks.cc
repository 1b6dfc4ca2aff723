// Heaps that couple more bodies than the factor has blocks for, with a tenth of the blocks of the scene. The
// step reports it, the incomplete factor is used, and the energy does not increase.
#include <gtest/gtest.h>

#include <cstdio>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_few_blocks {
namespace {

constexpr std::size_t num_bricks = 12;
template <class I, std::size_t blocks>
struct Heap : TouchingBodies<I, num_bricks> {
  using Contacts = BodyContacts<12 * num_bricks, num_bricks + 2, 40 * num_bricks, blocks>;
};
constexpr std::size_t room = BodyContactScratch<BodyContacts<1, 1, 1>, num_bricks>::room, tenth = room / 10;
static_assert(tenth > 0);

struct Case {
  Real k, zeta, h, mu;
};
std::ostream& operator<<(std::ostream& os, const Case& c) {
  return os << "k " << c.k << " N/m, " << c.zeta << " times critical, h " << c.h << " s, mu " << c.mu;
}

/// Bricks thrown together above a floor, side by side in two layers that nearly touch.
template <class S>
std::unique_ptr<Pile<S>> heap(const Case& c, Random& random) {
  auto pile = std::make_unique<Pile<S>>();
  pile->par.h = c.h;
  pile->add_floor();
  set_law(pile->par, law_of(c.k, c.zeta, c.mu));
  for (std::size_t i = 0; i < num_bricks; ++i) {
    const auto n = static_cast<Real>(i % 6);
    const Vec3 p(0.034 * std::fmod(n, 2), 0.018 * std::floor(n / 2), i < 6 ? 0.0055 : 0.0165);
    const Vec3 to_middle = (Vec3(0.017, 0.018, 0) - p).cwiseProduct(Vec3(1, 1, 0)) * 10;
    pile->add_brick({.X_WB = at(p, 0.01 * random.vector()),
                     .V_WB = {.w = random.vector(), .v = to_middle + Vec3(0, 0, i < 6 ? 0 : -0.3)}});
  }
  return pile;
}

struct Outcome {
  Real gain = 0, residual = 0;
  int steps = 0, without_room = 0;
};
template <class S>
Outcome run(const Case& c, Random& random) {
  const auto pile = heap<S>(c, random);
  const Real first = energy(pile->par, pile->x);
  Outcome o;
  for (int n = 0; n < std::min(Real(0.3), 300 * c.h) / c.h; ++n) {
    pile->step();
    const auto& report = pile->out.contacts;
    EXPECT_EQ(has(pile->out.fault, Fault::blocks_full), report.num_without_room > 0);
    if (any(pile->out.fault) && pile->out.fault != Fault::blocks_full)
      o.gain = std::numeric_limits<Real>::infinity();
    o.gain = std::max(o.gain, energy(pile->par, pile->x) - first);
    o.residual = std::max(o.residual, report.residual);
    o.without_room += report.num_without_room > 0 ? 1 : 0;
    ++o.steps;
    if (!(o.gain < 1e3)) break;
  }
  return o;
}

#ifdef NDEBUG
constexpr std::array steps{1e-4, 1e-3, 5e-3};
#else
constexpr std::array steps{1e-3};
#endif

template <class I>
class FewBlocks : public ::testing::Test {};
using BothIntegrators = ::testing::Types<ImplicitEuler, TrBdf2>;
TYPED_TEST_SUITE(FewBlocks, BothIntegrators);

TYPED_TEST(FewBlocks, AHeapGainsNoEnergyAndSaysWhatItLacks) {
  Random random(1);
  Outcome all;
  int cases = 0;
  for (const Real mu : {0.0, 0.5})
    for (int decade = 2; decade <= 9; ++decade)
      for (const Real zeta : {0.0, 0.1, 1.0, 10.0, 100.0})
        for (const Real h : steps) {
          const Case c{.k = std::pow(10, decade), .zeta = zeta, .h = h, .mu = mu};
          const Outcome o = run<Heap<TypeParam, tenth>>(c, random);
          EXPECT_LT(o.gain, 1e-9) << TypeParam::name << ": " << c;
          all.gain = std::max(all.gain, o.gain);
          all.steps += o.steps;
          all.without_room += o.without_room;
          ++cases;
        }
  std::printf("%s, %zu blocks of %zu: %d cases, %d of %d steps without room, energy gained at most %.1e J\n",
              TypeParam::name, tenth, room, cases, all.without_room, all.steps, all.gain);
  EXPECT_GT(all.without_room, all.steps / 4);
}

/// A heap comes to rest on the forces that carry it, with enough blocks and with too few.
TEST(FewBlocksAtRest, CarryTheHeap) {
  const Case c{.k = 2e4, .zeta = 1, .h = 1e-3, .mu = 0.5};
  const auto rest = []<class S>(Pile<S>& pile) {
    for (int n = 0; n < 2000; ++n) pile.step();
    Wrench on_floor;
    Real speed = 0;
    for (std::size_t i = 0; i < num_bricks; ++i) {
      on_floor.f += pile.out.bodies[i].contact.F_W.f;
      speed = std::max(speed, pile.at(i).v_W.norm());
    }
    return std::pair(on_floor.f, speed);
  };
  Random random(2);
  const auto few = heap<Heap<ImplicitEuler, tenth>>(c, random);
  const auto [f, speed] = rest(*few);
  std::printf("at rest: %.3g m/s, floor bears %.6f of the weight, %d islands without room, residual %.1e N\n",
              speed, f.z() / (num_bricks * brick_mass * earth_gravity), few->out.contacts.num_without_room,
              few->out.contacts.residual);
  EXPECT_LT(speed, 1e-4);
  EXPECT_NEAR(f.z(), num_bricks * brick_mass * earth_gravity, 1e-3 * num_bricks * brick_mass * earth_gravity);
}

/// The report of a step is of its worst stage. A TR-BDF2 step without acceleration begins with an implicit
/// Euler stage of c h. It reports at least as much as an implicit Euler step of that length.
TEST(FewBlocks, AreToldOfTheWorstStage) {
  constexpr Real rounding = 1e-6, of_forces = 1e-11;  // of two programs; N
  const Case c{.k = 1e6, .zeta = 0.1, .h = 1e-3, .mu = 0.5};
  for (unsigned seed = 0; seed < 4; ++seed) {
    Random random(seed), again(seed);
    const auto whole = heap<Heap<TrBdf2, tenth>>(c, random);
    const auto first = heap<Heap<ImplicitEuler, tenth>>(c, again);
    first->par.h = TrBdf2::c * whole->par.h;
    for (int n = 0; n < 100; ++n) {
      for (std::size_t i = 0; i < num_bricks; ++i) {
        whole->x.bodies[i].memory.known = false;
        first->x.bodies[i].x = whole->x.bodies[i].x;
      }
      first->x.contacts = whole->x.contacts;
      first->x.tick = whole->x.tick;
      whole->step();
      first->step();
      const ContactReport &all = whole->out.contacts, &one = first->out.contacts;
      EXPECT_GE(all.newton_iterations, one.newton_iterations) << "seed " << seed << ", step " << n;
      EXPECT_GE(all.iterations, one.iterations) << "seed " << seed << ", step " << n;
      EXPECT_GE(all.num_without_room, one.num_without_room) << "seed " << seed << ", step " << n;
      EXPECT_GE(all.residual, (1 - rounding) * one.residual - of_forces) << "seed " << seed << ", step " << n;
    }
  }
}

}  // namespace
}  // namespace godobject::test_few_blocks
