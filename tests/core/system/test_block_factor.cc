// Factor of a block system against the full system: rings, grids, cliques and random graphs of bodies, on
// joints or not. Impedances are up to 1e10 times as stiff, over a step, as the bodies are heavy.
#include <cstdio>

#include "tests/core/system/graphs.h"

namespace godobject::test_block_factor {
namespace {

using namespace block_graphs;

constexpr std::size_t max_bodies = 64;
using Free = BlockSystem<max_bodies, max_bodies*(max_bodies - 1) / 2, 8 * max_bodies, false>;
constexpr std::size_t most_jointed = 24;
using Jointed =
    BlockSystem<most_jointed, most_jointed * most_jointed, most_jointed*(most_jointed - 1) / 2, true>;

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

/// Adds the errors of this system, factored, for some impulses on its bodies.
void add_miss(const Bodies<Free>& s, Random& random, Miss& miss) {
  Free::Vector b = random_impulses<Free>(s.size(), random), V{};
  const LongVector impulses = in_full(b, s.size());
  solve(*s.system, b, V);
  measure(in_full(s), impulses, in_full(V, s.size()), miss);
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
      Bodies<Free> s = random_bodies<Free>(graph, stiffest, random);
      s.factor();
      ASSERT_TRUE(s.system->is_complete) << name;
      add_miss(s, random, miss);
    }
    expect_solved(name, stiffest, miss);
  }
}

TEST(BlockFactor, SolvesTwoBodies) { expect_solves("two", {{0, 1}}, 100); }
TEST(BlockFactor, SolvesARing) {
  expect_solves("large ring", ring(large), few);
  expect_solves("ring", ring(solved), few);
}
TEST(BlockFactor, SolvesAGrid) {
  expect_solves("large grid", grid(large / 4, 4), few);
  expect_solves("grid", grid(3, solved / 3), few);
}
TEST(BlockFactor, SolvesACliqueOfSomeAndOfFour) {
  expect_solves("clique", clique(solved), few);
  expect_solves("four", clique(4), 30);
}

TEST(BlockFactor, SolvesRandomGraphs) {
  Random random(2);
  for (const Real stiffest : contrasts) {
    Miss miss;
    for (int n = 0; n < 10 * few; ++n) {
      const std::uint32_t size = 2 + number_below(large / 2 - 1, random);
      Bodies<Free> s =
          random_bodies<Free>(random_graph(size, number_below(2 * size, random), random), stiffest, random);
      s.factor();
      ASSERT_TRUE(s.system->is_complete);
      add_miss(s, random, miss);
    }
    expect_solved("random graph", stiffest, miss);
  }
}

/// Every pair of a tree has its block, and no body gets new neighbours as others are eliminated.
TEST(BlockFactor, ATreeHasNoFill) {
  Random random(3);
  for (int n = 0; n < 50; ++n) {
    const std::uint32_t size = 2 + number_below(max_bodies - 1, random);
    Bodies<Free> s = random_bodies<Free>(random_tree(size, random), contrasts[0], random);
    s.begin();
    EXPECT_TRUE(s.system->is_complete);
    EXPECT_EQ(s.system->first[size], size - 1);
  }
  // of the n - 3 that close a ring's triangles, the fewest
  Bodies<Free> s = random_bodies<Free>(ring(max_bodies), contrasts[0], random);
  s.begin();
  EXPECT_TRUE(s.system->is_complete);
  EXPECT_EQ(s.system->first[max_bodies], 2 * max_bodies - 3);
}

/// A clique has all the blocks that it ever needs, and a child body one more.
TEST(BlockFactor, FillsAllBlocksAndSaysWhenThereAreTooFew) {
  std::uint32_t size = 2;
  while ((size + 1) * size / 2 <= Free::room) ++size;
  Graph graph = clique(size);
  for (; graph.size() < Free::room; ++size) graph.insert({0, size});
  ASSERT_LT(size, max_bodies);
  Random random(4);
  Bodies<Free> s = random_bodies<Free>(graph, contrasts[0], random);
  s.factor();
  EXPECT_TRUE(s.system->is_complete);
  EXPECT_EQ(s.system->first[size], Free::room);
#ifdef NDEBUG
  Miss miss;
  add_miss(s, random, miss);
  expect_solved("all blocks", contrasts[0], miss);
#endif
  graph.insert({0, size});
  for (const Graph& too_much : {graph, clique(max_bodies)}) {
    s = random_bodies<Free>(too_much, contrasts[0], random);
    s.begin();
    EXPECT_FALSE(s.system->is_complete);
    EXPECT_LE(s.system->first[s.size()], Free::room);
  }
}

/// A grid in which a third of the pairs is near: active terms change, couplings do not.
TEST(BlockFactor, FollowsWhatActs) {
  Random random(5);
  for (const Real stiffest : contrasts) {
    Miss kept, joined, separated;
    for (int n = 0; n < 3 * few; ++n) {
      Bodies<Free> s = random_bodies<Free>(grid(3, solved / 3), stiffest, random,
                                           [&](const Edge&) { return random.integer(0, 2) > 0; });
      s.factor();
      ASSERT_TRUE(s.system->is_complete);
      const auto change = [&](Miss& miss, auto acts) {
        for (Between& b : s.between) {
          b.acts = acts(b);
          if (b.acts) b.A = random_impedance(stiffest, random);
        }
        s.load();
        factorize(*s.system);
        add_miss(s, random, miss);
      };
      change(kept, [](const Between& b) { return b.acts; });
      change(separated, [&](const Between& b) { return b.acts && random.integer(0, 1) > 0; });
      change(joined, [&](const Between&) { return random.integer(0, 3) > 0; });
      change(separated, [&](const Between& b) { return b.acts && random.integer(0, 1) > 0; });
      change(joined, [](const Between&) { return true; });
    }
    expect_solved("grid with other forces", stiffest, kept);
    expect_solved("grid with pairs that part", stiffest, separated);
    expect_solved("grid with pairs that meet", stiffest, joined);
  }
}

/// Systems of some of the bodies, one after the other in the same memory.
TEST(BlockFactor, SolvesOneSystemAfterTheOther) {
  Random random(6);
  Graph graph = ring(5);
  for (const auto& [i, j] : clique(4)) graph.insert({i + 5, j + 5});
  for (const auto& [i, j] : grid(3, 2)) graph.insert({i + 9, j + 9});
  Bodies<Free> s = random_bodies<Free>(graph, contrasts[1], random);
  const Free::Vector b = random_impulses<Free>(s.size(), random);
  Free::Vector V{}, used{};
  for (const auto& [first, end] : {Edge{0, 5}, Edge{5, 9}, Edge{9, 15}}) {
    s.begin([first = first, end = end](std::uint32_t i) { return i >= first && i < end; });
    EXPECT_EQ(s.system->size, end - first);
    s.load();
    factorize(*s.system);
    used = b;
    solve(*s.system, used, V);
  }
  Miss miss;
  measure(in_full(s), in_full(b, s.size()), in_full(V, s.size()), miss);
  expect_solved("three systems", contrasts[1], miss);
}

TEST(BlockFactor, MultipliesLikeTheMatrix) {
  Random random(7);
  for (int n = 0; n < 50; ++n) {
    const std::uint32_t size = 2 + number_below(std::uint32_t{most_jointed} - 1, random);
    Bodies<Free> s = random_bodies<Free>(random_graph(size, 20, random), 1e3, random);
    s.begin();
    s.load();
    const Free::Vector V = random_impulses<Free>(size, random);
    Free::Vector AV{};
    s.system->multiply(V, AV);
    const LongMatrix A = in_full(s);
    EXPECT_LT((in_full(AV, size) - A * in_full(V, size)).norm(), 1e-15 * A.norm() * in_full(V, size).norm());
  }
}

/// How far the solution is from the one in the coordinates of the joints, in the norm of A.
Real miss_on_joints(Bodies<Jointed>& s, Random& random) {
  Jointed::Vector b = random_impulses<Jointed>(s.size(), random), V{};
  const LongMatrix B = allowed(s), A = in_full(s), K = B.transpose() * A * B;
  s.factor();
  EXPECT_TRUE(s.system->is_complete);
  if (B.cols() == 0) return 0;  // nothing moves
  const LongVector exact = B * K.ldlt().solve(B.transpose() * in_full(b, s.size()));
  solve(*s.system, b, V);
  const LongVector off = in_full(V, s.size()) - exact;
  return static_cast<Real>(std::sqrt(off.dot(A * off) / exact.dot(A * exact)));
}

TEST(BlockFactor, SolvesRandomGraphsOnRandomJoints) {
  Random random(1);
  for (const Real stiffest : {1e2, 1e4, 1e7, 1e10}) {
    Real worst = 0;
    std::size_t joints = 0;
    for (int n = 0; n < 60; ++n) {
      const auto size =
          static_cast<std::uint32_t>(random.integer(2, n < 50 ? 8 : static_cast<int>(most_jointed)));
      Bodies<Jointed> s = random_bodies<Jointed>(random_graph(size, number_below(2 * size, random), random),
                                                 stiffest, random);
      add_random_joints(random, s);
      for (const JointEdge& edge : s.joints) joints += edge.kind != JointKind::free ? 1 : 0;
      keep_worst(worst, miss_on_joints(s, random));
    }
    std::printf("on joints, contacts to %.0e: %zu joints, V off by %.1e\n", stiffest, joints, worst);
    EXPECT_GT(joints, 60u);
    EXPECT_LT(worst, 1e3 * std::numeric_limits<Real>::epsilon() * std::max(stiffest, Real(1e3)));
  }
}

}  // namespace
}  // namespace godobject::test_block_factor
