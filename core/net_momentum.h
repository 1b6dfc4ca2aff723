// Angular momentum of a net in free flight with its carrier.
//
// An implicit integrator conserves linear momentum, but not the angular one: sum m p+ x v+ is sum m p x v+,
// because p+ = p + h v+, and springs that act along p+ have a torque about p. The change in a step is
// returned as a rotation of all flying parts,
//
//   (48)  w = I^-1 (L - L+),  v+ += w x (p+ - c),  about the common centre of mass c
//
// the projection on the conserved quantity (Hairer, Lubich, Wanner, Geometric Numerical Integration, IV.4).
// Under other forces the error is one of the integrator's order among others, and remains.
#pragma once

#include "core/stage.h"

namespace godobject {

/// Mass, centre, momentum and inertia of a flying group.
struct Flight {
  Real m = 0, size = 0;  // size: sum of m |r| |v|, an upper bound of the orbital part of |L_W|
  Vec3 mp_W = Vec3::Zero(), L_W = Vec3::Zero();
  Mat3 I_W = Mat3::Zero();

  Vec3 centre() const noexcept { return mp_W / m; }
  /// Adds a mass at r from the centre.
  void add(Real mass, const Vec3& r, const Vec3& v) noexcept {
    L_W += mass * r.cross(v);
    size += mass * r.norm() * v.norm();
    I_W += mass * (r.squaredNorm() * Mat3::Identity() - r * r.transpose());
  }
  void add(const RigidBodyParams& par, const RigidBodyState& x) noexcept {
    const Mat3 R = x.X_WB.q.toRotationMatrix();
    add(par.m, x.X_WB.p - centre(), x.v_W);
    L_W += R * (par.I_B * x.w_B);
    I_W += R * par.I_B * R.transpose();
  }
};

/// Flying group: the carrier of a run with its nodes.
struct WithCarrier {
  const NetRun& run;

  template <class F>
  void each_body(F f) const noexcept {
    f(run.body);
  }
  template <class F>
  void each_run(F f) const noexcept {
    f(run);
  }
};

/// Flying group: the nodes of a net without a carrier.
struct WithoutCarrier {
  const NodeRow& nodes;

  template <class F>
  void each_body(F) const noexcept {}
  template <class F>
  void each_run(F f) const noexcept {
    f(nodes);
  }
};

/// Flying group: the rows of a group of drifting nets.
template <class Net, std::size_t N>
struct Drifting {
  const NetStage<Net, N>& w;
  std::uint32_t group;

  template <class F>
  void each_body(F) const noexcept {}
  template <class F>
  void each_run(F f) const noexcept {
    for (std::size_t k = 0; k < w.par->num_rows; ++k)
      if (w.faces.drifts[k] && w.faces.group.of[k] == group) f(w.par->rows[k]);
  }
};

template <class Net, std::size_t N>
Drifting(const NetStage<Net, N>&, std::uint32_t) -> Drifting<Net, N>;

/// Flying group: bodies joined by attachments, with all their carried nodes. of[i]: number of body i's group.
template <class Net, std::size_t N>
struct Attached {
  const NetStage<Net, N>& w;
  std::array<std::uint32_t, N> of;
  std::array<bool, N> is_held;  // by group: true if attached to the world, or to a node of the world
  std::uint32_t number = 0;     // number of the current group

  explicit Attached(const NetStage<Net, N>& net) noexcept : w(net) {
    for (std::uint32_t i = 0; i < N; ++i) of[i] = i;
    for (const NetContactTerm& one : w.attached()) {
      if (!is_between(one)) continue;
      const std::uint32_t carrier = of[one.carrier], body = of[one.body];
      std::replace(of.begin(), of.end(), body, carrier);
    }
    is_held.fill(false);
    for (const NetContactTerm& one : w.attached())
      if (!is_between(one)) is_held[of[one.carrier == world ? one.body : one.carrier]] = true;
  }
  static bool is_between(const NetContactTerm& one) noexcept {
    return one.carrier != world && one.body != NetContactTerm::on_world;
  }
  template <class F>
  void each_body(F f) const noexcept {
    for (std::size_t i = 0; i < N; ++i)
      if (of[i] == number) f(i);
  }
  template <class F>
  void each_run(F f) const noexcept {
    each_carried(w, [&](const NetRun& run) noexcept {
      if (of[run.body] == number) f(run);
    });
  }
};

template <class FlyingGroup, class F>
void each_node_of(const FlyingGroup& flying, F f) noexcept {
  flying.each_run([&](const auto& run) noexcept {
    for (std::uint32_t n = run.first; n < run.end; ++n) f(n);
  });
}

/// Returns mass, centre, momentum and inertia of a flying group. body_of(i): the state of body i.
template <Scene S, class FlyingGroup, class BodyOf, class Nodes>
Flight flight_of(const Params<S>& par, const FlyingGroup& flying, BodyOf body_of,
                 const Nodes& nodes) noexcept {
  Flight all;
  const auto add_mass = [&](Real m, const Vec3& p_W) noexcept {
    all.m += m;
    all.mp_W += m * p_W;
  };
  flying.each_body([&](std::size_t i) noexcept { add_mass(par.bodies[i].body.m, body_of(i).X_WB.p); });
  each_node_of(flying, [&](std::uint32_t n) noexcept { add_mass(par.net.nodes[n].m, nodes[n].p_W); });
  flying.each_body([&](std::size_t i) noexcept { all.add(par.bodies[i].body, body_of(i)); });
  each_node_of(flying, [&](std::uint32_t n) noexcept {
    all.add(par.net.nodes[n].m, nodes[n].p_W - all.centre(), nodes[n].v_W);
  });
  return all;
}

/// True if near contact k is with a face whose carrier is body i.
template <class Net, std::size_t N>
bool is_face_of(std::size_t i, std::size_t k, const NetStage<Net, N>& w) noexcept {
  const FaceTouch* const face = w.touched_face(k);
  return face != nullptr && face->carrier == i;
}

/// True if only its net and gravity act on the body: no device, joint, term or contact, and no contact of its
/// nodes.
template <Scene S>
bool flies([[maybe_unused]] const Params<S>& par, const Scratch<S>& w, std::size_t i) noexcept {
  if constexpr (uses<typename S::Coupling>) {
    if (w.coupling_inputs[i].ramp.s > 0 && pulls(par.bodies[i].coupling)) return false;
  }
  if constexpr (uses<typename S::Device>) {
    const Wrench& F = w.coupling_inputs[i].F_WB;
    if (F.f.squaredNorm() + F.tau.squaredNorm() > 0) return false;
  }
  const auto& contacts = w.contacts;
  if constexpr (uses<typename S::Joints>) {
    if (contacts.graph.joints.joined[i]) return false;
  }
  if constexpr (uses<TermsOf<S>>) {
    for (std::size_t t = 0; t < contacts.graph.num_terms; ++t)
      if (contacts.graph.terms[t].contains(static_cast<std::uint32_t>(i))) return false;
  }
  for (std::size_t k = 0; k < contacts.near.size; ++k)
    if (contacts.near.list[k].a == i || contacts.near.list[k].b == i) return false;
  for (std::size_t k = 0; k < contacts.net.near.size; ++k)
    if (contacts.net.carrier[k] == i || contacts.net.near.list[k].b == i || is_face_of(i, k, contacts.net))
      return false;
  return true;
}

/// True if a spring joins a node of the run to one of another carrier.
template <class Net, std::size_t N>
bool joins_carriers(const NetStage<Net, N>& w, const NetRun& run) noexcept {
  for (std::size_t s = 0; s < w.par->num_springs; ++s)
    if (run.holds(w.par->springs[s].i) != run.holds(w.par->springs[s].j)) return true;
  return false;
}

/// Applies the correction (48) to a flying group.
template <Scene S, class FlyingGroup>
void restore_angular_momentum(const Params<S>& par, const State<S>& x, const FlyingGroup& flying,
                              Scratch<S>& w) noexcept {
  const auto before_of = [&](std::size_t i) noexcept -> const RigidBodyState& { return x.bodies[i].x; };
  const auto after_of = [&](std::size_t i) noexcept -> RigidBodyState {
    return lane(w.next[i / lanes<S>].x, i % lanes<S>);
  };
  const Flight before = flight_of(par, flying, before_of, x.net.nodes),
               after = flight_of(par, flying, after_of, w.net.next);
  const Vec3 lost = before.L_W - after.L_W;
  if (lost.norm() > max_given_back * before.size) return;
  const Vec3 w_W = solve3<Real>(after.I_W, lost), c = after.centre();
  const auto turn = [&](std::size_t i) noexcept {
    Next<S>& next = w.next[i / lanes<S>];
    const RigidBodyState body = after_of(i);
    set_lane(next.x.v_W, i % lanes<S>, Vec3(body.v_W + w_W.cross(body.X_WB.p - c)));
    set_lane(next.x.w_B, i % lanes<S>, Vec3(body.w_B + to_body<Real>(body.X_WB.q, w_W)));
  };
  flying.each_body(turn);
  each_node_of(flying,
               [&](std::uint32_t n) noexcept { w.net.next[n].v_W += w_W.cross(w.net.next[n].p_W - c); });
}

/// Applies the correction (48) to nets that touch each other. Their contacts lose more than springs do, and
/// the rotation may raise the kinetic energy. Their deformation then slows down by the share that keeps it.
template <Scene S, class FlyingGroup>
void restore_angular_momentum_of_drifting(const Params<S>& par, const State<S>& x, const FlyingGroup& flying,
                                          Scratch<S>& w) noexcept {
  const auto no_body = [](std::size_t) noexcept -> RigidBodyState { return {}; };
  const Flight before = flight_of(par, flying, no_body, x.net.nodes),
               after = flight_of(par, flying, no_body, w.net.next);
  const Vec3 lost = before.L_W - after.L_W, c = after.centre();
  if (lost.norm() > max_given_back * before.size) return;
  const Vec3 w_W = solve3<Real>(after.I_W, lost), rigid_W = solve3<Real>(after.I_W, after.L_W);
  const Real given = w_W.dot(after.L_W + Real(0.5) * lost);  // J
  Vec3 p_sum = Vec3::Zero();
  each_node_of(flying, [&](std::uint32_t n) noexcept { p_sum += par.net.nodes[n].m * w.net.next[n].v_W; });
  const Vec3 v_c = p_sum / after.m;
  const auto deforming = [&](std::uint32_t n) noexcept -> Vec3 {
    return w.net.next[n].v_W - v_c - rigid_W.cross(w.net.next[n].p_W - c);
  };
  Real in_deformation = 0;  // J
  each_node_of(flying, [&](std::uint32_t n) noexcept {
    in_deformation += Real(0.5) * par.net.nodes[n].m * deforming(n).squaredNorm();
  });
  if (std::abs(given) > max_given_back * in_deformation) return;
  const Real left = given > 0 ? std::sqrt(1 - given / in_deformation) : 1;
  each_node_of(flying, [&](std::uint32_t n) noexcept {
    w.net.next[n].v_W += w_W.cross(w.net.next[n].p_W - c) - (1 - left) * deforming(n);
  });
}

/// Applies the correction (48) to w.next.
template <Scene S>
void conserve_angular_momentum(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
  const auto& net = w.contacts.net;
  each_floating(net, [&](const NodeRow& nodes, const RowStage& of) noexcept {
    if (of.flies) restore_angular_momentum(par, x, WithoutCarrier{nodes}, w);
  });
  if constexpr (NetOf<S>::max_faces > 0)
    for (std::uint32_t k = 0; net.faces.num_drifting > 0 && k < par.net.num_rows; ++k)
      if (net.faces.drifts[k] && net.faces.group.of[k] == k)
        restore_angular_momentum_of_drifting(par, x, Drifting{net, k}, w);
  if (net.attached().empty()) {
    each_carried(net, [&](const NetRun& run) noexcept {
      if (flies(par, w, run.body) && !joins_carriers(net, run))
        restore_angular_momentum(par, x, WithCarrier{run}, w);
    });
    return;
  }
  Attached flying(net);
  each_carried(net, [&](const NetRun& run) noexcept {
    flying.number = flying.of[run.body];
    bool fly = !flying.is_held[flying.number], is_first = true;
    flying.each_body([&](std::size_t i) noexcept { fly = fly && flies(par, w, i); });
    flying.each_run([&](const NetRun& other) noexcept {
      is_first = is_first && other.first >= run.first;
      fly = fly && !joins_carriers(net, other);
    });
    if (fly && is_first) restore_angular_momentum(par, x, flying, w);
  });
}

}  // namespace godobject
