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
inline Pack with_fourth(const Column& a, Real fourth) noexcept { return {a.x(), a.y(), a.z(), fourth}; }

/// K d of a spring.
inline Column spring_product(const Pack& q_a, const Column& d) noexcept {
  const Pack m = q_a * d.p;
  const Pack q_d = m + rotated(m) + shuffled<2, 0, 1, 3>(m, m);
  return Column(d.p * shuffled<3, 3, 3, 3>(q_a, q_a) + q_a * q_d);
}

/// y += A_springs v.
template <class Net, std::size_t N, class Vector>
void add_springs_product(const NetStage<Net, N>& w, const Vector& v, Vector& y) noexcept {
  for (std::uint32_t i = 0, s = 0; i < w.num_nodes; ++i) {
    const Column v_i = v[i];
    Column on_i(Pack(0));
    for (const std::uint32_t end = w.first_of[i + 1]; s < end; ++s) {
      const std::uint32_t j = w.other[s];
      const Column J = spring_product(w.q_a[s], v[j] - v_i);
      y[j] += J;
      on_i += J;
    }
    y[i] -= on_i;
  }
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

/// Where the nodes are predicted to be at the end of the stage: where their bases lead them.
template <class Net, std::size_t N, class Bases>
void predict_nodes(const Bases& bases, const Vec3& gravity_W, Real h, NetStage<Net, N>& w) noexcept {
  const Column by_gravity(Vec3(h * gravity_W));
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    w.v_free[n] = w.v[n] = Column(bases[n].v_W) + by_gravity;
    w.p[n] = Column(bases[n].p_W) + w.v[n] * h;
  }
}
/// (46)  Or where velocities v lead them.
template <class Net, std::size_t N, class Velocities>
void lead_nodes(const Velocities& v, Real h, NetStage<Net, N>& w) noexcept {
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    w.p[n] += (v[n] - w.v[n]) * h;
    w.v[n] = v[n];
  }
}

/// The anchors of a run. at: of the carrier.
template <class Net, std::size_t N>
void begin_anchors(const typename Net::Params& par, const NetRun& run, const TreePlace& at, Real h,
                   NetStage<Net, N>& w) noexcept {
  const Column p_b(at.p_W), V_w(at.V.w), V_v(Vec3(at.V.v + at.V.w.cross(at.p_W - at.a_W)));
  const Block R{{Column(Vec3(at.R_WB.col(0))), Column(Vec3(at.R_WB.col(1))), Column(Vec3(at.R_WB.col(2)))}};
  for (std::uint32_t n = run.first; n < run.end; ++n) {
    const NetNode& node = par.nodes[n];
    const Column r = w.p[n] - p_b, x = r - R * Column(node.p_B), x_dot = w.v[n] - V_v - cross(V_w, r);
    const Real h_k = h * node.k;
    w.r[n] = r;
    w.m[n] = node.m;
    w.kappa[n] = h * (h_k + node.g);
    w.J_anchor[n] = (x_dot * h - x) * h_k;
    w.b[n] = w.v_free[n] * node.m + w.J_anchor[n];
  }
}

/// The springs; b of their nodes. Of springs that pull, what they resist of the turning of the carrier that both ends ride on:
/// sum a (x^2 1 - x x^T).
template <class Net, std::size_t N>
void begin_springs(const typename Net::Params& par, Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t k = 0; k < w.num_runs; ++k) {
    const NetRun& run = w.runs[k];
    Block prestress = Block::zero();
    for (std::uint32_t i = run.first, s = w.first_of[i]; i < run.end; ++i) {
      const Column p_i = w.p[i], v_i = w.v[i];
      Column on_i(Pack(0));
      for (const std::uint32_t end = w.first_of[i + 1]; s < end; ++s) {
        const NetSpring& spring = par.springs[s];
        const std::uint32_t j = w.other[s];
        const Column x = w.p[j] - p_i, x_dot = w.v[j] - v_i;
        const Real l = std::sqrt(dot(x, x)), r = 1 / l, h_k = h * spring.k, h_g = h * spring.g;
        const Column u = l > 0 ? x * r : Column(Vec3::UnitZ());
        const Real across = l > spring.l_0 ? h * h_k * (1 - spring.l_0 * r) : 0;
        const Real along = h * h_k + h_g - across, u_x_dot = dot(u, x_dot);
        const Column q = u * std::sqrt(std::max(along, Real(0)));
        w.q_a[s] = with_fourth(q, across);
        // J = K x' - h (k (l - l_0) + g u . x') u: the force of the law at the predicted velocities
        const Column J = x_dot * across + u * (along * u_x_dot - h_k * (l - spring.l_0) - h_g * u_x_dot);
        w.b[j] += J;
        on_i += J;
        if (across > 0 && j < run.end) {
          prestress += Block::identity() * (across * l * l);
          prestress -= outer(x * across, x);
        }
      }
      w.b[i] -= on_i;
    }
    if (run.body != world) w.prestress[run.body] = {.ww = prestress, .wv = Block::zero(), .vv = Block::zero()};
  }
}

/// What (41) misses of the springs' forces where velocities v lead, as velocities that this gives to nodes of the mass of the
/// first, and that the next stage, in which a stiff spring takes back what it can, makes of it; and the velocities
/// themselves: both squared and times mass.
struct SpringMiss {
  Real missed = 0, kinetic = 0;
};
template <class Net, std::size_t N, class Velocities>
SpringMiss spring_miss(const typename Net::Params& par, const Velocities& v, Real h, const NetStage<Net, N>& w) noexcept {
  SpringMiss sum;
  for (std::uint32_t i = 0, s = 0; i < w.num_nodes; ++i) {
    const Column v_i = v[i], p_i = w.p[i], d_i = v_i - w.v[i];
    sum.kinetic += w.m[i] * dot(v_i, v_i);
    for (const std::uint32_t end = w.first_of[i + 1]; s < end; ++s) {
      const NetSpring& spring = par.springs[s];
      const std::uint32_t j = w.other[s];
      const Column x = w.p[j] - p_i, x_dot = w.v[j] - w.v[i], d = v[j] - w.v[j] - d_i;
      const Real l = std::sqrt(dot(x, x)), r = 1 / l;
      const Column x_1 = x + d * h, x_dot_1 = x_dot + d;
      const Real l_1 = std::sqrt(dot(x_1, x_1)), r_1 = 1 / l_1;
      const Column F = x * (spring.k * (1 - spring.l_0 * r) + spring.g * dot(x, x_dot) * r * r);
      const Column F_1 = x_1 * (spring.k * (1 - spring.l_0 * r_1) + spring.g * dot(x_1, x_dot_1) * r_1 * r_1);
      const Column miss = (F_1 - F) * h - spring_product(w.q_a[s], d);
      const Real h_k_h = h * (h * spring.k + spring.g);
      if (l > 0 && l_1 > 0) sum.missed += dot(miss, miss) * w.m[i] / ((w.m[i] + h_k_h) * (w.m[i] + h_k_h));
    }
  }
  return sum;
}

}  // namespace godobject
