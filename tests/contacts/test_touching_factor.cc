// The factor of bodies that touch in loops against the same system written out in full: rings, grids, cliques and
// random graphs, with contacts up to 1e10 times as stiff, over a step, as the bodies are heavy.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdio>

#include "tests/contacts/touching_graphs.h"

namespace godobject::test_touching_factor {
namespace {

using namespace touching_graphs;

#ifdef NDEBUG
constexpr std::uint32_t large = max_bodies;
constexpr int few = 5;
#else
constexpr std::uint32_t large = 12;  // without optimisation the system in full takes a hundred times as long
constexpr int few = 1;
#endif
constexpr std::array contrasts{1e4, 1e7, 1e10};  // impedance of the stiffest contacts, of the bodies' mass
constexpr std::uint32_t solved = large / 2;      // bodies of the systems that are also solved in full

/// How far V is from the solution of A V = b, relative.
struct Miss {
  Real residual = 0;  // |A V - b| of |A| |V| + |b|
  Real scaled =
      0;  // the same with A's diagonal scaled to ones: light bodies count as much as the stiffest contact
  Real balance = 0;  // V A V of V b
  Real error = 0;    // of the velocities, in the norm of A; of small systems
  std::size_t systems = 0;
};

void keep_worst(Real& worst, Long miss) {
  worst =
      std::isfinite(miss) ? std::max(worst, static_cast<Real>(miss)) : std::numeric_limits<Real>::infinity();
}

void measure(const LongMatrix& A, const LongVector& b, const LongVector& V, Miss& miss) {
  const LongVector left = A * V - b, d = A.diagonal().cwiseSqrt();
  keep_worst(miss.residual, left.norm() / (A.norm() * V.norm() + b.norm()));
  keep_worst(miss.scaled,
             left.cwiseQuotient(d).norm() / (V.cwiseProduct(d).norm() + b.cwiseQuotient(d).norm()));
  keep_worst(miss.balance, std::abs(V.dot(A * V) / V.dot(b) - 1));
  ++miss.systems;
  if (V.size() > Eigen::Index{6} * solved) return;
  const LongVector exact = A.ldlt().solve(b), off = V - exact;
  keep_worst(miss.error, std::sqrt(off.dot(A * off) / exact.dot(b)));
}

/// Of this system, factored, at some impulses on its bodies.
void add_miss(const System& s, Random& random, Miss& miss) {
  Twists b{}, V{};
  for (std::size_t i = 0; i < s.size; ++i)
    b[i] = {.w = Column(Vec3(0.01 * brick_mass * random.vector())),
            .v = Column(Vec3(brick_mass * random.vector()))};
  const LongVector impulses = in_full(b, s.size);
  solve(*s.factor, b, V);
  measure(in_full(s), impulses, in_full(V, s.size), miss);
}

/// Backward stable; ahead, rounding is as much larger as the contacts are stiffer than the bodies are heavy.
void expect_solved(const char* name, Real stiffest, const Miss& miss) {
  std::printf(
      "%s, contacts to %.0e: %zu systems, residual %.1e, scaled %.1e, energy off by %.1e, V by %.1e\n", name,
      stiffest, miss.systems, miss.residual, miss.scaled, miss.balance, miss.error);
  const Real ahead = 100 * std::numeric_limits<Real>::epsilon() * stiffest;
  EXPECT_LT(miss.residual, 1e-15) << name << ", contacts to " << stiffest;
  EXPECT_LT(miss.scaled, 1e-14) << name << ", contacts to " << stiffest;
  EXPECT_LT(miss.balance, ahead) << name << ", contacts to " << stiffest;
  EXPECT_LT(miss.error, ahead) << name << ", contacts to " << stiffest;
}

/// Random systems of this graph, factored for the first time.
void expect_solves(const char* name, const Graph& graph, int times) {
  Random random(1);
  for (const Real stiffest : contrasts) {
    Miss miss;
    for (int n = 0; n < times; ++n) {
      System s = random_system(graph, stiffest, random);
      ASSERT_EQ(s.tree->num_islands, 1u);
      ASSERT_TRUE(s.factorize(false)) << name;
      add_miss(s, random, miss);
    }
    expect_solved(name, stiffest, miss);
  }
}

TEST(TouchingFactor, SolvesTwoBodies) { expect_solves("two", {{0, 1}}, 100); }
TEST(TouchingFactor, SolvesARing) {
  expect_solves("large ring", ring(large), few);
  expect_solves("ring", ring(solved), few);
}
TEST(TouchingFactor, SolvesAGrid) {
  expect_solves("large grid", grid(large / 4, 4), few);
  expect_solves("grid", grid(3, solved / 3), few);
}
TEST(TouchingFactor, SolvesACliqueOfSomeAndOfFour) {
  expect_solves("clique", clique(solved), few);
  expect_solves("four", clique(4), 30);
}

TEST(TouchingFactor, SolvesRandomGraphs) {
  Random random(2);
  for (const Real stiffest : contrasts) {
    Miss miss;
    for (int n = 0; n < 10 * few; ++n) {
      const std::uint32_t size = 2 + number_below(large / 2 - 1, random);
      System s = random_system(random_graph(size, number_below(2 * size, random), random), stiffest, random);
      ASSERT_TRUE(s.factorize(false));
      add_miss(s, random, miss);
    }
    expect_solved("random graph", stiffest, miss);
  }
}

/// Every pair of a tree has its block, and no body gets new neighbours as others are eliminated.
TEST(TouchingFactor, ATreeHasNoFill) {
  Random random(3);
  for (int n = 0; n < 50; ++n) {
    const std::uint32_t size = 2 + number_below(max_bodies - 1, random);
    System s = random_system(random_tree(size, random), contrasts[0], random);
    ASSERT_TRUE(s.factorize(false));
    EXPECT_EQ(s.factor->size, size);
    EXPECT_EQ(s.factor->first[size], size - 1);
  }
  System s = random_system(ring(max_bodies), contrasts[0],
                           random);  // of the n - 3 that close its triangles, the fewest
  ASSERT_TRUE(s.factorize(false));
  EXPECT_EQ(s.factor->first[max_bodies], 2 * max_bodies - 3);
}

/// A clique has all the blocks that it ever needs, and a body that hangs on it one more.
TEST(TouchingFactor, FillsAllBlocksAndReportsWhenThereAreTooFew) {
  std::uint32_t size = 2;
  while ((size + 1) * size / 2 <= Factor::max_blocks) ++size;
  Graph graph = clique(size);
  for (; graph.size() < Factor::max_blocks; ++size) graph.insert({0, size});
  ASSERT_LT(size, max_bodies);
  Random random(4);
  System s = random_system(graph, contrasts[0], random);
  EXPECT_TRUE(s.factorize(false));
  EXPECT_EQ(s.factor->first[size], Factor::max_blocks);
#ifdef NDEBUG
  Miss miss;
  add_miss(s, random, miss);
  expect_solved("all blocks", contrasts[0], miss);
#endif
  graph.insert({0, size});
  EXPECT_FALSE(random_system(graph, contrasts[0], random).factorize(false));
  EXPECT_FALSE(random_system(clique(max_bodies), contrasts[0], random).factorize(false));
}

/// Of a grid in which a third of the pairs is near: cases change from pass to pass.
TEST(TouchingFactor, FollowsTheCasesOfItsContacts) {
  Random random(5);
  for (const Real stiffest : contrasts) {
    Miss kept, joined, parted;
    for (int n = 0; n < 3 * few; ++n) {
      System s = random_system(grid(3, solved / 3), stiffest, random,
                               [&](const Edge&) { return random.integer(0, 2) > 0; });
      ASSERT_TRUE(s.factorize(false));
      const auto change = [&](Miss& miss, auto touches) {
        s.tree->each_pair(s.tree->islands[0], [&](TouchingPair& pair) {
          pair.touches = touches(pair);
          if (pair.touches) pair.A = random_impedance(stiffest, random);
        });
        ASSERT_TRUE(s.factorize(true));
        add_miss(s, random, miss);
      };
      change(kept, [](const TouchingPair& pair) { return pair.touches; });
      change(parted, [&](const TouchingPair& pair) { return pair.touches && random.integer(0, 1) > 0; });
      change(joined, [&](const TouchingPair&) { return random.integer(0, 3) > 0; });
      change(parted, [&](const TouchingPair& pair) { return pair.touches && random.integer(0, 1) > 0; });
      change(joined, [](const TouchingPair&) { return true; });
    }
    expect_solved("grid with other forces", stiffest, kept);
    expect_solved("grid with pairs that part", stiffest, parted);
    expect_solved("grid with pairs that meet", stiffest, joined);
  }
}

/// Each island by itself, one after the other with the same factor.
TEST(TouchingFactor, SolvesOneIslandOfMany) {
  Random random(6);
  Graph graph = ring(5);
  for (const auto& [i, j] : clique(4)) graph.insert({i + 5, j + 5});
  for (const auto& [i, j] : grid(3, 2)) graph.insert({i + 9, j + 9});
  System s = random_system(graph, contrasts[1], random);
  ASSERT_EQ(s.tree->num_islands, 3u);
  Twists b{}, V{}, of_one{}, used{};
  for (std::size_t i = 0; i < s.size; ++i)
    b[i] = {.w = Column(Vec3::Zero()), .v = Column(Vec3(brick_mass * random.vector()))};
  for (std::size_t n = 0; n < 3; ++n) {
    const Island& island = s.tree->islands[n];
    ASSERT_TRUE(factorize(island, false, *s.tree, *s.factor));
    used = b;
    solve(*s.factor, used, of_one);
    s.tree->each_body(island, [&](std::uint32_t i, const TouchingBody&) { V[i] = of_one[i]; });
  }
  Miss miss;
  measure(in_full(s), in_full(b, s.size), in_full(V, s.size), miss);
  expect_solved("three islands", contrasts[1], miss);
}

}  // namespace
}  // namespace godobject::test_touching_factor
