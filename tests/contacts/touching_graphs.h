// Piles as graphs of bodies and pairs that touch, of the kinds that piles are and worse; each with random
// contacts, and its whole system as one matrix.
#pragma once

#include <cstdint>
#include <set>
#include <tuple>
#include <utility>

#include "tests/contacts/bricks.h"

namespace godobject::touching_graphs {

inline constexpr std::size_t max_bodies = 64, max_pairs = max_bodies * (max_bodies - 1) / 2;
using Tree = ContactTree<max_bodies, max_pairs>;
using Factor = ContactFactor<max_bodies>;
using Twists = std::array<AnchorTwist, max_bodies>;
using Mat6 = Eigen::Matrix<Real, 6, 6>;
using Long = long double;
using LongVector = Eigen::Matrix<Long, Eigen::Dynamic, 1>;
using LongMatrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;

/// Bodies i < j.
using Edge = std::pair<std::uint32_t, std::uint32_t>;
using Graph = std::set<Edge>;

inline Graph ring(std::uint32_t n) {
  Graph graph{{0, n - 1}};
  for (std::uint32_t i = 1; i < n; ++i) graph.insert({i - 1, i});
  return graph;
}
inline Graph grid(std::uint32_t columns, std::uint32_t rows) {
  Graph graph;
  for (std::uint32_t i = 0; i < columns * rows; ++i) {
    if (i % columns > 0) graph.insert({i - 1, i});
    if (i >= columns) graph.insert({i - columns, i});
  }
  return graph;
}
inline Graph clique(std::uint32_t n) {
  Graph graph;
  for (std::uint32_t j = 1; j < n; ++j)
    for (std::uint32_t i = 0; i < j; ++i) graph.insert({i, j});
  return graph;
}
inline std::uint32_t number_below(std::uint32_t n, Random& random) {
  return static_cast<std::uint32_t>(random.integer(0, static_cast<int>(n) - 1));
}
inline Graph random_tree(std::uint32_t n, Random& random) {
  Graph graph;
  for (std::uint32_t j = 1; j < n; ++j) graph.insert({number_below(j, random), j});
  return graph;
}
/// A tree and `extra` pairs, some of which it may have already.
inline Graph random_graph(std::uint32_t n, std::uint32_t extra, Random& random) {
  Graph graph = random_tree(n, random);
  for (std::uint32_t k = 0; k < extra; ++k) {
    const std::uint32_t j = 1 + number_below(n - 1, random);
    graph.insert({number_below(j, random), j});
  }
  return graph;
}

inline Block block(const Mat3& A) {
  return {{Column(Vec3(A.col(0))), Column(Vec3(A.col(1))), Column(Vec3(A.col(2)))}};
}
inline TwistBlock twist_block(const Mat6& A) {
  return {
      .ww = block(A.block<3, 3>(0, 0)), .wv = block(A.block<3, 3>(0, 3)), .vv = block(A.block<3, 3>(3, 3))};
}
inline Mat6 matrix(const TwistBlock& A) {
  Mat6 M;
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    M.col(c) << A.ww.col[k].vec(), Vec3::Zero();
    M.col(c + 3) << A.wv.col[k].vec(), A.vv.col[k].vec();
  }
  M.block<3, 3>(3, 0) = M.block<3, 3>(0, 3).transpose();
  return M;
}

/// Impedance of the softest contacts, of the bodies' mass.
inline constexpr Real softest = 1e-2;

/// Sum of up to eight contacts, J^T (eta_t 1 + (eta_n - eta_t) n n^T) J.
inline TwistBlock random_impedance(Real stiffest, Random& random) {
  Mat6 A = Mat6::Zero();
  for (int c = random.integer(1, 8); c > 0; --c) {
    const Vec3 r = 0.01 * random.vector(), n = random.direction();
    const Real eta_n = brick_mass * random.log_uniform(softest, stiffest),
               eta_t = eta_n * random.uniform(0, 1);
    Eigen::Matrix<Real, 3, 6> J;
    J << Vec3::UnitX().cross(r), Vec3::UnitY().cross(r), Vec3::UnitZ().cross(r), Mat3::Identity();
    A += J.transpose() * (eta_t * Mat3::Identity() + (eta_n - eta_t) * n * n.transpose()) * J;
  }
  return twist_block(0.5 * (A + A.transpose()));
}

/// Bricks that touch, in their tree and in full.
struct System {
  std::unique_ptr<Tree> tree = std::make_unique<Tree>();
  std::unique_ptr<Factor> factor = std::make_unique<Factor>();
  std::size_t size = 0;
  std::vector<Vec3> p;  // centres of mass

  /// Of the first island. again: other forces of the contacts for which it has been factored.
  bool factorize(bool again) { return godobject::factorize(tree->islands[0], again, *tree, *factor); }
};

/// touching(edge): its pair bears a force; the others are near.
template <class F>
System random_system(const Graph& graph, Real stiffest, Random& random, F touching) {
  System s;
  std::vector<Vec3>& p = s.p;
  std::array<bool, max_bodies> touches{};
  for (const Edge& edge : graph) s.size = std::max(s.size, std::size_t{edge.second} + 1);
  for (std::size_t i = 0; i < s.size; ++i) {
    p.push_back(0.02 * random.vector());
    Mat6 A = Mat6::Zero();
    A.block<3, 3>(0, 0) = random.inertia(solid_box(brick_mass, brick_half).I_B.diagonal());
    A.block<3, 3>(3, 3) = brick_mass * Mat3::Identity();
    s.tree->bodies[i].A = twist_block(A);
    touches[i] = true;
  }
  s.tree->num_pairs = 0;
  for (const Edge& edge : graph) {
    TouchingPair& pair = s.tree->pairs[s.tree->num_pairs++] = {};
    std::tie(pair.child, pair.parent) = edge;
    pair.touches = touching(edge);
    pair.stiffness = pair.touches ? random.log_uniform(1, 10) : 0;
  }
  make_islands(touches, s.size, *s.tree);
  for (std::size_t k = 0; k < s.tree->num_pairs; ++k) {
    TouchingPair& pair = s.tree->pairs[k];
    pair.d = Column(Vec3(p[pair.child] - p[pair.parent]));
    pair.A = random_impedance(stiffest, random);
  }
  return s;
}
inline System random_system(const Graph& graph, Real stiffest, Random& random) {
  return random_system(graph, stiffest, random, [](const Edge&) { return true; });
}

inline LongMatrix in_full(const System& s) {
  const auto n = 6 * static_cast<Eigen::Index>(s.size);
  LongMatrix A = LongMatrix::Zero(n, n);
  for (std::size_t i = 0; i < s.size; ++i)
    A.block<6, 6>(6 * static_cast<Eigen::Index>(i), 6 * static_cast<Eigen::Index>(i)) =
        matrix(s.tree->bodies[i].A).cast<Long>();
  for (std::size_t k = 0; k < s.tree->num_pairs; ++k) {
    const TouchingPair& pair = s.tree->pairs[k];
    if (!pair.touches) continue;
    // of the child's twist, and of the parent's: v + w x d
    const Vec3 d = pair.d.vec();
    Mat6 X = Mat6::Identity();
    X.block<3, 3>(3, 0) << 0, d.z(), -d.y(), -d.z(), 0, d.x(), d.y(), -d.x(), 0;
    Eigen::Matrix<Long, 6, 12> J;
    J << Mat6::Identity().cast<Long>(), -X.cast<Long>();
    const Eigen::Matrix<Long, 12, 12> sum = J.transpose() * matrix(pair.A).cast<Long>() * J;
    const std::array<Eigen::Index, 2> at{Eigen::Index{6} * pair.child, Eigen::Index{6} * pair.parent};
    for (const Eigen::Index i : {0, 1})
      for (const Eigen::Index j : {0, 1})
        A.block<6, 6>(at[static_cast<std::size_t>(i)], at[static_cast<std::size_t>(j)]) +=
            sum.block<6, 6>(6 * i, 6 * j);
  }
  return A;
}

inline LongVector in_full(const Twists& V, std::size_t size) {
  LongVector all(6 * static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i)
    all.segment<6>(6 * static_cast<Eigen::Index>(i)) << V[i].w.vec().cast<Long>(), V[i].v.vec().cast<Long>();
  return all;
}

}  // namespace godobject::touching_graphs
