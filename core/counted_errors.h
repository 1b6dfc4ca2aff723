// Attitude errors (16) of bodies on joints, with the whole turns by which targets lead their bodies.
//
// The short error phi of a body changes sides at half a turn. A change about an axis a of its joint, or of
// one of its ancestors' joints, changes the count n of that axis by one. The error is then
//
//   (16)  phi + sum 2 pi n grad t,  t: twist of q_BD about a
//
// The sum is the slope of the energy 2 pi n t + (2 pi n)^2 / 2. So neither torque nor energy jumps, and a
// wound spring does no work on a closed path.
#pragma once

#include "core/joint_stage.h"

namespace godobject {

/// Axes of a joint's rotations.
struct TurnAxes {
  std::array<Vec3, 2> a{Vec3::Zero(), Vec3::Zero()};
  std::size_t size = 0;
};
/// Returns the axes of a joint's rotations, world axes.
inline TurnAxes turn_axes(const JointParams& joint, const Quat& q_WP, const Quat& q_WC) noexcept {
  TurnAxes axes;
  with_joint(joint.kind, [&]<class Kind>(Kind) noexcept {
    if constexpr (requires { Kind::coordinates(JointFrames{}); }) {
      const auto m = Kind::motion({.R_WP = q_WP.toRotationMatrix() * joint.P.R,
                                   .R_WC = q_WC.toRotationMatrix() * joint.C.R,
                                   .d_W = Vec3::Zero()});
      for (const Vec3& a_W : m.turn) axes.a[axes.size++] = a_W;
    }
  });
  return axes;
}

/// Twist of a rotation q_BD about an axis: the angle of its part about the axis, beside a part across it.
struct TwistAngle {
  Real angle = 0;              // rad, nearest to that of phi
  Vec3 grad_B = Vec3::Zero();  // angle by which the twist falls per turn of the body
};

/// Returns the twist of q_BD about a_B. phi_B: error whose turns the twist has. is_on_body: true if the axis
/// turns with the body, false if with its parent.
inline TwistAngle twist_angle(const Quat& q_BD, const Vec3& a_B, const Vec3& phi_B,
                              bool is_on_body) noexcept {
  const Real w = q_BD.w(), along = a_B.dot(q_BD.vec());
  const Real share = std::max(w * w + along * along, min_twist_share);
  const Vec3 across = w * q_BD.vec().cross(a_B);
  return {.angle = unwrapped(2 * angle_of(along, w), a_B.dot(phi_B)),
          .grad_B = (w * w * a_B + along * q_BD.vec() + (is_on_body ? across : Vec3(-across))) * (1 / share)};
}

/// Contribution of counted turns to the coupling of a body.
struct CountedTurns {
  Vec3 turns_B = Vec3::Zero();  // sum in the error (16), rad
  Real energy = 0;              // energy of a spring of 1 N m/rad beyond phi^2 / 2, rad^2
};

/// Counts whole turns of errors. Errors has attitudes q_WB(i) of bodies and q_WD(i) of targets, errors phi(i)
/// and before(i), turns(i), and is_coupled(i).
///
/// A body's path is its joint and those before it, up to the world or to a body whose turns are not counted.
/// Such a body is free or on a ball joint. Its error is the reference of the others.
template <Scene S, class Errors>
class TurnCounter {
 public:
  TurnCounter(const Params<S>& par, Errors errors) noexcept : par_(par), errors_(errors) {}

  /// Updates the turns of body i, and the side of its error, after those of its ancestors.
  void count(std::size_t i) noexcept {
    TurnsAhead& turns = errors_.turns(i);
    const std::size_t r = end_of_path(i);
    if (!errors_.is_coupled(i) || r == i) {
      turns = {};
      return;
    }
    const Quat q_WB = errors_.q_WB(i);
    Quat q_BD = q_WB.conjugate() * errors_.q_WD(i);  // against the reference
    Vec3 phi_R = Vec3::Zero(), before = errors_.before(i);
    if (r != world && errors_.is_coupled(r)) {
      const Quat q_BR = q_WB.conjugate() * errors_.q_WB(r);
      phi_R = to_world(q_BR, errors_.phi(r));
      before -= to_world(q_BR, errors_.before(r));
      q_BD = q_BR * (errors_.q_WD(r).conjugate() * errors_.q_WB(r)) * q_BR.conjugate() * q_BD;
      errors_.set_phi(i, on_side_of(phi_R, before, errors_.phi(i)));
    }
    drop_untwisted(i, q_BD, turns);
    const Vec3 jump = before - (errors_.phi(i) - phi_R);
    if (jump.squaredNorm() > pi * pi) flip(i, jump, turns);
  }

  /// Returns the contribution of the turns of body i.
  CountedTurns counted(std::size_t i) const noexcept {
    CountedTurns sum;
    Vec3 all_B = Vec3::Zero();
    const Quat q_BD = errors_.q_WB(i).conjugate() * errors_.q_WD(i);
    for (const About& about : errors_.turns(i).list) {
      if (about.turns == 0) continue;
      const Real angle = 2 * pi * static_cast<Real>(about.turns);
      const TurnAxes axes = axes_of(about.body, i);
      const Vec3& a_B = axes.a[about.rotation];
      const bool is_on_body = about.body == i && about.rotation + 1u == axes.size;
      const TwistAngle twist = twist_angle(q_BD, a_B, errors_.phi(i), is_on_body);
      sum.turns_B += angle * twist.grad_B;
      sum.energy += angle * twist.angle;
      all_B += angle * a_B;
    }
    sum.energy += Real(0.5) * all_B.squaredNorm();
    return sum;
  }

 private:
  using About = TurnsAhead::About;

  /// Returns the number of the body at the end of the path of body i.
  std::size_t end_of_path(std::size_t i) const noexcept {
    while (i != world) {
      const JointParams& joint = par_.bodies[i].joint;
      if (joint.kind == JointKind::free || num_axes(joint.kind).turns == 3) return i;
      i = joint.parent;
    }
    return i;
  }

  /// Returns the axes of the joint of body j in the axes of body i.
  TurnAxes axes_of(std::size_t j, std::size_t i) const noexcept {
    const JointParams& joint = par_.bodies[j].joint;
    const Quat q_WP = joint.parent == world ? Quat(Quat::Identity()) : errors_.q_WB(joint.parent);
    TurnAxes axes = turn_axes(joint, q_WP, errors_.q_WB(j));
    const Quat q_WB = errors_.q_WB(i);
    for (Vec3& a : axes.a) a = to_body(q_WB, a);
    return axes;
  }

  /// Drops turns about axes about which the rotation q_BD of body i has no twist.
  void drop_untwisted(std::size_t i, const Quat& q_BD, TurnsAhead& turns) const noexcept {
    for (About& about : turns.list) {
      if (about.turns == 0) continue;
      const Real along = axes_of(about.body, i).a[about.rotation].dot(q_BD.vec());
      if (q_BD.w() * q_BD.w() + along * along < min_twist_share) about = {};
    }
  }

  /// Counts a change of side of the error of body i by -jump. It takes a turn back if there is one, else it
  /// adds one about the nearest axis of the path. Farther than 60 degrees from all axes it is not counted.
  void flip(std::size_t i, const Vec3& jump, TurnsAhead& turns) const noexcept {
    Real most = pi;
    About* found = nullptr;
    for (About& about : turns.list) {
      if (about.turns == 0) continue;
      const Real along = axes_of(about.body, i).a[about.rotation].dot(jump);
      if ((along > 0) == (about.turns > 0) || !(std::abs(along) > most)) continue;
      most = std::abs(along);
      found = &about;
    }
    if (found != nullptr) {
      found->turns = static_cast<std::int16_t>(found->turns + (found->turns > 0 ? -1 : 1));
      return;
    }
    About nearest;
    for (std::size_t j = i, end = end_of_path(i); j != end; j = par_.bodies[j].joint.parent) {
      const TurnAxes axes = axes_of(j, i);
      for (std::size_t c = 0; c < axes.size; ++c) {
        const Real along = axes.a[c].dot(jump);
        if (!(std::abs(along) > most)) continue;
        most = std::abs(along);
        nearest = {static_cast<std::uint16_t>(j), static_cast<std::uint16_t>(c),
                   static_cast<std::int16_t>(along > 0 ? 1 : -1)};
      }
    }
    for (About& about : turns.list) {
      const bool is_same = about.body == nearest.body && about.rotation == nearest.rotation;
      if (about.turns != 0 && is_same) found = &about;
      if (about.turns == 0 && found == nullptr) found = &about;
    }
    if (found == nullptr) return;
    nearest.turns = static_cast<std::int16_t>(nearest.turns + found->turns);
    *found = nearest;
  }

  /// Returns the error phi_B, or that of the other way round, whichever is nearer to the reference phi_R.
  /// Their difference keeps its side near the half turn. before: previous difference.
  static Vec3 on_side_of(const Vec3& phi_R, const Vec3& before, const Vec3& phi_B) noexcept {
    const Real angle = phi_B.norm();
    if (!(angle > 0)) return phi_B;
    const Vec3 u = phi_B * (1 / angle);
    const Real beyond = u.dot(phi_B - phi_R);
    const Real kept = whole_turns(beyond - u.dot(before));
    const bool keeps = std::abs(beyond - 2 * pi * kept) <= pi + 2 * half_turn_band;
    return phi_B - (2 * pi * (keeps ? kept : whole_turns(beyond))) * u;
  }

  const Params<S>& par_;
  Errors errors_;
};

/// Squared size of errors that may need counting, rad^2: two of them add up to half a turn.
inline constexpr Real large_error_sq = pi * pi / 4;

/// Error of a coupling.
struct CouplingError {
  Vec3 phi_B = Vec3::Zero();  // (16), body axes, rad
  Real twice_energy = 0;      // of a spring of 1 N m/rad, rad^2
};

/// Errors of the couplings of a scene whose joints count no turns.
template <Scene S, class AttitudeOfBody, class TargetOfBody>
struct ShortErrors {
  const State<S>& x;
  AttitudeOfBody attitude_of;
  TargetOfBody target_of;

  CouplingError operator[](std::size_t i) const noexcept {
    const Vec3 phi_B = rotation_error(attitude_of(i), target_of(i), x.bodies[i].coupling.phi_B).phi_B;
    return {.phi_B = phi_B, .twice_energy = phi_B.squaredNorm()};
  }
};

/// Errors of the couplings of a scene whose joints count their turns.
template <Scene S>
class CountedErrors {
 public:
  template <class AttitudeOfBody, class TargetOfBody>
  CountedErrors(const Params<S>& par, const State<S>& x, const AttitudeOfBody& attitude_of,
                const TargetOfBody& target_of) noexcept {
    bool are_large = false;
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      errors_[i] = ShortErrors<S, AttitudeOfBody, TargetOfBody>{x, attitude_of, target_of}[i];
      are_large = are_large || errors_[i].twice_energy > large_error_sq || x.bodies[i].joint.ahead.any();
    }
    if (are_large) [[unlikely]]
      count(par, x, attitude_of, target_of);
  }

  const CouplingError& operator[](std::size_t i) const noexcept { return errors_[i]; }

 private:
  using AllTurns = std::array<TurnsAhead, S::max_bodies>;

  template <class AttitudeOfBody, class TargetOfBody>
  [[gnu::noinline]] void count(const Params<S>& par, const State<S>& x, const AttitudeOfBody& attitude_of,
                               const TargetOfBody& target_of) noexcept {
    struct Errors {
      const Params<S>& par;
      const State<S>& x;
      CountedErrors& all;
      AllTurns& counts;
      const AttitudeOfBody& attitude_of;
      const TargetOfBody& target_of;

      Quat q_WB(std::size_t i) const noexcept { return attitude_of(i); }
      Quat q_WD(std::size_t i) const noexcept { return target_of(i); }
      Vec3 phi(std::size_t i) const noexcept { return all.errors_[i].phi_B; }
      Vec3 before(std::size_t i) const noexcept { return x.bodies[i].coupling.phi_B; }
      TurnsAhead& turns(std::size_t i) const noexcept { return counts[i]; }
      bool is_coupled(std::size_t i) const noexcept {
        return par.bodies[i].coupling.k_r > 0 && x.bodies[i].device.ramp.engaged;
      }
      void set_phi(std::size_t i, const Vec3& phi_B) const noexcept { all.errors_[i].phi_B = phi_B; }
    };
    AllTurns counts;
    for (std::size_t i = 0; i < num_bodies(par); ++i) counts[i] = x.bodies[i].joint.ahead;
    TurnCounter<S, Errors> counter(par, {par, x, *this, counts, attitude_of, target_of});
    for (std::size_t i = 0; i < num_bodies(par); ++i) counter.count(i);
    std::array<CountedTurns, S::max_bodies> counted;
    for (std::size_t i = 0; i < num_bodies(par); ++i) counted[i] = counter.counted(i);
    for (std::size_t i = 0; i < num_bodies(par); ++i) {
      CouplingError& error = errors_[i];
      error.twice_energy = error.phi_B.squaredNorm() + 2 * counted[i].energy;
      error.phi_B += counted[i].turns_B;
    }
  }

  std::array<CouplingError, S::max_bodies> errors_;
};

/// Returns the errors (16) of a scene's couplings. x: state with the errors before. attitude_of(i),
/// target_of(i): attitudes q_WB and q_WD of body i.
template <Scene S, class AttitudeOfBody, class TargetOfBody>
auto coupling_errors(const Params<S>& par, const State<S>& x, const AttitudeOfBody& attitude_of,
                     const TargetOfBody& target_of) noexcept {
  if constexpr (counts_errors<S>) return CountedErrors<S>(par, x, attitude_of, target_of);
  else return ShortErrors<S, AttitudeOfBody, TargetOfBody>{x, attitude_of, target_of};
}
template <Scene S>
auto coupling_errors(const Params<S>& par, const State<S>& x) noexcept {
  return coupling_errors<S>(
      par, x, [&x](std::size_t i) -> const Quat& { return x.bodies[i].x.X_WB.q; },
      [&x](std::size_t i) -> const Quat& { return x.bodies[i].device.last.X_WD.q; });
}

}  // namespace godobject
