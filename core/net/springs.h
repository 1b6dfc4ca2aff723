// Anchors and springs of nets in a stage: impedances and impulses, linear from where the stage is predicted to end.
//
//   (41)  spring:  impulse J - K x' on j,  K = a 1 + q q^T,  a = h^2 k max(1 - l_0 / l, 0),  q q^T = (h^2 k + h g - a) u u^T
//   (42)  anchor:  impulse J - kappa (v_n - v_b - w_b x r),  kappa = h (h k + g)
//
// Both as (37). A spring is four numbers in the system: its product takes no matrix. Where it is shorter than l_0, what it
// loses across itself is left out, since the system is to be positive definite; where it is longer, nothing is. The lever
// of an anchor is where its node is: so it does nothing where body and node turn as one.
#pragma once

#include "core/joint/tree.h"
#include "core/net/scratch.h"

namespace godobject {

/// (x, y, z) and what is given for the fourth place.
inline Pack with_fourth(const Vec3& a, Real fourth) noexcept { return {a.x(), a.y(), a.z(), fourth}; }

/// K d of a spring.
inline Column spring_product(const Pack& q_a, const Column& d) noexcept {
  const Pack m = q_a * d.p;
  const Pack q_d = m + rotated(m) + shuffled<2, 0, 1, 3>(m, m);
  return Column(d.p * shuffled<3, 3, 3, 3>(q_a, q_a) + q_a * q_d);
}

/// f(i, j, s) of all springs.
template <class Net, std::size_t N, class F>
void each_spring(const NetStage<Net, N>& w, F f) noexcept {
  for (std::uint32_t i = 0; i < w.num_nodes; ++i)
    for (std::uint32_t s = w.first_of[i]; s < w.first_of[i + 1]; ++s) f(i, w.other[s], s);
}

/// Who carries whom, and which springs are of which node.
template <class Net, std::size_t N>
void index_net(const typename Net::Params& par, NetStage<Net, N>& w) noexcept {
  w.num_nodes = par.num_nodes;
  w.num_runs = 0;
  for (std::uint32_t n = 0; n < par.num_nodes; ++n) {
    if (n == 0 || par.nodes[n].body != par.nodes[n - 1].body) w.runs[w.num_runs++] = {.body = par.nodes[n].body, .first = n};
    w.runs[w.num_runs - 1].end = n + 1;
  }
  std::uint32_t s = 0;
  for (std::uint32_t n = 0; n <= par.num_nodes; ++n) {
    while (s < par.num_springs && par.springs[s].i < n) ++s;
    w.first_of[n] = s;
  }
  for (s = 0; s < par.num_springs; ++s) w.other[s] = par.springs[s].j;
}

/// The nodes of a run where the stage is predicted to end, with their anchors. at: of the carrier. bases: where the stage
/// starts.
template <class Net, std::size_t N, class Bases>
void begin_anchors(const typename Net::Params& par, const NetRun& run, const TreePlace& at, const Bases& bases,
                   const Vec3& gravity_W, Real h, NetStage<Net, N>& w) noexcept {
  const Column p_b(at.p_W), V_w(at.V.w), V_v(Vec3(at.V.v + at.V.w.cross(at.p_W - at.a_W)));
  const Block R{{Column(Vec3(at.R_WB.col(0))), Column(Vec3(at.R_WB.col(1))), Column(Vec3(at.R_WB.col(2)))}};
  const Column by_gravity(Vec3(h * gravity_W));
  for (std::uint32_t n = run.first; n < run.end; ++n) {
    const NetNode& node = par.nodes[n];
    const Column v = Column(bases[n].v_W) + by_gravity, p = Column(bases[n].p_W) + v * h, r = p - p_b;
    const Column x = r - R * Column(node.p_B), x_dot = v - V_v - cross(V_w, r);
    w.p[n] = p;
    w.v[n] = v;
    w.r[n] = r;
    w.m[n] = node.m;
    w.kappa[n] = h * (h * node.k + node.g);
    w.J_anchor[n] = x_dot * (h * h * node.k) - x * (h * node.k);
    w.b[n] = v * node.m + w.J_anchor[n];
  }
}

/// The springs; b of their nodes.
template <class Net, std::size_t N>
void begin_springs(const typename Net::Params& par, Real h, NetStage<Net, N>& w) noexcept {
  each_spring(w, [&](std::uint32_t i, std::uint32_t j, std::uint32_t s) noexcept {
    const NetSpring& spring = par.springs[s];
    const Column x = w.p[j] - w.p[i];
    const Real l = std::sqrt(dot(x, x)), h_k = h * spring.k;
    const Column u = l > 0 ? x * (1 / l) : Column(Vec3::UnitZ());
    const Real across = l > spring.l_0 ? h * h_k * (1 - spring.l_0 / l) : 0;
    const Real along = h * h_k + h * spring.g - across;
    const Column q = u * std::sqrt(std::max(along, Real(0)));
    w.q_a[s] = with_fourth(q.vec(), across);
    // J = K x' - h (k (l - l_0) + g u . x') u: the force of the law at the predicted velocities
    const Column x_dot = w.v[j] - w.v[i];
    const Column J = spring_product(w.q_a[s], x_dot) - u * (h_k * (l - spring.l_0) + h * spring.g * dot(u, x_dot));
    w.b[j] += J;
    w.b[i] -= J;
  });
}

/// What springs that pull resist of the turning of the carrier that both ends ride on: sum a (x^2 1 - x x^T).
template <class Net, std::size_t N>
void sum_prestress(NetStage<Net, N>& w) noexcept {
  for (std::size_t k = 0; k < w.num_runs; ++k) {
    const NetRun& run = w.runs[k];
    if (run.body == world) continue;
    Block A = Block::zero();
    for (std::uint32_t i = run.first; i < run.end; ++i) {
      for (std::uint32_t s = w.first_of[i]; s < w.first_of[i + 1]; ++s) {
        const Real a = w.q_a[s][3];
        if (!(a > 0) || w.other[s] >= run.end) continue;
        const Column x = w.p[w.other[s]] - w.p[i];
        A += Block::identity() * (a * dot(x, x));
        A -= outer(x * a, x);
      }
    }
    w.prestress[run.body] = {.ww = A, .wv = Block::zero(), .vv = Block::zero()};
  }
}

}  // namespace godobject
