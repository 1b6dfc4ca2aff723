// Anchors and springs of nets in a stage: effective masses and impulses, linearised at the predicted end of
// the stage.
//
//   (41)  spring:  impulse J - K x' on j,  K = a 1 + b u u^T,
//                  a = h^2 k max(1 - l_0 / l, 0),  b = h^2 k + h g - a
//   (47)  or from where the stage starts, at rest:  a = h^2 k
//   (42)  anchor:  impulse J - kappa (v_n - v_b - w_b x r),  kappa = h (h k + g)
//
// Both have the form of (37). A spring is u, a and b in the system. Its product needs no matrix and is
// computed for the four springs of a slot (groups.h). The negative stiffness across a spring shorter than l_0
// is left out, so that the system is positive definite. Taking the lever of an anchor at the node makes rigid
// motion force-free.
#pragma once

#include "core/joint/tree.h"
#include "core/net/scratch.h"

namespace godobject {

/// Returns the numbers of v for the nodes of a group, or the second ends of a slot, one per lane.
template <class Vector>
Vector3<Pack> in_lanes(const Vector& v, const std::array<std::uint32_t, 4>& n) noexcept {
  return in_lanes(v[n[0]], v[n[1]], v[n[2]], v[n[3]]);
}
/// Computes y += a, lane by lane, because lanes may be of the same node.
template <class Vector>
void add_lanes(const Vector3<Pack>& a, const std::array<std::uint32_t, 4>& n, Vector& y) noexcept {
  const std::array<Column, 4> of = columns(a);
  for (std::size_t j = 0; j < 4; ++j) y[n[j]] += of[j];
}

/// Computes y += A_springs v.
template <class Net, std::size_t N, class Vector>
void add_springs_product(const NetStage<Net, N>& w, const Vector& v, Vector& y) noexcept {
  for (const NodeGroup& group : w.groups()) {
    const Vector3<Pack> v_i = in_lanes(v, group.nodes);
    Vector3<Pack> on_i = Vector3<Pack>::Constant(Pack(0));
    for (std::uint32_t s = group.first; s < group.end; ++s) {
      const auto& others = w.par->slots[s].others;
      const Vector3<Pack> J = w.masses[s] * (in_lanes(v, others) - v_i);
      add_lanes(J, others, y);
      on_i -= J;
    }
    add_lanes(on_i, group.nodes, y);
  }
}

/// Indexes the nodes by their carriers.
template <class Net, std::size_t N>
void index_net(const typename Net::Params& par, NetStage<Net, N>& w) noexcept {
  w.par = &par;
  w.num_nodes = par.num_nodes;
  w.num_runs = 0;
  std::uint32_t end = 0;
  for (std::uint32_t g = 0; g < par.num_groups; ++g) {
    const std::size_t body = par.nodes[par.groups[g].nodes[0]].body;
    if (g == 0 || body != w.runs[w.num_runs - 1].body)
      w.runs[w.num_runs++] = {.body = body, .first = end, .first_group = g};
    NetRun& run = w.runs[w.num_runs - 1];
    run.end = end += par.groups[g].size;
    run.end_group = g + 1;
  }
}

/// Predicts the nodes at the end of the stage from their bases.
template <class Net, std::size_t N, class Bases>
void predict_nodes(const Bases& bases, const Vec3& gravity_W, Real h, NetStage<Net, N>& w) noexcept {
  const Column by_gravity = w.by_gravity = Column(Vec3(h * gravity_W));
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    w.v_free[n] = w.v[n] = Column(bases[n].v_W) + by_gravity;
    w.p[n] = Column(bases[n].p_W) + w.v[n] * h;
  }
}
/// Places the nodes at rest at the start of the stage (47).
template <class Net, std::size_t N>
void rest_at_start(Real h, NetStage<Net, N>& w) noexcept {
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) {
    w.p[n] -= w.v[n] * h;
    w.v[n] = Column(Pack(0));
  }
}

/// Begins the anchors of a run. at: predicted place of the carrier.
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
    w.settling[n] = 0;
    w.J_anchor[n] = (x_dot * h - x) * h_k;
    w.b[n] = w.v_free[n] * node.m + w.J_anchor[n];
  }
}

/// Returns one parameter of the springs of a slot, one spring per lane.
template <class Springs>
Pack of_each(const Springs& springs, const SpringSlot& slot, Real NetSpring::*of_one) noexcept {
  const auto& n = slot.springs;
  return {springs[n[0]].*of_one, springs[n[1]].*of_one, springs[n[2]].*of_one, springs[n[3]].*of_one};
}

/// Linearisation of springs: at the predicted end of the stage, or majorised (47).
enum class Springs { linear, majorised };

/// Begins springs (41). x, x_dot: vector between the ends, and its rate, at the predicted end of the stage.
template <Springs as>
void begin_slot(const Pack& k, const Pack& g, const Pack& l_0, const Vector3<Pack>& x,
                const Vector3<Pack>& x_dot, Real h, SlotMass& K, Vector3<Pack>& J) noexcept {
  const Pack l_sq = x.squaredNorm(), l = sqrt(l_sq), h_k = k * h, h_g = g * h;
  const PackMask has_length = Pack(0) < l;
  // 1 / l without the root, so that both are computed at once
  const Pack r = l / select(has_length, l_sq, Pack(1));
  const Pack u_x = x[0] * r, u_y = x[1] * r, u_z = select(has_length, x[2] * r, Pack(1));
  const Pack a = as == Springs::majorised
                     ? h_k * h
                     : max(h_k * (1 - l_0 * r), Pack(0)) * h * select(has_length, Pack(1), Pack(0));
  const Pack b = max(h_k * h + h_g - a, Pack(0));
  // J = K x' - h (k (l - l_0) + g u . x') u: the force of the law at the predicted velocities
  const Pack along = (b - h_g) * (u_x * x_dot[0] + u_y * x_dot[1] + u_z * x_dot[2]) - h_k * (l - l_0);
  J[0] = x_dot[0] * a + u_x * along;
  J[1] = x_dot[1] * a + u_y * along;
  J[2] = x_dot[2] * a + u_z * along;
  K.u[0] = u_x;
  K.u[1] = u_y;
  K.u[2] = u_z;
  K.a = a;
  K.b = b;
}

/// Begins the springs and adds b of their nodes. prestress: resistance of tensioned springs to rotation of
/// the carrier of both ends, sum a (x^2 1 - x x^T).
template <Springs as, class Net, std::size_t N>
void begin_springs(const typename Net::Params& par, Real h, NetStage<Net, N>& w) noexcept {
  for (std::size_t k = 0; k < w.num_runs; ++k) {
    const NetRun& run = w.runs[k];
    std::array<Pack, 6> a_xx{0, 0, 0, 0, 0, 0};  // sum a x x^T: xx, yy, zz, xy, xz, yz
    for (std::uint32_t g = run.first_group; g < run.end_group; ++g) {
      const NodeGroup& group = par.groups[g];
      const Vector3<Pack> p_i = in_lanes(w.p, group.nodes), v_i = in_lanes(w.v, group.nodes);
      Vector3<Pack> on_i = Vector3<Pack>::Constant(Pack(0));
      for (std::uint32_t s = group.first; s < group.end; ++s) {
        const SpringSlot& slot = par.slots[s];
        const Vector3<Pack> x = in_lanes(w.p, slot.others) - p_i, x_dot = in_lanes(w.v, slot.others) - v_i;
        SlotMass& K = w.masses[s];
        Vector3<Pack>& J = w.J_springs[s];
        begin_slot<as>(of_each(par.springs, slot, &NetSpring::k), of_each(par.springs, slot, &NetSpring::g),
                       of_each(par.springs, slot, &NetSpring::l_0), x, x_dot, h, K, J);
        add_lanes(J, slot.others, w.b);
        on_i -= J;
        Pack a = K.a;  // springs between nodes of this run
        if (std::any_of(slot.others.begin(), slot.others.end(),
                        [&](std::uint32_t n) { return n >= run.end; })) [[unlikely]]
          for (std::size_t j = 0; j < 4; ++j)
            if (slot.others[j] >= run.end) a.set(j, 0);
        const Vector3<Pack> ax = x * a;
        a_xx[0] += ax[0] * x[0];
        a_xx[1] += ax[1] * x[1];
        a_xx[2] += ax[2] * x[2];
        a_xx[3] += ax[0] * x[1];
        a_xx[4] += ax[0] * x[2];
        a_xx[5] += ax[1] * x[2];
      }
      add_lanes(on_i, group.nodes, w.b);
    }
    if (run.body == world) continue;
    const auto sum = [&](std::size_t k_l) noexcept { return total(a_xx[k_l]); };
    Mat3 A;
    A << sum(1) + sum(2), -sum(3), -sum(4), -sum(3), sum(0) + sum(2), -sum(5), -sum(4), -sum(5),
        sum(0) + sum(1);
    w.prestress[run.body] = {.ww = block_of(A), .wv = Block::zero(), .vv = Block::zero()};
  }
}

/// Energy gain of springs (46) in a stage with the solution v, J, without the work of others on the nodes.
/// Also the exchanged energy, J, and the mass of the nodes, kg.
struct SpringGain {
  Real gained = 0, exchanged = 0, mass = 0;

  /// True if the gain exceeds the tolerance. speed: slower motion counts as rest, m/s.
  bool exceeds_tolerance(Real speed) const noexcept {
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
  for (const NodeGroup& group : w.groups()) {
    // at the start of the stage, and the nodes' motion in it
    const auto start = [&](const auto& nodes) noexcept -> Vector3<Pack> {
      return in_lanes(w.p, nodes) - in_lanes(w.v, nodes) * Pack(h);
    };
    const Vector3<Pack> start_i = start(group.nodes), v_i = in_lanes(v, group.nodes);
    for (std::uint32_t s = group.first; s < group.end; ++s) {
      const SpringSlot& slot = par.slots[s];
      const Pack k = of_each(par.springs, slot, &NetSpring::k),
                 l_0 = of_each(par.springs, slot, &NetSpring::l_0);
      const Vector3<Pack> x = start(slot.others) - start_i, v_j_i = in_lanes(v, slot.others) - v_i;
      const Pack l_start = sqrt(x.squaredNorm()), l_end = sqrt((x + v_j_i * Pack(h)).squaredNorm());
      const Pack dU = k * (l_end - l_start) * ((l_end + l_start) * Real(0.5) - l_0);
      const Vector3<Pack> J = w.J_springs[s] - w.masses[s] * v_j_i;
      gained += dU + J.dot(v_j_i);
      exchanged += max(dU, -dU);
    }
  }
  sum.gained += total(gained);
  sum.exchanged = total(exchanged);
  return sum;
}

}  // namespace godobject
