// A block system with too few blocks: the factored matrix (27), and conjugate gradients preconditioned by it,
// against the full system.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cstdio>

#include "tests/core/system/graphs.h"

namespace godobject::test_incomplete_factor {
namespace {

using namespace block_graphs;

constexpr std::size_t most = 12, most_pairs = most * (most - 1) / 2;
using Few = BlockSystem<most, most_pairs, 4, false>;  // blocks; a clique of twelve needs 66
using Some = BlockSystem<most, most_pairs, most, false>;
using OnJoints = BlockSystem<most, most_pairs, most, true>;

/// The bodies' own part of A: kinetic energy in velocities of their centres of mass.
template <class System>
Real speed_sq(const Bodies<System>& s, std::uint32_t u, const SpatialVector& V) {
  return dot(V, s.bodies[u] * V) / body_mass;
}

/// Returns the least eigenvalue of M - A, in the coordinates of the joints, scaled to a unit diagonal of A. M
/// >= A holds for all solved V = G b.
template <class System>
Real least_beyond(Bodies<System>& s) {
  const auto n = 6 * static_cast<Eigen::Index>(s.size());
  LongMatrix G(n, n);
  for (Eigen::Index c = 0; c < n; ++c) {
    typename System::Vector b{}, V{};
    for (std::uint32_t i = 0; i < s.size(); ++i) b[i] = SpatialVector::zero();
    Vec3 e = Vec3::Zero();
    e[c % 3] = 1;
    (c % 6 < 3 ? b[static_cast<std::size_t>(c / 6)].w : b[static_cast<std::size_t>(c / 6)].v) = Column(e);
    solve(*s.system, b, V);
    G.col(c) = in_full(V, s.size());
  }
  const LongMatrix B = allowed(s);
  const LongMatrix pinv = (B.transpose() * B).ldlt().solve(B.transpose());
  const LongMatrix K = B.transpose() * in_full(s) * B;
  const LongVector root = K.diagonal().cwiseSqrt().cwiseInverse();
  const LongMatrix inverse_M =
      root.cwiseInverse().asDiagonal() * (pinv * G * pinv.transpose()) * root.cwiseInverse().asDiagonal();
  const LongMatrix M = inverse_M.ldlt().solve(LongMatrix::Identity(K.rows(), K.cols()));
  const LongMatrix off = M - root.asDiagonal() * K * root.asDiagonal();
  return static_cast<Real>(
      Eigen::SelfAdjointEigenSolver<LongMatrix>((off + off.transpose()) / 2, Eigen::EigenvaluesOnly)
          .eigenvalues()
          .minCoeff());
}

template <class System>
void expect_more_than_the_matrix(const char* name) {
  Random random(1);
  for (const Real stiffest : {1e0, 1e2, 1e4}) {
    Real least = std::numeric_limits<Real>::infinity();
    int incomplete = 0;
    for (int n = 0; n < 40; ++n) {
      const std::uint32_t size = 4 + number_below(most - 3, random);
      Bodies<System> s = random_bodies<System>(random_graph(size, 3 * size, random), stiffest, random);
      if (System::jointed) add_random_joints(random, s);
      s.factor();
      EXPECT_LE(s.system->first[size], System::room);
      incomplete += s.system->is_complete ? 0 : 1;
      least = std::min(least, least_beyond(s));
    }
    std::printf("%s, contacts to %.0e: %d of 40 incomplete, least eigenvalue of M - A %.1e\n", name, stiffest,
                incomplete, least);
    EXPECT_GT(incomplete, 20) << name;
    EXPECT_GT(least, -1e-12 * stiffest * stiffest) << name << ", contacts to " << stiffest;
  }
}

TEST(IncompleteFactor, IsTheMatrixAndSomethingPositive) {
  expect_more_than_the_matrix<Few>("few blocks");
  expect_more_than_the_matrix<Some>("some blocks");
  expect_more_than_the_matrix<OnJoints>("on joints");
}

/// Every pivot, and so every solution, is finite and positive, for any stiffness and any room.
TEST(IncompleteFactor, HasPositivePivots) {
  Random random(2);
  for (const Real stiffest : {1e7, 1e10}) {
    for (int n = 0; n < 300; ++n) {
      Bodies<OnJoints> s = random_bodies<OnJoints>(random_graph(most, 40, random), stiffest, random);
      add_random_joints(random, s);
      s.factor();
      ASSERT_FALSE(s.system->is_complete);
      for (std::uint32_t k = 0; k < most; ++k)
        for (std::size_t a = s.system->joint_of(s.system->unknown[k]) != nullptr ? 3 : 0; a < 6; ++a)
          EXPECT_GT(s.system->pivots[k].D_inverse[a][0], 0) << stiffest;
      OnJoints::Vector b = random_impulses<OnJoints>(most, random), used = b, V{};
      solve(*s.system, used, V);
      EXPECT_GT(in_full(V, most).dot(in_full(b, most)), 0) << stiffest;
    }
  }
}

/// Checks the iteration from any velocities or from rest: (28), and the reported distance from the solution.
template <class System>
void expect_balance(const char* name) {
  Random random(4);
  constexpr int limit = 30;
  Real balance = 0, finished = 0, drift = 0;
  int unfinished = 0;
  for (int n = 0; n < 200; ++n) {
    const std::uint32_t size = 4 + number_below(most - 3, random);
    Bodies<System> s = random_bodies<System>(random_graph(size, 3 * size, random), 1, random);
    if (System::jointed) add_random_joints(random, s);
    s.factor_to_iterate();
    s.system->b = random_impulses<System>(size, random);
    auto x = std::make_unique<SystemVectors<System>>();
    x->V_0 = random_impulses<System>(size, random);
    // the initial vector satisfies the joints, like twists of bodies in a stage
    const LongMatrix A = in_full(s), B = allowed(s);
    for (std::uint32_t i = 0; i < size; ++i) x->r[i] = n % 3 == 0 ? SpatialVector::zero() : x->V_0[i];
    solve(*s.system, x->r, x->V_0);
    const int iterations =
        iterate(limit, velocity_tolerance, *s.system, *x, [&](std::uint32_t u, const SpatialVector& V) {
          return speed_sq(s, u, V);
        }).iterations;
    const LongVector V = in_full(x->V, size), b = in_full(s.system->b, size);
    const LongVector exact = B * LongMatrix(B.transpose() * A * B).ldlt().solve(B.transpose() * b);
    keep_worst(balance, std::abs(V.dot(A * V) - V.dot(b)) / V.dot(b));
    keep_worst(drift, (in_full(x->r, size) - (b - A * V)).norm() / b.norm());
    if (iterations == limit) {
      ++unfinished;
      continue;
    }
    for (std::uint32_t i = 0; i < size; ++i) {
      const Eigen::Matrix<Real, 6, 1> e = (V - exact).segment<6>(Eigen::Index{6} * i).template cast<Real>();
      const SpatialVector off{.w = Column(Vec3(e.head<3>())), .v = Column(Vec3(e.tail<3>()))};
      finished = std::max(finished, std::sqrt(speed_sq(s, i, off)));
    }
  }
  std::printf(
      "%s: V A V misses V b by %.1e of it, r by %.1e of b; %d of 200 unfinished, others off by %.1e m/s\n",
      name, balance, drift, unfinished, finished);
  EXPECT_LT(balance, 1e-10) << name;
  EXPECT_LT(drift, 1e-10) << name;
  EXPECT_LT(finished, 20 * velocity_tolerance) << name;
  EXPECT_LT(unfinished, 100) << name;
}

TEST(ConjugateGradients, KeepTheBalanceOfEnergy) {
  expect_balance<Few>("few blocks");
  expect_balance<Some>("some blocks");
  expect_balance<OnJoints>("on joints");
}

/// A tree has room for its blocks, and is solved at once.
TEST(ConjugateGradients, TakeOneIterationWhereTheFactorIsComplete) {
  Random random(5);
  Real worst = 0;
  for (int n = 0; n < 50; ++n) {
    const std::uint32_t size = 2 + number_below(most - 1, random);
    Bodies<Some> s = random_bodies<Some>(random_tree(size, random), 1, random);
    s.factor_to_iterate();
    s.system->b = random_impulses<Some>(size, random);
    auto x = std::make_unique<SystemVectors<Some>>();
    x->V_0 = random_impulses<Some>(size, random);
    const int iterations =
        iterate(8, velocity_tolerance, *s.system, *x, [&](std::uint32_t u, const SpatialVector& V) {
          return speed_sq(s, u, V);
        }).iterations;
    EXPECT_EQ(iterations, 1);
    const LongMatrix A = in_full(s);
    const LongVector off = in_full(x->V, size) - A.ldlt().solve(in_full(s.system->b, size));
    keep_worst(worst, off.norm());
  }
  EXPECT_LT(worst, 1e-9);
}

}  // namespace
}  // namespace godobject::test_incomplete_factor
