// Attitude errors (16) of bodies on joints, with the whole turns by which targets lead their bodies.
//
// The short error phi changes sides at half a turn. If it does so about an axis a of a joint, the joint's
// count n changes by one. The error of the joint's child and of all its descendants is
//
//   (16)  phi + sum 2 pi n grad t,  t: twist of q_BD about a
//
// The sum is the slope of the energy 2 pi n t + (2 pi n)^2 / 2. So neither torque nor energy jumps, and a
// wound spring does no work on a closed path.
#pragma once

#include "core/joint_stage.h"

namespace godobject {

/// True if couplings act on bodies whose joints count their turns.
template <class S>
inline constexpr bool counts_errors = counts_turns<S>&& uses<typename S::Coupling>;

/// Axes of a joint's rotations, world axes.
struct TurnAxes {
  std::array<Vec3, 2> a_W;
  std::size_t size = 0;
};
inline TurnAxes turn_axes(const JointParams& joint, const Quat& q_WP, const Quat& q_WC) noexcept {
  TurnAxes axes;
  with_joint(joint.kind, [&]<class Kind>(Kind) noexcept {
    if constexpr (requires { Kind::coordinates(JointFrames{}); }) {
      const auto m = Kind::motion({.R_WP = q_WP.toRotationMatrix() * joint.P.R,
                                   .R_WC = q_WC.toRotationMatrix() * joint.C.R,
                                   .d_W = Vec3::Zero()});
      for (const Vec3& a_W : m.turn) axes.a_W[axes.size++] = a_W;
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
/// and before(i), counts turns(i) by joint coordinate, and is_coupled(i).
template <Scene S, class Errors>
class TurnCounter {
 public:
  TurnCounter(const Params<S>& par, Errors errors) noexcept : par_(par), errors_(errors) {}

  /// Updates the side of the error of body i, and the counts of its joint. Parents before children.
  void count(std::size_t i) noexcept {
    const JointParams& joint = par_.bodies[i].joint;
    JointCoordinates& turns = errors_.turns(i);
    if (joint.kind == JointKind::free || !errors_.is_coupled(i)) {
      turns.setZero();
      return;
    }
    const std::size_t p = joint.parent;
    const bool has_error = p != world && errors_.is_coupled(p);  // of the parent
    const Quat q_WB = errors_.q_WB(i), q_WP = attitude(p);
    const Quat q_BP = q_WB.conjugate() * q_WP;
    Quat q_BD = q_WB.conjugate() * errors_.q_WD(i);  // of the joint, without the parent's error
    Vec3 phi_P = Vec3::Zero(), before = errors_.before(i);
    if (has_error) {
      phi_P = to_world(q_BP, errors_.phi(p));
      before -= to_world(q_BP, errors_.before(p));
      q_BD = q_BP * (errors_.q_WD(p).conjugate() * q_WP) * q_BP.conjugate() * q_BD;
      errors_.set_phi(i, on_side_of(phi_P, before, errors_.phi(i)));
    }
    const Vec3 jump = before - (errors_.phi(i) - phi_P);
    const TurnAxes axes = turn_axes(joint, q_WP, q_WB);
    std::array<Real, 2> along{};
    Real share = q_BD.w() * q_BD.w();
    for (std::size_t c = 0; c < axes.size; ++c) {
      const Vec3 a_B = to_body(q_WB, axes.a_W[c]);
      along[c] = a_B.dot(jump);
      share += a_B.dot(q_BD.vec()) * a_B.dot(q_BD.vec());
    }
    const std::size_t c = std::abs(along[1]) > std::abs(along[0]) ? 1 : 0;
    turns[static_cast<Eigen::Index>(c)] += whole_turns(along[c]);
    if (share < min_twist_share) turns.setZero();
  }

  /// Returns the contribution of the turns of the joint of body i and of its ancestors' joints.
  CountedTurns counted(std::size_t i) const noexcept {
    CountedTurns sum;
    Vec3 all_B = Vec3::Zero();
    const Quat q_WB = errors_.q_WB(i), q_BD = q_WB.conjugate() * errors_.q_WD(i);
    for (std::size_t j = i; j != world && errors_.is_coupled(j); j = par_.bodies[j].joint.parent) {
      const JointParams& joint = par_.bodies[j].joint;
      if (joint.kind == JointKind::free) break;
      const JointCoordinates& turns = errors_.turns(j);
      if (turns == JointCoordinates::Zero()) continue;
      const TurnAxes axes = turn_axes(joint, attitude(joint.parent), attitude(j));
      for (std::size_t c = 0; c < axes.size; ++c) {
        const Real angle = 2 * pi * turns[static_cast<Eigen::Index>(c)];
        const Vec3 a_B = to_body(q_WB, axes.a_W[c]);
        const TwistAngle twist = twist_angle(q_BD, a_B, errors_.phi(i), j == i && c + 1 == axes.size);
        sum.turns_B += angle * twist.grad_B;
        sum.energy += angle * twist.angle;
        all_B += angle * a_B;
      }
    }
    sum.energy += Real(0.5) * all_B.squaredNorm();
    return sum;
  }

 private:
  /// Returns the attitude of body i or the world.
  Quat attitude(std::size_t i) const noexcept {
    if (i == world) return Quat::Identity();
    return errors_.q_WB(i);
  }

  /// Returns the error phi_B, or that of the other way round, whichever is nearer to the parent's error
  /// phi_P. Their difference keeps its side near the half turn. before: previous difference.
  static Vec3 on_side_of(const Vec3& phi_P, const Vec3& before, const Vec3& phi_B) noexcept {
    const Real angle = phi_B.norm();
    if (!(angle > 0)) return phi_B;
    const Vec3 u = phi_B * (1 / angle);
    const Real beyond = u.dot(phi_B - phi_P);
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
      turns_[i] = x.bodies[i].joint.turns_ahead;
      are_large =
          are_large || errors_[i].twice_energy > large_error_sq || turns_[i] != JointCoordinates::Zero();
    }
    if (are_large) [[unlikely]]
      count(par, x, attitude_of, target_of);
  }

  const CouplingError& operator[](std::size_t i) const noexcept { return errors_[i]; }

 private:
  template <class AttitudeOfBody, class TargetOfBody>
  [[gnu::noinline]] void count(const Params<S>& par, const State<S>& x, const AttitudeOfBody& attitude_of,
                               const TargetOfBody& target_of) noexcept {
    struct Errors {
      const Params<S>& par;
      const State<S>& x;
      CountedErrors& all;
      const AttitudeOfBody& attitude_of;
      const TargetOfBody& target_of;

      Quat q_WB(std::size_t i) const noexcept { return attitude_of(i); }
      Quat q_WD(std::size_t i) const noexcept { return target_of(i); }
      Vec3 phi(std::size_t i) const noexcept { return all.errors_[i].phi_B; }
      Vec3 before(std::size_t i) const noexcept { return x.bodies[i].coupling.phi_B; }
      JointCoordinates& turns(std::size_t i) const noexcept { return all.turns_[i]; }
      bool is_coupled(std::size_t i) const noexcept {
        return par.bodies[i].coupling.k_r > 0 && x.bodies[i].device.ramp.engaged;
      }
      void set_phi(std::size_t i, const Vec3& phi_B) const noexcept { all.errors_[i].phi_B = phi_B; }
    };
    TurnCounter<S, Errors> counter(par, {par, x, *this, attitude_of, target_of});
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
  std::array<JointCoordinates, S::max_bodies> turns_;
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
