// Anchors and springs of nets in a stage: effective masses and impulses, linear from where the stage is predicted to end.
//
//   (41)  spring:  impulse J - K x' on j,  K = a 1 + q q^T,  a = h^2 k max(1 - l_0 / l, 0),  q q^T = (h^2 k + h g - a) u u^T
//   (47)  or from where the stage starts, at rest:  a = h^2 k
//   (42)  anchor:  impulse J - kappa (v_n - v_b - w_b x r),  kappa = h (h k + g)
//
// Both as (37). A spring is four numbers in the system: its product takes no matrix. Where it is shorter than l_0, what it
// loses across itself is left out, since the system is to be positive definite; where it is longer, nothing is. The lever
// of an anchor is where its node is: so it does nothing where body and node turn as one.
#pragma once

#include "core/joint/tree.h"
#include "core/net/scratch.h"

namespace godobject {

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
    if (n == 0 || par.nodes[n].body != par.nodes[n - 1].body)
      w.runs[w.num_runs++] = {.body = par.nodes[n].body, .first = n};
    w.runs[w.num_runs - 1].end = n + 1;
  }
  std::uint32_t s = 0;
  for (std::uint32_t n = 0; n <= par.num_nodes; ++n) {
    while (s < par.num_springs && par.springs[s].i < n) ++s;
    w.first_of[n] = s;
  }
  for (s = 0; s < par.num_springs; ++s) w.other[s] = par.springs[s].j;
  w.order = par.order.data();
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
/// (47)  Or at rest where the stage starts.
template <class Net, std::size_t N>
void rest_at_start(Real h, NetStage<Net, N>& w) noexcept {
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    w.p[n] -= w.v[n] * h;
    w.v[n] = Column(Pack(0));
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

/// Columns whose fourth places are these lanes.
inline std::array<Column, 4> columns(const Vector3<Pack>& a, const Pack& fourth) noexcept {
  const Pack xy_02 = shuffled<0, 4, 2, 6>(a[0], a[1]), xy_13 = shuffled<1, 5, 3, 7>(a[0], a[1]);
  const Pack z_02 = shuffled<0, 4, 2, 6>(a[2], fourth), z_13 = shuffled<1, 5, 3, 7>(a[2], fourth);
  return {Column(shuffled<0, 1, 4, 5>(xy_02, z_02)), Column(shuffled<0, 1, 4, 5>(xy_13, z_13)),
          Column(shuffled<2, 3, 6, 7>(xy_02, z_02)), Column(shuffled<2, 3, 6, 7>(xy_13, z_13))};
}

/// Four springs that follow each other; the last of `left` ones for those that are missing.
struct FourSprings {
  std::array<const NetSpring*, 4> of;

  FourSprings(const NetSpring* first, std::uint32_t left) noexcept {
    for (std::uint32_t n = 0; n < 4; ++n) of[n] = first + std::min(n, left - 1);
  }
  Pack of_each(Real NetSpring::*of_one) const noexcept {
    return {of[0]->*of_one, of[1]->*of_one, of[2]->*of_one, of[3]->*of_one};
  }
  /// From their first nodes to their second.
  template <class Nodes>
  Vector3<Pack> between(const Nodes& at) const noexcept {
    return in_lanes(at[of[0]->j] - at[of[0]->i], at[of[1]->j] - at[of[1]->i], at[of[2]->j] - at[of[2]->i],
                    at[of[3]->j] - at[of[3]->i]);
  }
};

/// As what springs are taken: linear where the stage is predicted to end, or (47).
enum class Springs { linear, majorised };

/// (41)  Four springs: with the ends x and x' apart where the stage is predicted to end.
struct SpringPack {
  Vector3<Pack> q, J;
  Pack a, l;
};
template <Springs as>
SpringPack spring_stage(const Pack& k, const Pack& g, const Pack& l_0, const Vector3<Pack>& x,
                        const Vector3<Pack>& x_dot, Real h) noexcept {
  const Pack l = sqrt(x.squaredNorm()), h_k = k * h, h_g = g * h;
  const PackMask has_length = Pack(0) < l;
  const Pack r = 1 / select(has_length, l, Pack(1));
  const Vector3<Pack> u(x[0] * r, x[1] * r, select(has_length, x[2] * r, Pack(1)));
  const Pack a = as == Springs::majorised
                     ? h_k * h
                     : max(h_k * (1 - l_0 * r), Pack(0)) * h * select(has_length, Pack(1), Pack(0));
  const Pack along = max(h_k * h + h_g - a, Pack(0)), u_x_dot = u.dot(x_dot);
  // J = K x' - h (k (l - l_0) + g u . x') u: the force of the law at the predicted velocities
  return {
      .q = u * sqrt(along), .J = x_dot * a + u * ((along - h_g) * u_x_dot - h_k * (l - l_0)), .a = a, .l = l};
}

/// The springs; b of their nodes. Of springs that pull, what they resist of the turning of the carrier that both ends ride on:
/// sum a (x^2 1 - x x^T).
template <Springs as, class Net, std::size_t N>
void begin_springs(const typename Net::Params& par, Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t k = 0; k < w.num_runs; ++k) {
    const NetRun& run = w.runs[k];
    std::array<Pack, 6> a_xx{0, 0, 0, 0, 0, 0};  // sum a x x^T: xx, yy, zz, xy, xz, yz
    const std::uint32_t end = w.first_of[run.end];
    for (std::uint32_t s = w.first_of[run.first]; s < end; s += 4) {
      const FourSprings springs(&par.springs[s], end - s);
      const auto& of = springs.of;
      const Vector3<Pack> x = springs.between(w.p);
      const SpringPack four = spring_stage<as>(springs.of_each(&NetSpring::k), springs.of_each(&NetSpring::g),
                                               springs.of_each(&NetSpring::l_0), x, springs.between(w.v), h);
      const std::array<Column, 4> q_a = columns(four.q, four.a), J = columns(four.J);
      Pack a = four.a;  // of springs between nodes of this run
      for (std::uint32_t n = 0; n < 4; ++n) {
        if (s + n >= end || of[n]->j >= run.end) a.set(n, 0);
        if (s + n >= end) continue;
        w.q_a[s + n] = q_a[n].p;
        w.b[of[n]->j] += J[n];
        w.b[of[n]->i] -= J[n];
      }
      const Vector3<Pack> ax = x * a;
      a_xx[0] += ax[0] * x[0];
      a_xx[1] += ax[1] * x[1];
      a_xx[2] += ax[2] * x[2];
      a_xx[3] += ax[0] * x[1];
      a_xx[4] += ax[0] * x[2];
      a_xx[5] += ax[1] * x[2];
    }
    if (run.body == world) continue;
    const auto sum = [&](std::size_t k_l) noexcept { return total(a_xx[k_l]); };
    Mat3 A;
    A << sum(1) + sum(2), -sum(3), -sum(4), -sum(3), sum(0) + sum(2), -sum(5), -sum(4), -sum(5),
        sum(0) + sum(1);
    w.prestress[run.body] = {.ww = block_of(A), .wv = Block::zero(), .vv = Block::zero()};
  }
}

/// (46)  What springs gain in a stage whose solution is v, but for what others do on the nodes, J; of what they take and give;
/// and the mass of the nodes, kg.
struct SpringGain {
  Real gained = 0, exchanged = 0, mass = 0;

  /// speed: below which nothing moves, m/s.
  bool is_too_much(Real speed) const noexcept {
    return gained > max_spring_gain * exchanged + mass * speed * speed;
  }
};
template <class Net, std::size_t N, class Velocities>
SpringGain spring_gain(const typename Net::Params& par, const Velocities& v, const Vec3& gravity_W, Real h,
                       const NetStage<Net, N>& w) noexcept {
  SpringGain sum;
  const Column by_gravity(Vec3(h * gravity_W));
  Real m_v_sq = 0;
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    const Column change = v[n] - w.v_free[n] + by_gravity;
    m_v_sq += w.m[n] * dot(change, change);
    sum.mass += w.m[n];
  }
  sum.gained = Real(-0.5) * m_v_sq;
  Pack gained = 0, exchanged = 0;
  const auto num_springs = static_cast<std::uint32_t>(par.num_springs);
  for (std::uint32_t s = 0; s < num_springs; s += 4) {
    const FourSprings springs(&par.springs[s], num_springs - s);
    const Pack k = springs.of_each(&NetSpring::k), g = springs.of_each(&NetSpring::g),
               l_0 = springs.of_each(&NetSpring::l_0);
    const Vector3<Pack> x = springs.between(w.p), x_dot = springs.between(w.v), v_j_i = springs.between(v);
    const Vector3<Pack> d = v_j_i - x_dot;
    const Pack l = sqrt(x.squaredNorm()), l_start = sqrt((x - x_dot * Pack(h)).squaredNorm()),
               l_end = sqrt((x + d * Pack(h)).squaredNorm()), per_l = 1 / l;
    const Pack F = k * (1 - l_0 * per_l) + g * x.dot(x_dot) * per_l * per_l;  // along x
    std::array<Pack, 4> q_a;
    for (std::uint32_t n = 0; n < 4; ++n) q_a[n] = w.q_a[std::min(s + n, num_springs - 1)];
    const auto [q_x, q_y, q_z, a] = columns({q_a[0], q_a[1], q_a[2]}, q_a[3]);
    const Vector3<Pack> q(q_x.p, q_y.p, q_z.p), J = -(x * (F * h) + d * a.p + q * q.dot(d));
    const Pack dU = k * (l_end - l_start) * ((l_end + l_start) * Real(0.5) - l_0);
    Pack gain = select(Pack(0) < l, dU + J.dot(v_j_i), Pack(0));
    for (std::uint32_t n = num_springs - s; n < 4; ++n) gain.set(n, 0);
    gained += gain;
    exchanged += max(dU, -dU);
  }
  sum.gained += total(gained);
  sum.exchanged = total(exchanged);
  return sum;
}

}  // namespace godobject
