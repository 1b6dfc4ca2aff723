// Floating nets: no anchor has stiffness, so no position of the net is preferred. The dampers of its anchors
// damp its deformation only, not its rigid motion.
//
//   (57)  impulse -h g (v - V - W x r) on a node at r from c;   c, V, W:  sum h g r = 0,
//         G V = sum h g v,  J W = sum h g r x v,  G = sum h g,  J = sum h g (r^2 1 - r r^T)
//
// V and W: rigid motion that fits the node velocities best, by least squares with weights g. The impulses
// therefore have no resultant force or torque, and dissipate the energy of any other motion. In the system
// they are added to the springs. With masses as weights, the same sums are the rigid motion of a flying net
// for (45) and (48).
#pragma once

#include <limits>

#include "core/net/springs.h"

namespace godobject {

/// Sums of nodes weighted by weight(node), about their centre.
template <class Positions, class Weight>
RigidFit rigid_fit(const NodeRow& nodes, const Positions& p, Weight weight) noexcept {
  RigidFit fit;
  Column wp(Pack(0));
  for (std::uint32_t n = nodes.first; n < nodes.end; ++n) {
    fit.size += weight(n);
    wp += p[n] * weight(n);
  }
  fit.c = wp * (1 / fit.size);
  Mat3 J = Mat3::Zero();
  for (std::uint32_t n = nodes.first; n < nodes.end; ++n) {
    const Vec3 r = (p[n] - fit.c).vec();
    J += weight(n) * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  // collinear nodes have no moment about their line: any small value makes J regular and has no effect
  const Real trace = J.trace();
  if (!(J.determinant() > std::numeric_limits<Real>::epsilon() * trace * trace * trace))
    J += (std::numeric_limits<Real>::epsilon() * trace + std::numeric_limits<Real>::min()) * Mat3::Identity();
  fit.J_inverse = block_of(Mat3(J.inverse()));
  return fit;
}

/// Returns the twist about c that impulses J(node) give to the weighted nodes as one rigid body.
template <class Positions, class Impulse>
SpatialVector rigid_motion(const NodeRow& nodes, const RigidFit& fit, const Positions& p,
                           Impulse impulse) noexcept {
  SpatialVector sum = SpatialVector::zero();
  for (std::uint32_t n = nodes.first; n < nodes.end; ++n)
    sum = sum + moved_wrench({.w = Column(Pack(0)), .v = impulse(n)}, p[n] - fit.c);
  return {.w = fit.J_inverse * sum.w, .v = sum.v * (1 / fit.size)};
}

/// Calls f(net, data of it) for every floating net.
template <class Stage, class F>
void each_floating(Stage& w, F f) noexcept {
  for (std::size_t k = 0; k < w.par->num_rows; ++k)
    if (w.rows[k].floats) f(w.par->rows[k], w.rows[k]);
}

/// True if no anchor of the row has stiffness and at least one has damping.
template <class NetParams>
bool floats(const NetParams& par, const NodeRow& row) noexcept {
  bool damps = false;
  for (std::uint32_t n = row.first; n < row.end; ++n) {
    if (par.nodes[n].k > 0) return false;
    damps = damps || par.nodes[n].g > 0;
  }
  return damps;
}

/// True if the row has no carrier and no anchor with stiffness.
template <class NetParams>
bool is_free(const NetParams& par, const NodeRow& row) noexcept {
  for (std::uint32_t n = row.first; n < row.end; ++n)
    if (par.nodes[n].body != world || par.nodes[n].k > 0) return false;
  return true;
}

/// Begins the dampers of floating nets. Call it after begin_anchors(), which treats these dampers as anchors.
template <class Net, std::size_t N>
void begin_preconditioner(const typename Net::Params& par, Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t k = 0; k < par.num_rows; ++k) {
    w.rows[k].floats = floats(par, par.rows[k]);
    w.rows[k].is_free = is_free(par, par.rows[k]);
  }
  each_floating(w, [&](const NodeRow& nodes, RowStage& of) noexcept {
    for (std::uint32_t n = nodes.first; n < nodes.end; ++n) {
      w.settling[n] = h * par.nodes[n].g;
      w.kappa[n] = 0;
    }
    of.dampers = rigid_fit(nodes, w.p, [&](std::uint32_t n) noexcept { return w.settling[n]; });
    of.masses = rigid_fit(nodes, w.p, [&](std::uint32_t n) noexcept { return w.m[n]; });
  });
}

/// Computes y += A_dampers v (57).
template <class Net, std::size_t N, class Vector>
void add_settling_product(const NetStage<Net, N>& w, const Vector& v, Vector& y) noexcept {
  each_floating(w, [&](const NodeRow& nodes, const RowStage& of) noexcept {
    const SpatialVector V =
        rigid_motion(nodes, of.dampers, w.p, [&](std::uint32_t n) noexcept { return v[n] * w.settling[n]; });
    for (std::uint32_t n = nodes.first; n < nodes.end; ++n)
      y[n] += (v[n] - shifted(V, w.p[n] - of.dampers.c).v) * w.settling[n];
  });
}

/// Finds the floating nets of the world that touch nothing and are attached to nothing: (45) and (48) keep
/// their momenta.
template <class Net, std::size_t N>
void find_flying(NetStage<Net, N>& w) noexcept {
  each_floating(w, [&](const NodeRow& nodes, RowStage& of) noexcept {
    of.flies = true;
    for (std::size_t k = 0; k < w.num_runs; ++k)
      if (w.runs[k].body != world && nodes.first < w.runs[k].end && w.runs[k].first < nodes.end)
        of.flies = false;
    for (std::size_t c = 0; c < w.num_attachments; ++c)
      if (nodes.holds(w.contacts[c].node)) of.flies = false;
    for (std::size_t k = 0; k < w.near.size; ++k)
      if (nodes.holds(w.near.list[k].a)) of.flies = false;
  });
}

}  // namespace godobject
