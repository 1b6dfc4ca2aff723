// A net in free flight with its carrier keeps its angular momentum.
//
// An implicit integrator keeps linear momentum and not the angular one: sum m p+ x v+ is sum m p x v+, since p+ = p + h v+, and
// springs that act along p+ have a torque about p. What a step has changed of it is given back as a turn of all that flies,
//
//   (48)  w = I^-1 (L - L+),  v+ += w x (p+ - c),  about the common centre of mass c
//
// the projection on what is to be kept (Hairer, Lubich, Wanner, Geometric Numerical Integration, IV.4). Where anything else
// acts, the error is one of the integrator's order among others, and stays.
#pragma once

#include "core/stage.h"

namespace godobject {

/// Mass, centre, momentum and inertia of what moves as one.
struct Flight {
  Real m = 0, size = 0;  // size: of L_W without spin, were all its parts one way
  Vec3 mp_W = Vec3::Zero(), L_W = Vec3::Zero();
  Mat3 I_W = Mat3::Zero();

  Vec3 centre() const noexcept { return mp_W / m; }
  /// A mass at r from the centre.
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

/// The carrier of a run with its nodes.
struct Alone {
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

/// The nodes of a net that flies without a carrier.
struct WithoutCarrier {
  const NodeRow& nodes;

  template <class F>
  void each_body(F) const noexcept {}
  template <class F>
  void each_run(F f) const noexcept {
    f(nodes);
  }
};

/// Bodies that attachments join to one, with all nodes that these carry: body i is of the group number of[i].
template <class Net, std::size_t N>
struct Attached {
  const NetStage<Net, N>& w;
  std::array<std::uint32_t, N> of;
  std::array<bool, N> is_held;  // by number: attached to the world, or a node of the world to it
  std::uint32_t number = 0;     // of the group at hand

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

template <class Flyers, class F>
void each_node_of(const Flyers& flyers, F f) noexcept {
  flyers.each_run([&](const auto& run) noexcept {
    for (std::uint32_t n = run.first; n < run.end; ++n) f(n);
  });
}

/// What they are as one. body_of(i): the state of body i.
template <Scene S, class Flyers, class BodyOf, class Nodes>
Flight flight_of(const Params<S>& par, const Flyers& flyers, BodyOf body_of, const Nodes& nodes) noexcept {
  Flight all;
  const auto add_mass = [&](Real m, const Vec3& p_W) noexcept {
    all.m += m;
    all.mp_W += m * p_W;
  };
  flyers.each_body([&](std::size_t i) noexcept { add_mass(par.bodies[i].body.m, body_of(i).X_WB.p); });
  each_node_of(flyers, [&](std::uint32_t n) noexcept { add_mass(par.net.nodes[n].m, nodes[n].p_W); });
  flyers.each_body([&](std::size_t i) noexcept { all.add(par.bodies[i].body, body_of(i)); });
  each_node_of(flyers, [&](std::uint32_t n) noexcept {
    all.add(par.net.nodes[n].m, nodes[n].p_W - all.centre(), nodes[n].v_W);
  });
  return all;
}

/// Nothing acts on the body but its net and gravity: no device, joint, term or contact, nor on the nodes that it carries.
template <Scene S>
bool flies([[maybe_unused]] const Params<S>& par, const Scratch<S>& w, std::size_t i) noexcept {
  if constexpr (uses<typename S::Coupling>) {
    if (w.pulls[i].ramp.s > 0 && pulls(par.bodies[i].coupling)) return false;
  }
  if constexpr (uses<typename S::Device>) {
    const Wrench& F = w.pulls[i].F_WB;
    if (F.f.squaredNorm() + F.tau.squaredNorm() > 0) return false;
  }
  const auto& contacts = w.contacts;
  if constexpr (uses<typename S::Joints>) {
    if (contacts.graph.joints.joined[i]) return false;
  }
  if constexpr (uses<TermsOf<S>>) {
    for (std::size_t t = 0; t < contacts.graph.num_terms; ++t)
      if (contacts.graph.terms[t].i == i || contacts.graph.terms[t].j == i) return false;
  }
  for (std::size_t k = 0; k < contacts.near.size; ++k)
    if (contacts.near.list[k].a == i || contacts.near.list[k].b == i) return false;
  for (std::size_t k = 0; k < contacts.net.near.size; ++k)
    if (contacts.net.carrier[k] == i || contacts.net.near.list[k].b == i) return false;
  return true;
}

/// A spring joins a node of the run to one of another carrier.
template <class Net, std::size_t N>
bool joins_carriers(const NetStage<Net, N>& w, const NetRun& run) noexcept {
  for (std::size_t s = 0; s < w.par->num_springs; ++s)
    if (run.holds(w.par->springs[s].i) != run.holds(w.par->springs[s].j)) return true;
  return false;
}

/// (48) of who flies.
template <Scene S, class Flyers>
void give_back_turn(const Params<S>& par, const State<S>& x, const Flyers& flyers, Scratch<S>& w) noexcept {
  const auto before_of = [&](std::size_t i) noexcept -> const RigidBodyState& { return x.bodies[i].x; };
  const auto after_of = [&](std::size_t i) noexcept -> RigidBodyState {
    return lane(w.next[i / lanes<S>].x, i % lanes<S>);
  };
  const Flight before = flight_of(par, flyers, before_of, x.net.nodes),
               after = flight_of(par, flyers, after_of, w.net.next);
  const Vec3 lost = before.L_W - after.L_W;
  if (lost.norm() > max_given_back * before.size) return;
  const Vec3 w_W = solve3<Real>(after.I_W, lost), c = after.centre();
  const auto turn = [&](std::size_t i) noexcept {
    Next<S>& next = w.next[i / lanes<S>];
    const RigidBodyState body = after_of(i);
    set_lane(next.x.v_W, i % lanes<S>, Vec3(body.v_W + w_W.cross(body.X_WB.p - c)));
    set_lane(next.x.w_B, i % lanes<S>, Vec3(body.w_B + to_body<Real>(body.X_WB.q, w_W)));
  };
  flyers.each_body(turn);
  each_node_of(flyers,
               [&](std::uint32_t n) noexcept { w.net.next[n].v_W += w_W.cross(w.net.next[n].p_W - c); });
}

/// (48) of w.next.
template <Scene S>
void keep_angular_momentum(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
  const auto& net = w.contacts.net;
  each_floating(net, [&](const NodeRow& nodes, const RowStage& of) noexcept {
    if (of.flies) give_back_turn(par, x, WithoutCarrier{nodes}, w);
  });
  if (net.attached().empty()) {
    each_carried(net, [&](const NetRun& run) noexcept {
      if (flies(par, w, run.body) && !joins_carriers(net, run)) give_back_turn(par, x, Alone{run}, w);
    });
    return;
  }
  Attached flyers(net);
  each_carried(net, [&](const NetRun& run) noexcept {
    flyers.number = flyers.of[run.body];
    bool fly = !flyers.is_held[flyers.number], is_first = true;
    flyers.each_body([&](std::size_t i) noexcept { fly = fly && flies(par, w, i); });
    flyers.each_run([&](const NetRun& other) noexcept {
      is_first = is_first && other.first >= run.first;
      fly = fly && !joins_carriers(net, other);
    });
    if (fly && is_first) give_back_turn(par, x, flyers, w);
  });
}

}  // namespace godobject
