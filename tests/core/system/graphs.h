// Systems of bodies, nodes and joints as graphs, of the kinds in piles and harder ones. Each with random
// impedances, and as one full matrix.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdint>
#include <limits>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "core/joint/edges.h"
#include "core/system/conjugate_gradients.h"
#include "tests/core/one_body.h"

namespace godobject::block_graphs {

using Mat6 = Eigen::Matrix<Real, 6, 6>;
using Long = long double;
using LongVector = Eigen::Matrix<Long, Eigen::Dynamic, 1>;
using LongMatrix = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;

/// Unknowns i < j.
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
inline SymmetricSpatialMatrix spatial(const Mat6& A) {
  return {
      .ww = block(A.block<3, 3>(0, 0)), .wv = block(A.block<3, 3>(0, 3)), .vv = block(A.block<3, 3>(3, 3))};
}
inline Mat6 matrix(const SymmetricSpatialMatrix& A) {
  Mat6 M;
  for (int c = 0; c < 3; ++c) {
    const auto k = static_cast<std::size_t>(c);
    M.col(c) << A.ww.col[k].vec(), Vec3::Zero();
    M.col(c + 3) << A.wv.col[k].vec(), A.vv.col[k].vec();
  }
  M.block<3, 3>(3, 0) = M.block<3, 3>(0, 3).transpose();
  return M;
}
inline Eigen::Matrix<Long, 6, 1> longs(const SpatialVector& V) {
  Eigen::Matrix<Long, 6, 1> all;
  all << V.w.vec().cast<Long>(), V.v.vec().cast<Long>();
  return all;
}

inline constexpr Real body_mass = 2.5e-3;  // kg
/// Impedance of the softest contacts, of the bodies' mass.
inline constexpr Real softest = 1e-2;

/// Sum of up to eight contacts, J^T (eta_t 1 + (eta_n - eta_t) n n^T) J.
inline SymmetricSpatialMatrix random_impedance(Real stiffest, Random& random) {
  Mat6 A = Mat6::Zero();
  for (int c = random.integer(1, 8); c > 0; --c) {
    const Vec3 r = 0.01 * random.vector(), n = random.direction();
    const Real eta_n = body_mass * random.log_uniform(softest, stiffest),
               eta_t = eta_n * random.uniform(0, 1);
    Eigen::Matrix<Real, 3, 6> J;
    J << Vec3::UnitX().cross(r), Vec3::UnitY().cross(r), Vec3::UnitZ().cross(r), Mat3::Identity();
    A += J.transpose() * (eta_t * Mat3::Identity() + (eta_n - eta_t) * n * n.transpose()) * J;
  }
  return spatial(0.5 * (A + A.transpose()));
}

/// X of a rigid motion d away.
inline Mat6 shift(const Vec3& d) {
  Mat6 X = Mat6::Identity();
  X.block<3, 3>(3, 0) << 0, d.z(), -d.y(), -d.z(), 0, d.x(), d.y(), -d.x(), 0;
  return X;
}

/// An impedance between two bodies, or nothing while it does not act.
struct Between {
  std::uint32_t child = 0, parent = 0, entry = no_slot;
  bool acts = true;
  Vec3 d;
  SymmetricSpatialMatrix A;
};

/// Bodies with impedances between them, in a block system.
template <class System_>
struct Bodies {
  using System = System_;
  std::unique_ptr<System> system = std::make_unique<System>();
  std::vector<Vec3> p;  // centres of mass
  std::vector<SymmetricSpatialMatrix> bodies;
  std::vector<Between> between;
  std::vector<JointEdge> joints;  // of all bodies, or none

  std::uint32_t size() const { return static_cast<std::uint32_t>(p.size()); }
  /// Declares the couplings and orders the unknowns. is_in(unknown): true for included bodies.
  template <class F>
  void begin(F is_in) {
    system->clear();
    for (std::uint32_t i = 0; i < size(); ++i)
      if (is_in(i)) system->add_unknown(i);
    if constexpr (System::jointed)
      for (std::uint32_t i = 0; i < size(); ++i) hang(i);
    for (Between& b : between) b.entry = is_in(b.child) ? system->couple(b.parent, b.child) : no_slot;
    order(*system);
  }
  void begin() {
    begin([](std::uint32_t) { return true; });
  }
  void hang(std::uint32_t i) {
    const JointEdge& edge = joints[i];
    BlockJoint& joint = system->joints[i];
    joint.is_free = edge.kind == JointKind::free;
    joint.num_axes = edge.num_axes;
    joint.parent = edge.on_body() ? static_cast<std::uint32_t>(edge.parent) : BlockJoint::on_world;
    if (edge.on_body()) joint.d = Column(Vec3(p[i] - p[edge.parent]));
    for (int a = 0; a < edge.num_axes; ++a)
      joint.s[static_cast<std::size_t>(a)] = axis_twist(edge, a, Column(p[i]));
  }
  void load() {
    system->begin_loading();
    system->each([&](std::uint32_t u) { system->set(u, bodies[u], SpatialVector::zero()); });
    for (const Between& b : between)
      if (b.acts && b.entry != no_slot) system->add_between(b.entry, b.A, Column(b.d));
  }
  void factor() {
    begin();
    load();
    factorize(*system);
  }
  /// Factors for conjugate gradients, which keep the loaded system, with or without room.
  void factor_to_iterate() {
    begin();
    system->is_complete = false;
    load();
    factorize(*system);
  }
};

/// acts(edge): its impedance does; it is coupled anyway.
template <class System, class F>
Bodies<System> random_bodies(const Graph& graph, Real stiffest, Random& random, F acts) {
  Bodies<System> s;
  std::size_t size = 0;
  for (const Edge& edge : graph) size = std::max(size, std::size_t{edge.second} + 1);
  for (std::size_t i = 0; i < size; ++i) {
    s.p.push_back(0.02 * random.vector());
    Mat6 A = Mat6::Zero();
    A.block<3, 3>(0, 0) = random.inertia(body_mass * Vec3(3e-5, 1e-4, 1.1e-4));
    A.block<3, 3>(3, 3) = body_mass * Mat3::Identity();
    s.bodies.push_back(spatial(A));
  }
  for (const auto& [i, j] : graph) {
    Between b;
    b.child = j;
    b.parent = i;
    b.acts = acts(Edge{i, j});
    b.A = random_impedance(stiffest, random);
    if (random.integer(0, 1) == 1) std::swap(b.child, b.parent);
    b.d = s.p[b.child] - s.p[b.parent];
    s.between.push_back(b);
  }
  return s;
}
template <class System>
Bodies<System> random_bodies(const Graph& graph, Real stiffest, Random& random) {
  return random_bodies<System>(graph, stiffest, random, [](const Edge&) { return true; });
}

/// Turns and slides about a random anchor.
inline JointEdge random_joint(const Vec3& p, Random& random) {
  JointEdge edge;
  edge.kind = JointKind::hinge;  // any: its axes define the allowed motion
  edge.a_W = Column(Vec3(p + 0.01 * random.vector()));
  edge.num_axes = random.integer(0, 3);
  edge.num_turns = random.integer(0, edge.num_axes);
  const Mat3 R = random.rotation().toRotationMatrix();
  for (int k = 0; k < 3; ++k) edge.s[static_cast<std::size_t>(k)] = Column(Vec3(R.col(k)));
  return edge;
}
/// Makes about half of the bodies children of one before them, or of the world.
template <class System>
void add_random_joints(Random& random, Bodies<System>& s) {
  for (std::uint32_t i = 0; i < s.size(); ++i) {
    s.joints.emplace_back();
    if (random.integer(0, 1) == 0) continue;
    s.joints[i] = random_joint(s.p[i], random);
    s.joints[i].parent = i > 0 ? number_below(i, random) : world;
  }
}

/// A of the bodies and all that acts between them.
template <class System>
LongMatrix in_full(const Bodies<System>& s) {
  const auto n = 6 * static_cast<Eigen::Index>(s.size());
  LongMatrix A = LongMatrix::Zero(n, n);
  for (std::uint32_t i = 0; i < s.size(); ++i)
    A.block<6, 6>(6 * static_cast<Eigen::Index>(i), 6 * static_cast<Eigen::Index>(i)) =
        matrix(s.bodies[i]).template cast<Long>();
  for (const Between& b : s.between) {
    if (!b.acts) continue;
    LongMatrix J = LongMatrix::Zero(6, n);
    J.middleCols<6>(Eigen::Index{6} * b.child).setIdentity();
    J.middleCols<6>(Eigen::Index{6} * b.parent) = -shift(b.d).cast<Long>();
    A += J.transpose() * matrix(b.A).cast<Long>() * J;
  }
  return A;
}

/// Returns the motion that the joints allow: V = B (twists of root bodies, rates of joints).
template <class System>
LongMatrix allowed(const Bodies<System>& s) {
  const auto size = static_cast<Eigen::Index>(s.size());
  LongMatrix B = LongMatrix::Zero(6 * size, 6 * size);
  Eigen::Index m = 0;
  for (std::uint32_t i = 0; i < s.size(); ++i) {
    const Eigen::Index at = Eigen::Index{6} * i;
    if (s.joints.empty() || s.joints[i].kind == JointKind::free) {
      for (int k = 0; k < 6; ++k) B(at + k, m++) = 1;
      continue;
    }
    const JointEdge& edge = s.joints[i];
    if (edge.on_body())
      B.middleRows(at, 6) = shift(s.p[i] - s.p[edge.parent]).template cast<Long>() *
                            B.middleRows(6 * static_cast<Eigen::Index>(edge.parent), 6);
    for (int k = 0; k < edge.num_axes; ++k)
      B.col(m++).template segment<6>(at) += longs(axis_twist(edge, k, Column(s.p[i])));
  }
  B.conservativeResize(Eigen::NoChange, m);
  return B;
}

template <class Vector>
LongVector in_full(const Vector& V, std::uint32_t size) {
  LongVector all(6 * static_cast<Eigen::Index>(size));
  for (std::uint32_t i = 0; i < size; ++i) all.segment<6>(Eigen::Index{6} * i) = longs(V[i]);
  return all;
}

/// Impulses as of bodies that move at some m/s.
template <class System>
typename System::Vector random_impulses(std::uint32_t size, Random& random) {
  typename System::Vector b{};
  for (std::uint32_t i = 0; i < size; ++i)
    b[i] = {.w = Column(Vec3(0.01 * body_mass * random.vector())),
            .v = Column(Vec3(body_mass * random.vector()))};
  return b;
}

inline void keep_worst(Real& worst, Long miss) {
  worst =
      std::isfinite(miss) ? std::max(worst, static_cast<Real>(miss)) : std::numeric_limits<Real>::infinity();
}

}  // namespace godobject::block_graphs
