// Nodes in a block system: nets of springs attached to bodies, on joints or not, against the full system.
#include <cstdio>

#include "tests/core/system/graphs.h"

namespace godobject::test_block_nodes {
namespace {

using namespace block_graphs;

constexpr std::uint32_t most_bodies = 6, most_nodes = 20;
constexpr std::size_t most_pairs = 200;
template <bool jointed, std::size_t room = 400>
using Net = BlockSystem<most_bodies, most_nodes, most_pairs, room, jointed>;

/// An impedance K for the velocity of a node against another, or against the point r of a body.
struct Spring {
  std::uint32_t of = 0, on = 0;  // unknowns
  Vec3 r = Vec3::Zero();
  Mat3 K;
  std::uint32_t entry = 0;
};

/// Positive definite.
Mat3 random_spring(Real stiffest, Random& random) {
  const Mat3 R = random.rotation().toRotationMatrix();
  const Vec3 k(random.log_uniform(softest, stiffest), random.log_uniform(softest, stiffest),
               random.log_uniform(softest, stiffest));
  return R * (body_mass * k).asDiagonal() * R.transpose();
}

template <class System>
struct Tissue {
  Bodies<System> bodies;
  std::uint32_t num_nodes = 0;
  std::vector<Real> m;
  std::vector<Spring> springs;

  Eigen::Index rows() const { return Eigen::Index{6} * bodies.size() + Eigen::Index{3} * num_nodes; }
  Eigen::Index at(std::uint32_t u) const {
    return u < most_bodies ? Eigen::Index{6} * u
                           : Eigen::Index{6} * bodies.size() + Eigen::Index{3} * (u - most_bodies);
  }

  /// Before it is factored.
  void load() {
    System& system = *bodies.system;
    system.clear();
    for (std::uint32_t i = 0; i < bodies.size(); ++i) system.add_unknown(i);
    for (std::uint32_t j = 0; j < num_nodes; ++j) system.add_unknown(most_bodies + j);
    if constexpr (System::jointed)
      for (std::uint32_t i = 0; i < bodies.size(); ++i) bodies.hang(i);
    for (Between& b : bodies.between) b.entry = system.couple(b.parent, b.child);
    for (Spring& s : springs) s.entry = system.couple(s.on, s.of);
    order(system);
    system.begin_loading();
    for (std::uint32_t i = 0; i < bodies.size(); ++i) system.set(i, bodies.bodies[i], SpatialVector::zero());
    for (std::uint32_t j = 0; j < num_nodes; ++j) {
      SymmetricSpatialMatrix A{.ww = Block::zero(), .wv = Block::zero(), .vv = Block::identity() * m[j]};
      system.set(most_bodies + j, A, SpatialVector::zero());
    }
    for (const Between& b : bodies.between) system.add_between(b.entry, b.A, Column(b.d));
    for (const Spring& s : springs)
      system.add_between(s.entry, {.ww = Block::zero(), .wv = Block::zero(), .vv = block(s.K)}, Column(s.r));
  }

  LongMatrix in_full() const {
    LongMatrix A = LongMatrix::Zero(rows(), rows());
    const Eigen::Index n = Eigen::Index{6} * bodies.size();
    A.topLeftCorner(n, n) = block_graphs::in_full(bodies);
    for (std::uint32_t j = 0; j < num_nodes; ++j)
      for (Eigen::Index c = 0; c < 3; ++c) A(at(most_bodies + j) + c, at(most_bodies + j) + c) += m[j];
    for (const Spring& s : springs) {
      LongMatrix J = LongMatrix::Zero(3, rows());
      J.template middleCols<3>(at(s.of)).setIdentity();
      if (s.on < most_bodies)
        J.template middleCols<6>(at(s.on)) = -shift(s.r).template bottomRows<3>().template cast<Long>();
      else J.template middleCols<3>(at(s.on)) = -LongMatrix::Identity(3, 3);
      A += J.transpose() * s.K.template cast<Long>() * J;
    }
    return A;
  }
  /// Returns the motion that joints allow: bodies first, then all nodes.
  LongMatrix allowed() const {
    const LongMatrix B = block_graphs::allowed(bodies);
    LongMatrix all = LongMatrix::Zero(rows(), B.cols() + Eigen::Index{3} * num_nodes);
    all.topLeftCorner(B.rows(), B.cols()) = B;
    all.bottomRightCorner(Eigen::Index{3} * num_nodes, Eigen::Index{3} * num_nodes).setIdentity();
    return all;
  }
  LongVector in_full(const typename System::Vector& V) const {
    LongVector all(rows());
    for (std::uint32_t i = 0; i < bodies.size(); ++i) all.segment<6>(at(i)) = longs(V[i]);
    for (std::uint32_t j = 0; j < num_nodes; ++j)
      all.segment<3>(at(most_bodies + j)) = V[most_bodies + j].v.vec().template cast<Long>();
    return all;
  }
  typename System::Vector random_impulses(Random& random) const {
    auto b = block_graphs::random_impulses<System>(bodies.size(), random);
    for (std::uint32_t j = 0; j < num_nodes; ++j)
      b[most_bodies + j] = {.w = Column(Pack(0)), .v = Column(Vec3(0.1 * body_mass * random.vector()))};
    return b;
  }
};

/// Nodes on springs to some before them, and a fifth of them attached to a body each.
template <class System>
Tissue<System> random_tissue(Real stiffest, Random& random) {
  Tissue<System> t;
  const std::uint32_t bodies = 2 + number_below(most_bodies - 1, random);
  t.bodies = random_bodies<System>(random_graph(bodies, bodies, random), stiffest, random);
  if (System::jointed) add_random_joints(random, t.bodies);
  t.num_nodes = 1 + number_below(most_nodes, random);
  for (std::uint32_t j = 0; j < t.num_nodes; ++j) {
    const std::uint32_t u = most_bodies + j;
    t.m.push_back(body_mass * random.log_uniform(1e-3, 1));
    for (int k = random.integer(j > 0 ? 1 : 0, 3); k > 0 && j > 0; --k)
      t.springs.push_back(
          {.of = u, .on = most_bodies + number_below(j, random), .K = random_spring(stiffest, random)});
    if (j % 5 == 0)
      t.springs.push_back({.of = u,
                           .on = number_below(bodies, random),
                           .r = 0.02 * random.vector(),
                           .K = random_spring(stiffest, random)});
  }
  return t;
}

template <class System>
void expect_solved(const char* name) {
  Random random(1);
  for (const Real stiffest : {1e2, 1e4, 1e7, 1e10}) {
    Real worst = 0, product = 0;
    for (int n = 0; n < 60; ++n) {
      Tissue<System> t = random_tissue<System>(stiffest, random);
      t.load();
      ASSERT_TRUE(t.bodies.system->is_complete);
      typename System::Vector b = t.random_impulses(random), V = t.random_impulses(random), AV{};
      t.bodies.system->multiply(V, AV);
      keep_worst(product, (t.in_full(AV) - t.in_full() * t.in_full(V)).norm() /
                              (t.in_full().norm() * t.in_full(V).norm()));
      factorize(*t.bodies.system);
      const LongMatrix A = t.in_full(), B = t.allowed();
      const LongVector exact =
          B * LongMatrix(B.transpose() * A * B).ldlt().solve(B.transpose() * t.in_full(b));
      solve(*t.bodies.system, b, V);
      const LongVector off = t.in_full(V) - exact;
      keep_worst(worst, std::sqrt(off.dot(A * off) / exact.dot(A * exact)));
    }
    std::printf("%s to %.0e: V off by %.1e, A V by %.1e\n", name, stiffest, worst, product);
    EXPECT_LT(worst, 1e3 * std::numeric_limits<Real>::epsilon() * std::max(stiffest, Real(1e3))) << name;
    EXPECT_LT(product, 1e-15) << name;
  }
}

TEST(BlockNodes, SolveWithBodies) {
  expect_solved<Net<false>>("nodes and bodies");
  expect_solved<Net<true>>("nodes and bodies on joints");
}

/// With few blocks the solution is that of more than A: it does work, and less than the exact one would.
TEST(BlockNodes, DoNoMoreWorkWhereBlocksAreLeftOut) {
  Random random(2);
  int incomplete = 0;
  for (const Real stiffest : {1e0, 1e4, 1e8}) {
    for (int n = 0; n < 60; ++n) {
      Tissue<Net<true, 26>> t = random_tissue<Net<true, 26>>(stiffest, random);
      t.load();
      factorize(*t.bodies.system);
      incomplete += t.bodies.system->is_complete ? 0 : 1;
      auto b = t.random_impulses(random), used = b;
      decltype(used) V{};
      solve(*t.bodies.system, used, V);
      const LongVector all = t.in_full(V);
      const Long work = all.dot(t.in_full(b));
      EXPECT_GT(work, 0);
      EXPECT_LE(all.dot(t.in_full() * all), work * (1 + 1e-15 * stiffest + 1e-12)) << stiffest;
    }
  }
  EXPECT_GT(incomplete, 30);
}

}  // namespace
}  // namespace godobject::test_block_nodes
