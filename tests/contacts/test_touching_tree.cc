// The solve of bodies that touch against the same system written out in full: product, elimination along the tree of
// the stiffest pairs, and conjugate gradients over all of them.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdio>

#include "tests/contacts/bricks.h"

namespace godobject::test_touching_tree {
namespace {

constexpr std::size_t max_bodies = 24, max_pairs = 60;
using Part = BodyContacts<1, 1, max_pairs>;
using Work = BodyContactScratch<Part, max_bodies>;
using Tree = ContactTree<max_bodies, max_pairs>;
using Twists = std::array<AnchorTwist, max_bodies>;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;
using Mat6 = Eigen::Matrix<Real, 6, 6>;

Block block(const Mat3& A) {
  return {{Column(Vec3(A.col(0))), Column(Vec3(A.col(1))), Column(Vec3(A.col(2)))}};
}
TwistBlock twist_block(const Mat6& A) {
  return {
      .ww = block(A.block<3, 3>(0, 0)), .wv = block(A.block<3, 3>(0, 3)), .vv = block(A.block<3, 3>(3, 3))};
}
Mat3 cross_matrix(const Vec3& a) {
  Mat3 A;
  A << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
  return A;
}

/// Of a twist where r is measured from: eta_t 1 + (eta_n - eta_t) n n^T at r.
Mat6 impedance_at(const Vec3& r, const Vec3& n, Real eta_n, Real eta_t) {
  Eigen::Matrix<Real, 3, 6> J;
  J << -cross_matrix(r), Mat3::Identity();
  return J.transpose() * (eta_t * Mat3::Identity() + (eta_n - eta_t) * n * n.transpose()) * J;
}

/// Bodies with random contacts between them, and all of it as one matrix.
struct System {
  std::unique_ptr<Work> work = std::make_unique<Work>();
  std::vector<Vec3> p;
  Matrix A;       // of bodies and all pairs
  Matrix A_tree;  // of bodies and what the tree takes of its pairs

  Tree& tree() { return work->tree; }
  const Island& island() const { return work->tree.islands[0]; }  // if all of them are one
  std::size_t size() const { return p.size(); }
};

void add_bodies(std::size_t n, Random& random, System& s) {
  s.A = Matrix::Zero(6 * static_cast<Eigen::Index>(n), 6 * static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i) {
    s.p.push_back(0.02 * random.vector());
    const Real m = brick_mass * random.log_uniform(1, 1000);
    Mat6 A = Mat6::Zero();
    const Mat3 I_B = random.inertia(m * Vec3(1e-5, 5e-5, 6e-5));
    A.block<3, 3>(0, 0) = I_B;
    A.block<3, 3>(3, 3) = m * Mat3::Identity();
    if (random.integer(0, 3) == 0)
      A += impedance_at(0.01 * random.vector(), random.direction(), 10 * m, 3 * m);
    s.tree().bodies[i].A = s.tree().bodies[i].subtree_A = twist_block(A);
    s.work->stages[i].M = m;
    s.work->stages[i].A_ww = block(I_B);
    s.A.block<6, 6>(6 * static_cast<Eigen::Index>(i), 6 * static_cast<Eigen::Index>(i)) = A;
    s.work->touches[i] = true;
  }
}

/// It is the one by which its child hangs.
template <class Tree>
bool in_tree(const TouchingPair& pair, const Tree& tree) {
  const TouchingBody& child = tree.bodies[pair.child];
  return child.parent == pair.parent && &tree.pairs[child.pair] == &pair;
}

/// A pair, and what it adds to the matrix.
void load_pair(TouchingPair& pair, Random& random, System& s) {
  const Vec3 d = s.p[pair.child] - s.p[pair.parent];
  Mat6 A = Mat6::Zero();
  for (int c = random.integer(1, 8); c > 0; --c)
    A += pair.stiffness * impedance_at(0.01 * random.vector(), random.direction(), 1, random.uniform(0, 1));
  pair.d = Column(d);
  pair.A = twist_block(A);
  pair.touches = true;
  pair.stiffness_cap = stiffness_cap(pair.A, s.work->stages[pair.child].M);
  Matrix J = Matrix::Zero(6, s.A.cols());
  const Eigen::Index at_child = Eigen::Index{6} * pair.child, at_parent = Eigen::Index{6} * pair.parent;
  J.middleCols<6>(at_child).setIdentity();
  J.middleCols<6>(at_parent) = -Mat6::Identity();
  J.block<3, 3>(3, at_parent) = cross_matrix(d);
  s.A += J.transpose() * A * J;
  if (in_tree(pair, s.work->tree)) s.A_tree += pair.stiffness_cap * J.transpose() * A * J;
}

/// The first size - 1 pairs join each body to one before it, the rest any two.
System random_system(std::size_t n, std::size_t extra, Real softest, Real stiffest, Random& random) {
  System s;
  add_bodies(n, random, s);
  s.A_tree = s.A;
  Tree& tree = s.tree();
  tree.num_pairs = 0;
  for (std::size_t k = 0; k < n - 1 + extra; ++k) {
    const std::size_t a =
        k < n - 1 ? k + 1 : static_cast<std::size_t>(random.integer(1, static_cast<int>(n) - 1));
    const auto b = static_cast<std::uint32_t>(random.integer(0, static_cast<int>(a) - 1));
    const Real stiffness = random.log_uniform(softest, stiffest) * (k < n - 1 ? 1 : 0.1);
    TouchingPair pair;
    pair.child = static_cast<std::uint32_t>(a);
    pair.parent = b;
    pair.stiffness = stiffness;
    if (random.integer(0, 1) == 1) std::swap(pair.child, pair.parent);
    tree.pairs[tree.num_pairs++] = pair;
  }
  make_islands(s.work->touches, n, tree);
  for (std::size_t k = 0; k < tree.num_pairs; ++k) load_pair(tree.pairs[k], random, s);
  return s;
}

Vector dense(const Twists& V, std::size_t n) {
  Vector all(6 * static_cast<Eigen::Index>(n));
  for (std::size_t i = 0; i < n; ++i)
    all.segment<6>(6 * static_cast<Eigen::Index>(i)) << V[i].w.vec(), V[i].v.vec();
  return all;
}
Twists random_twists(std::size_t n, Random& random) {
  Twists V;
  for (std::size_t i = 0; i < n; ++i)
    V[i] = {.w = Column(random.vector()), .v = Column(Vec3(0.01 * random.vector()))};
  return V;
}

/// With more digits than the solve has.
Vector solution(const Matrix& A, const Vector& b) {
  using Long = long double;
  using LongMatrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;
  return LongMatrix(A.cast<Long>()).ldlt().solve(b.cast<Long>()).cast<Real>();
}

TEST(TouchingTree, HoldsTheStiffestPairsAndAllBodies) {
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    const auto bodies = static_cast<std::size_t>(random.integer(2, max_bodies));
    System s = random_system(bodies, 20, 1, 1e4, random);
    const Tree& tree = s.tree();
    ASSERT_EQ(tree.num_islands, 1u);
    ASSERT_EQ(s.island().end_body, bodies);
    std::vector<bool> seen(bodies, false);
    std::size_t roots = 0;
    for (std::size_t k = 0; k < bodies; ++k) {
      const std::uint32_t i = tree.order[k];
      EXPECT_FALSE(seen[i]);
      seen[i] = true;
      const std::uint32_t parent = tree.bodies[i].parent;
      EXPECT_TRUE(seen[parent]);  // parents first
      roots += parent == i ? 1 : 0;
      if (parent == i) continue;
      EXPECT_EQ(tree.pairs[tree.bodies[i].pair].child, i);
      EXPECT_EQ(tree.pairs[tree.bodies[i].pair].parent, parent);
    }
    EXPECT_EQ(roots, 1u);
    // a pair left out is no stiffer than any of those that join its bodies
    for (std::size_t k = 0; k < tree.num_pairs; ++k) {
      if (in_tree(tree.pairs[k], tree)) continue;
      std::vector<bool> above(bodies, false);
      std::uint32_t i = tree.pairs[k].child, j = tree.pairs[k].parent;
      for (std::uint32_t a = i;; a = tree.bodies[a].parent) {
        above[a] = true;
        if (tree.bodies[a].parent == a) break;
      }
      for (; !above[j]; j = tree.bodies[j].parent)
        EXPECT_LE(tree.pairs[k].stiffness, tree.pairs[tree.bodies[j].pair].stiffness);
      for (; i != j; i = tree.bodies[i].parent)
        EXPECT_LE(tree.pairs[k].stiffness, tree.pairs[tree.bodies[i].pair].stiffness);
    }
  }
}

/// Any pairs between any bodies: each island holds what its pairs join, and all of it.
TEST(TouchingTree, FallsIntoIslands) {
  Random random(6);
  for (int n = 0; n < 200; ++n) {
    auto tree = std::make_unique<Tree>();
    std::array<bool, max_bodies> touches;
    std::array<std::size_t, max_bodies> label;  // of what is joined, the slow way
    for (std::size_t i = 0; i < max_bodies; ++i) {
      touches[i] = random.integer(0, 4) > 0;
      label[i] = i;
    }
    tree->num_pairs = 0;
    for (int k = random.integer(0, 30); k > 0; --k) {
      const auto a = static_cast<std::uint32_t>(random.integer(1, max_bodies - 1));
      const auto b = static_cast<std::uint32_t>(random.integer(0, static_cast<int>(a) - 1));
      TouchingPair& pair = tree->pairs[tree->num_pairs++];
      pair.child = a;
      pair.parent = b;
      pair.stiffness = random.integer(0, 2);
      touches[a] = touches[b] = true;
      std::replace(label.begin(), label.end(), std::size_t(label[a]), std::size_t(label[b]));
    }
    make_islands(touches, max_bodies, *tree);
    std::size_t bodies = 0, pairs = 0;
    std::vector<std::size_t> labels;
    for (std::size_t k = 0; k < tree->num_islands; ++k) {
      const Island& island = tree->islands[k];
      EXPECT_EQ(island.first_body, bodies);
      EXPECT_EQ(island.first_pair, pairs);
      ASSERT_LT(island.first_body, island.end_body);
      const std::size_t its_label = label[tree->order[island.first_body]];
      EXPECT_EQ(std::count(labels.begin(), labels.end(), its_label), 0);
      labels.push_back(its_label);
      tree->each_body(island, [&](std::uint32_t i, const TouchingBody&) {
        EXPECT_TRUE(touches[i]);
        EXPECT_EQ(label[i], its_label);
      });
      tree->each_pair(island, [&](const TouchingPair& pair) { EXPECT_EQ(label[pair.child], its_label); });
      bodies = island.end_body;
      pairs = island.end_pair;
    }
    EXPECT_EQ(bodies, static_cast<std::size_t>(std::count(touches.begin(), touches.end(), true)));
    EXPECT_EQ(pairs, tree->num_pairs);
  }
}

TEST(TouchingTree, MultipliesLikeTheMatrix) {
  Random random(2);
  for (int n = 0; n < 100; ++n) {
    const auto bodies = static_cast<std::size_t>(random.integer(2, max_bodies));
    System s = random_system(bodies, 20, 1e-3, 1e3, random);
    const Twists V = random_twists(bodies, random);
    Twists AV;
    multiply(s.island(), s.tree(), V, AV);
    const Vector expected = s.A * dense(V, bodies);
    EXPECT_LT((dense(AV, bodies) - expected).norm(), 1e-13 * s.A.norm() * dense(V, bodies).norm());
  }
}

/// h (h k + c) of the stiffest contact against bodies of 2.5 g and more. What cancels in a stiff pair costs digits.
TEST(TouchingTree, SolvesLikeTheMatrix) {
  Random random(3);
  for (const Real stiffest : {1e-2, 1.0, 1e2, 1e4, 1e6}) {
    Real worst = 0;
    for (int n = 0; n < 40; ++n) {
      const auto bodies = static_cast<std::size_t>(random.integer(1, max_bodies));
      System s = random_system(bodies, 0, 1e-4 * stiffest, stiffest, random);
      Twists b = random_twists(bodies, random), V;
      const Vector B = dense(b, bodies);
      const Vector expected = solution(s.A_tree, B);
      eliminate(s.island(), s.tree());
      solve(s.island(), s.tree(), b, V);
      const Vector error = dense(V, bodies) - expected;
      const Real relative = std::sqrt(error.dot(s.A_tree * error) / expected.dot(B));
      worst = std::max(worst, relative);
    }
    std::printf("tree: h (h k + c) to %g kg: error of the solve %.1e in the norm of A\n", stiffest, worst);
    EXPECT_LT(worst, stiffest > 1e4 ? 3e-2 : stiffest > 1 ? 1e-5 : 1e-11) << stiffest;
  }
}

/// The speed of a body in the worst of an error, as velocity_tolerance has it.
Real worst_speed(const System& s, const Vector& error) {
  Real worst = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    const auto e = error.segment<6>(6 * static_cast<Eigen::Index>(i));
    const AnchorTwist V{.w = Column(Vec3(e.head<3>())), .v = Column(Vec3(e.tail<3>()))};
    worst = std::max(worst, std::sqrt(speed_sq(s.work->stages[i], V)));
  }
  return worst;
}

/// Impulses as of bodies that move at some m/s, and any velocities to begin with, or none.
void load_impulses(bool from_rest, Random& random, System& s) {
  Work& w = *s.work;
  w.V_0 = random_twists(s.size(), random);
  w.b = random_twists(s.size(), random);
  for (std::size_t i = 0; i < s.size(); ++i) {
    w.b[i] = {.w = w.b[i].w * (1e-3 * w.stages[i].M), .v = w.b[i].v * (100 * w.stages[i].M)};
    if (from_rest) w.V_0[i] = {.w = Column(Vec3(Vec3::Zero())), .v = Column(Vec3(Vec3::Zero()))};
  }
  eliminate(s.island(), w.tree);
}

/// Pairs beyond the tree: (28), and as near to the solution as the iteration says.
TEST(TouchingIteration, KeepsTheBalanceOfEnergy) {
  Random random(4);
  constexpr int limit = 8;
  Real balance = 0, finished = 0;
  int unfinished = 0;
  for (const std::size_t extra : {1, 3, 10, 30})
    for (int n = 0; n < 50; ++n) {
      System s =
          random_system(static_cast<std::size_t>(random.integer(3, max_bodies)), extra, 1e-2, 1, random);
      load_impulses(n % 3 == 0, random, s);
      Work& w = *s.work;
      int iterations = 0;
      const Real left = iterate(limit, s.island(), w, iterations);
      const Vector V = dense(w.V, s.size()), b = dense(w.b, s.size()), r = b - s.A * V;
      balance = std::max(balance, std::abs(V.dot(s.A * V) - V.dot(b)) / V.dot(b));
      Real most = 0;
      for (Eigen::Index i = 0; i < r.size(); i += 6) most = std::max(most, r.segment<3>(i + 3).norm());
      EXPECT_NEAR(left, most, 1e-6 * most + 1e-12);
      ASSERT_GE(iterations, 1);
      if (iterations == limit) ++unfinished;
      else finished = std::max(finished, worst_speed(s, V - solution(s.A, b)));
    }
  std::printf("iteration: V A V misses V b by %.1e of it; %d of 200 unfinished, the others off by %.1e m/s\n",
              balance, unfinished, finished);
  EXPECT_LT(balance, 1e-10);
  EXPECT_LT(finished, 10 * velocity_tolerance);
  EXPECT_LT(unfinished, 150);
}

/// The tree alone is solved at once, however large the bodies' share of the impulses differs.
TEST(TouchingIteration, TakesOneForATree) {
  Random random(5);
  Real worst = 0;
  for (int n = 0; n < 50; ++n) {
    System s = random_system(static_cast<std::size_t>(random.integer(2, max_bodies)), 0, 1e-2, 1, random);
    load_impulses(false, random, s);
    Work& w = *s.work;
    int iterations = 0;
    static_cast<void>(iterate(8, s.island(), w, iterations));
    EXPECT_EQ(iterations, 1);
    const Vector V = dense(w.V, s.size());
    worst = std::max(worst, worst_speed(s, V - solution(s.A, dense(w.b, s.size()))));
  }
  std::printf("iteration: a tree is off by %.1e m/s\n", worst);
  EXPECT_LT(worst, 1e-9);
}

}  // namespace
}  // namespace godobject::test_touching_tree
