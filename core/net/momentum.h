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

/// What the carrier of a run and its nodes are as one.
template <Scene S, class Nodes>
Flight flight_of(const Params<S>& par, const NetRun& run, const RigidBodyState& body,
                 const Nodes& nodes) noexcept {
  Flight all{.m = par.bodies[run.body].body.m, .mp_W = par.bodies[run.body].body.m * body.X_WB.p};
  for (std::uint32_t n = run.first; n < run.end; ++n) {
    all.m += par.net.nodes[n].m;
    all.mp_W += par.net.nodes[n].m * nodes[n].p_W;
  }
  all.add(par.bodies[run.body].body, body);
  for (std::uint32_t n = run.first; n < run.end; ++n)
    all.add(par.net.nodes[n].m, nodes[n].p_W - all.centre(), nodes[n].v_W);
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
  for (std::uint32_t s = 0; s < w.first_of[w.num_nodes]; ++s)
    if ((w.first_of[run.first] <= s && s < w.first_of[run.end]) != run.holds(w.other[s])) return true;
  return false;
}

/// (48) of w.next.
template <Scene S>
void keep_angular_momentum(const Params<S>& par, const State<S>& x, Scratch<S>& w) noexcept {
  const auto& net = w.contacts.net;
  each_carried(net, [&](const NetRun& run) noexcept {
    if (!flies(par, w, run.body) || joins_carriers(net, run)) return;
    Next<S>& next = w.next[run.body / lanes<S>];
    const std::size_t j = run.body % lanes<S>;
    const RigidBodyState body = lane(next.x, j);
    const Flight before = flight_of(par, run, x.bodies[run.body].x, x.net.nodes),
                 after = flight_of(par, run, body, w.net.next);
    const Vec3 lost = before.L_W - after.L_W;
    if (lost.norm() > max_given_back * before.size) return;
    const Vec3 w_W = solve3<Real>(after.I_W, lost), c = after.centre();
    set_lane(next.x.v_W, j, Vec3(body.v_W + w_W.cross(body.X_WB.p - c)));
    set_lane(next.x.w_B, j, Vec3(body.w_B + to_body<Real>(body.X_WB.q, w_W)));
    for (std::uint32_t n = run.first; n < run.end; ++n) w.net.next[n].v_W += w_W.cross(w.net.next[n].p_W - c);
  });
}

}  // namespace godobject
