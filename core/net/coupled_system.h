// Bodies and nodes of nets as one system A V = b, for conjugate gradients.
//
// The unknown of a node is its velocity relative to its carrier, u_n = v_n - (v_b + w_b x r); relative to the
// world for nodes of the scene. Unknowns of bodies are then motions of bodies with their carried nodes. Their
// matrix E of the whole A is known exactly, joints included, and with
//
//   (44)  M^-1 = diag(E^-1, (43)^-1)
//
// as preconditioner, a net and its carrier fall, rotate and collide as one from the first iteration on. The
// matrix of the nodes is not stored: anchors, springs and contacts multiply by their few numbers.
//
// At the end of the iteration, V is corrected for any residual of the deformation. The energy balance (28)
// and the momenta of each body with its net then hold:
//
//   (45)  V+ = s V + (c, 0)  with  V+^T r = 0,  r of bodies = 0
//
// Nets that touch the world alone are corrected as bodies are, in their translation (standing.h).
#pragma once

#include "core/net/drifting.h"
#include "core/net/standing.h"
#include "core/system/conjugate_gradients.h"

namespace godobject {

/// Vector of the coupled system: twists or impulses of bodies, velocities or impulses of nodes.
template <class OfBodies, std::size_t max_nodes>
struct CoupledVector {
  OfBodies bodies;
  std::array<Column, max_nodes> nodes;

  SpatialVector& operator[](std::size_t u) noexcept { return bodies[u]; }
  const SpatialVector& operator[](std::size_t u) const noexcept { return bodies[u]; }
  Column& operator[](NetNodeNumber u) noexcept { return nodes[u.n]; }
  const Column& operator[](NetNodeNumber u) const noexcept { return nodes[u.n]; }
};
/// Calls f(run) for the nodes carried by bodies.
template <class Net, std::size_t N, class F>
void each_carried(const NetStage<Net, N>& w, F f) noexcept {
  for (std::size_t k = 0; k < w.num_runs; ++k)
    if (w.runs[k].body != world) f(w.runs[k]);
}

/// Returns the inertia of the nodes of a run about the centre of mass of their carrier.
template <class Net, std::size_t N>
SymmetricSpatialMatrix inertia_of(const NetStage<Net, N>& w, const NetRun& run) noexcept {
  Pack m_sum = 0;
  Vector3<Pack> mr_sum = Vector3<Pack>::Constant(Pack(0)), squares = mr_sum, products = mr_sum;  // yz, xz, xy
  for (std::uint32_t n = run.first; n < run.end; n += 4) {
    const auto at = [&](std::uint32_t j) noexcept { return std::min(n + j, run.end - 1); };
    const auto m_of = [&](std::uint32_t j) noexcept { return n + j < run.end ? w.m[n + j] : 0; };
    const Pack m(m_of(0), m_of(1), m_of(2), m_of(3));
    const Vector3<Pack> r = in_lanes(w.r[at(0)], w.r[at(1)], w.r[at(2)], w.r[at(3)]);
    const Pack mx = m * r[0], my = m * r[1], mz = m * r[2];
    m_sum += m;
    mr_sum[0] += mx;
    mr_sum[1] += my;
    mr_sum[2] += mz;
    squares[0] += mx * r[0];
    squares[1] += my * r[1];
    squares[2] += mz * r[2];
    products[0] += my * r[2];
    products[1] += mx * r[2];
    products[2] += mx * r[1];
  }
  const auto total_of = [](const Vector3<Pack>& sum) noexcept -> Vec3 {
    return {total(sum[0]), total(sum[1]), total(sum[2])};
  };
  const Vec3 xx = total_of(squares), yz = total_of(products), mr = total_of(mr_sum);
  Mat3 I;
  I << xx.y() + xx.z(), -yz.z(), -yz.y(), -yz.z(), xx.x() + xx.z(), -yz.x(), -yz.y(), -yz.x(),
      xx.x() + xx.y();
  return {
      .ww = block_of(I), .wv = cross(Column(mr), Block::identity()), .vv = Block::identity() * total(m_sum)};
}

/// System of the bodies `bodies` and the nets that they carry, touch, or are attached to.
template <class OfBodies, class Stage>
struct CoupledSystem {
  using Vector = CoupledVector<typename OfBodies::Vector, Stage::max_nodes>;
  static constexpr bool is_coupled = true;
  OfBodies& bodies;
  Stage& net;
  Vector& b;

  /// Calls f(number) for all unknowns.
  template <class F>
  void each(F f) const noexcept {
    bodies.each(f);
    for (std::uint32_t n = 0; n < net.num_nodes; ++n) f(NetNodeNumber{n});
  }
  const BlockJoint* joint_of(std::uint32_t u) const noexcept { return bodies.joint_of(u); }
  static const BlockJoint* joint_of(NetNodeNumber) noexcept { return nullptr; }

  /// Computes AV = A V.
  void multiply(const Vector& V, Vector& AV) const noexcept {
    bodies.multiply(V.bodies, AV.bodies);
    auto& v = net.carrier_relative_v;  // storage for the velocities of nodes relative to the world
    for (std::size_t k = 0; k < net.num_runs; ++k) {
      const NetRun& run = net.runs[k];
      if (run.body == world) {
        for (std::uint32_t n = run.first; n < run.end; ++n) {
          v[n] = V.nodes[n];
          AV.nodes[n] = v[n] * (net.m[n] + net.kappa[n]);
        }
        continue;
      }
      const SpatialVector V_b = V.bodies[run.body];
      for (std::uint32_t n = run.first; n < run.end; ++n) {
        const Column u = V.nodes[n];
        v[n] = u + shifted(V_b, net.r[n]).v;
        AV.nodes[n] = v[n] * net.m[n] + u * net.kappa[n];
      }
    }
    add_springs_product(net, v, AV.nodes);
    add_settling_product(net, v, AV.nodes);
    add_contacts_product(net, v, V, AV);
    // impulses on nodes also act on their carriers, except those of anchors
    each_carried(net, [&](const NetRun& run) noexcept {
      SpatialVector sum = SpatialVector::zero();
      for (std::uint32_t n = run.first; n < run.end; ++n) {
        const Column J = AV.nodes[n] - V.nodes[n] * net.kappa[n];
        sum.w += cross(net.r[n], J);
        sum.v += J;
      }
      AV.bodies[run.body] = AV.bodies[run.body] + sum;
    });
  }
};

/// Applies the preconditioner (44): z = M^-1 r. r is overwritten.
template <class OfBodies, class Stage>
void solve(const CoupledSystem<OfBodies, Stage>& system, typename CoupledSystem<OfBodies, Stage>::Vector& r,
           typename CoupledSystem<OfBodies, Stage>::Vector& z) noexcept {
  solve(system.bodies, r.bodies, z.bodies);
  solve_nodes(system.net, r.nodes, z.nodes);
}

/// Corrects V by (45) in the translation of drifting nets: c of each is theirs as a whole. The part of r that
/// moves them as a whole becomes zero. Leaves the drift of A V, their c_1.
template <class OfBodies, class Stage, class Vectors>
void keep_drifts(const CoupledSystem<OfBodies, Stage>& system, Vectors& x) noexcept {
  auto& net = system.net;
  set_drifts(net, net.faces.active_group, [&](std::uint32_t n) noexcept { return x.r.nodes[n]; });
  each_drifting(net, net.faces.active_group, [&](std::uint32_t n, std::uint32_t) noexcept {
    x.V.nodes[n] += net.faces.drift[n];
    x.r.nodes[n] -= net.faces.drift[n] * net.m[n];
  });
  set_drifts(net, net.faces.active_group,
             [&](std::uint32_t n) noexcept { return system.b.nodes[n] - x.r.nodes[n]; });
}

/// Corrects V, A V = b - r, by (45). The r of nodes remains that of the iteration; see compute_residual().
template <class OfBodies, class Stage, class Vectors>
void keep_balance(const CoupledSystem<OfBodies, Stage>& system, Vectors& x) noexcept {
  auto &delta = system.net.delta, &c_1 = system.net.c_1;
  const auto& b = system.b;
  // delta = E^-1 r,  c_1 = E^-1 A V  of bodies
  system.bodies.each([&](std::uint32_t u) noexcept {
    x.Ap[u] = x.r[u];
    x.p[u] = b[u] - x.r[u];
  });
  solve(system.bodies, x.Ap.bodies, delta);
  SpatialSum V_r, V_b, along_delta, along_c_1;
  system.bodies.each([&](std::uint32_t u) noexcept {
    along_delta.add(x.p[u], delta[u]);
    x.Ap[u] = x.p[u];
  });
  solve(system.bodies, x.Ap.bodies, c_1);
  system.bodies.each([&](std::uint32_t u) noexcept { along_c_1.add(x.p[u], c_1[u]); });
  // correction of nets in free flight, and of standing ones
  auto& net = system.net;
  if constexpr (Stage::has_faces) {
    keep_drifts(system, x);
    each_drifting(net, net.faces.active_group, [&](std::uint32_t n, std::uint32_t) noexcept {
      along_c_1.add(b.nodes[n] - x.r.nodes[n], net.faces.drift[n]);
    });
  }
  each_corrected(net, [&](const NodeRow& nodes, RowStage& of) noexcept {
    const auto A_V = [&](std::uint32_t n) noexcept { return b.nodes[n] - x.r.nodes[n]; };
    const auto motion = [&](auto J) noexcept {
      return of.stands ? common_motion(nodes, of, J) : rigid_motion(nodes, of.masses, net.p, J);
    };
    of.delta = motion([&](std::uint32_t n) noexcept { return x.r.nodes[n]; });
    of.c_1 = motion(A_V);
    for (std::uint32_t n = nodes.first; n < nodes.end; ++n) {
      const Column r = net.p[n] - of.masses.c;
      along_delta.add(A_V(n), shifted(of.delta, r).v);
      along_c_1.add(A_V(n), shifted(of.c_1, r).v);
    }
  });
  system.each([&](auto u) noexcept {
    V_r.add(x.V[u], x.r[u]);
    V_b.add(x.V[u], b[u]);
  });
  // s - 1 = (V^T r - (A V)^T delta) / (V^T A V - (A V)^T c_1),  c = delta - (s - 1) c_1
  const Real V_A_V = V_b - V_r, deforming = V_A_V - along_c_1;
  const Real s_1 = deforming > rounding_share * V_A_V ? (V_r - along_delta) / deforming : 0;
  system.each([&](auto u) noexcept { x.V[u] = x.V[u] * (1 + s_1); });
  system.bodies.each([&](std::uint32_t u) noexcept {
    x.V[u] = x.V[u] + delta[u] - c_1[u] * s_1;
    x.r[u] = SpatialVector::zero();
  });
  if constexpr (Stage::has_faces)
    each_drifting(net, net.faces.active_group,
                  [&](std::uint32_t n, std::uint32_t) noexcept { x.V.nodes[n] -= net.faces.drift[n] * s_1; });
  each_corrected(net, [&](const NodeRow& nodes, const RowStage& of) noexcept {
    const SpatialVector c = of.delta - of.c_1 * s_1;
    for (std::uint32_t n = nodes.first; n < nodes.end; ++n)
      x.V.nodes[n] += shifted(c, net.p[n] - of.masses.c).v;
  });
}

/// Computes r = b - A V.
template <class System, class Vectors>
void compute_residual(const System& system, Vectors& x) noexcept {
  system.multiply(x.V, x.Ap);
  system.each([&](auto u) noexcept { x.r[u] = system.b[u] - x.Ap[u]; });
}

}  // namespace godobject
