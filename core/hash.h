// Hash of the whole state, field by field, without padding. Tests of determinism require equal hashes of
// equal runs.
#pragma once

#include <bit>
#include <cstdint>

#include "core/contact/memory.h"
#include "core/device/feedback.h"
#include "core/device/holding.h"
#include "core/integrator_tr_bdf2.h"
#include "core/joint/prescribed.h"
#include "core/joint/stops.h"

namespace godobject {

/// FNV-1a hash over 64-bit words.
class Hash {
 public:
  void add(std::uint64_t word) noexcept { value_ = (value_ ^ word) * 0x100000001b3u; }
  void add(Real a) noexcept { add(std::bit_cast<std::uint64_t>(static_cast<double>(a))); }
  void add(const Vec3& a) noexcept {
    for (const Real c : {a.x(), a.y(), a.z()}) add(c);
  }
  void add(const Quat& q) noexcept {
    for (const Real c : {q.w(), q.x(), q.y(), q.z()}) add(c);
  }
  template <class... A>
  requires(sizeof...(A) > 1) void add(const A&... all) noexcept { (add(all), ...); }
  void add(const Pose& X) noexcept { add(X.p, X.q); }
  void add(const Twist& V) noexcept { add(V.w, V.v); }
  void add(const Wrench& F) noexcept { add(F.tau, F.f); }
  void add(const Target& t) noexcept { add(t.X_WD, t.V_WD); }
  void add(const RigidBodyState& x) noexcept { add(x.X_WB, x.v_W, x.w_B); }
  void add(const TrBdf2::Memory& x) noexcept { add(x.a_W, x.alpha_B, std::uint64_t{x.known}); }
  void add(const RampState& x) noexcept { add(x.s, std::uint64_t{x.engaged}); }
  void add(const DampedSpring::State& x) noexcept { add(x.phi_B); }
  void add(const LimitedFeedback::State& x) noexcept {
    add(x.F_D);
    if (x.force_at_return == 0 && x.torque_at_return == 0) return;  // no gap
    add(x.force_at_return, x.torque_at_return);
  }
  void add(const DeviceState& x) noexcept {
    add(x.last, x.ramp, x.held);
    if (x.F_WB.f != Vec3::Zero() || x.F_WB.tau != Vec3::Zero()) add(x.F_WB);
    if (x.recovery == 0) return;  // no gap
    add(x.recovery, std::uint64_t{x.long_gap});
  }
  void add(const HoldingState& x) noexcept { add(static_cast<const DeviceState&>(x), x.X_DB); }
  template <class J>
  requires requires(const J& x) { x.F_C; }
  void add(const J& x) noexcept {
    add(x.F_C);
    if constexpr (std::is_base_of_v<PrescribedJoints::State, J>)
      add(static_cast<const PrescribedJoints::State&>(x));
    if constexpr (std::is_base_of_v<JointStops::State, J>) add(static_cast<const JointStops::State&>(x));
  }
  void add(const JointStops::State& x) noexcept {
    // the part within a turn follows from the poses
    const Real first = whole_turns(x.q[0]), second = whole_turns(x.q[1]);
    if (first != 0 || second != 0) add(first, second);
    for (const TurnsAhead::About& about : x.ahead.list)
      if (about.turns != 0)
        add(std::uint64_t{about.body}, std::uint64_t{about.rotation}, static_cast<Real>(about.turns));
  }
  void add(const PrescribedJoints::State& x) noexcept {
    for (const JointCoordinates& a : {x.last.q, x.last.q_dot})
      for (const Real c : {a.x(), a.y()}) add(c);
  }
  template <std::size_t max_contacts>
  void add(const ContactMemories<max_contacts>& x) noexcept {
    add(std::uint64_t{x.size});
    for (std::size_t i = 0; i < x.size; ++i) {
      const ContactMemory& m = x.list[i];
      add(m.key, m.e, m.pressed, m.F_n);
      for (const Column& v : {m.c_a, m.c_b, m.n_a, m.n_b, m.n_W, m.xi_a, m.xi_b, m.slip_dot_W}) add(v.vec());
    }
  }
  template <class Memory>
  void add(const NodeStateOf<Memory>& x) noexcept {
    add(x.p_W, x.v_W, x.memory);
  }
  template <int slot>
  void add(const Absent<slot>&) noexcept {}

  std::uint64_t value() const noexcept { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

template <Scene S>
std::uint64_t state_hash(const Params<S>& par, const State<S>& x) noexcept {
  Hash hash;
  hash.add(x.tick);
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const BodyState<S>& body = x.bodies[i];
    hash.add(body.x, body.memory, body.device, body.coupling, body.feedback, body.joint);
  }
  hash.add(x.contacts);
  if constexpr (uses<TermsOf<S>>)
    for (std::size_t t = 0; t < par.terms.size(); ++t) hash.add(x.terms.list[t]);
  if constexpr (uses<NetOf<S>>) {
    for (std::size_t n = 0; n < num_net_nodes(par); ++n) hash.add(x.net.nodes[n]);
    hash.add(x.net.contacts);
  }
  return hash.value();
}

}  // namespace godobject
