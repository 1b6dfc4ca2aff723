// Before the first step: derived constants, checks of the parameters, the first state.
#pragma once

#include <Eigen/Eigenvalues>

#include "core/device.h"
#include "core/feedback.h"
#include "core/tree.h"

namespace godobject {

/// The first rule a parameter set breaks.
enum class Invalid : std::uint8_t {
  nothing,
  step_not_positive,
  too_many_bodies,  // more than the scene's max_bodies, or none
  mass_not_positive,
  inertia_not_positive,  // not symmetric, or an eigenvalue not above zero
  anisotropy_too_small,  // below sqrt(I_max / I_min): make the parameters with rigid_body()
  gain_negative,         // a stiffness, damping, limit or ramp below zero or not finite
  parent_not_before,     // a joint's parent is not a body before its child
  joint_frame,           // a joint's frame is not finite or not a rotation
  stop,                  // a stop with its ends crossed, beyond a half turn, negative gains or no width
  not_imposable,         // an imposed joint of a kind without coordinates of its own: free, fixed or ball
};

/// Principal moments of inertia, ascending.
inline Vec3 principal_moments(const Mat3& I_B) noexcept {
  return Eigen::SelfAdjointEigenSolver<Mat3>(I_B, Eigen::EigenvaluesOnly).eigenvalues();
}

/// Fills in what is derived from mass and inertia.
inline RigidBodyParams rigid_body(Real m, const Mat3& I_B) noexcept {
  const Vec3 moments = principal_moments(I_B);
  return {.m = m, .I_B = I_B, .anisotropy = std::sqrt(moments.z() / moments.x())};
}

inline bool is_gain(Real a) noexcept { return a >= 0 && a - a == 0; }
template <int slot>
bool is_valid(const Absent<slot>&) noexcept {
  return true;
}
inline bool is_valid(const RampParams& par) noexcept { return is_gain(par.rise) && is_gain(par.lost); }
inline bool is_valid(const SpringParams& par) noexcept {
  return is_gain(par.k) && is_gain(par.g) && is_gain(par.k_r) && is_gain(par.g_r);
}
inline bool is_valid(const FeedbackParams& par) noexcept {
  return is_valid(par.gains) && is_gain(par.max_force) && is_gain(par.max_torque) &&
         is_gain(par.max_force_rate) && is_gain(par.max_torque_rate);
}

inline bool is_valid(const JointFrame& X) noexcept {
  const Real off = (X.R.transpose() * X.R - Mat3::Identity()).norm() + std::abs(X.R.determinant() - 1);
  return off <= Real(1e-9) && X.p.sum() - X.p.sum() == 0;
}
/// turn: the coordinate is an angle.
inline bool is_valid(const StopParams& par, bool turn) noexcept {
  constexpr Real open = std::numeric_limits<Real>::infinity();
  const bool none = par.lower == -open && par.upper == open;
  const bool half_turn =
      !turn || ((par.lower >= -pi || par.lower == -open) && (par.upper <= pi || par.upper == open));
  return none || (par.lower <= par.upper && half_turn && is_gain(par.k) && is_gain(par.g) && par.width > 0);
}

/// The joint of body i.
template <class Joints>
Invalid validate_joint(const typename Joints::Params& par, std::size_t i) noexcept {
  if (par.kind == JointKind::free) return Invalid::nothing;
  if (par.parent != world && par.parent >= i) return Invalid::parent_not_before;
  if (!is_valid(par.P) || !is_valid(par.C)) return Invalid::joint_frame;
  const int turns = num_axes(par.kind).turns;
  bool coordinates = false;
  with_joint(par.kind, [&](auto kind) {
    coordinates = requires { kind.coordinates(JointFrames{}); };
  });
  if constexpr (uses<typename Joints::Stops>) {
    for (int c = 0; coordinates && c < 2; ++c)
      if (!is_valid(par.stop.stops[static_cast<std::size_t>(c)], c < turns)) return Invalid::stop;
  }
  if constexpr (uses<typename Joints::Imposed>) {
    if (par.lead.imposed && !coordinates) return Invalid::not_imposable;
  }
  return Invalid::nothing;
}

template <Scene S>
Invalid validate(const Params<S>& par) noexcept {
  if (!(par.h > 0 && par.h - par.h == 0)) return Invalid::step_not_positive;
  if (par.num_bodies < 1 || par.num_bodies > S::max_bodies) return Invalid::too_many_bodies;
  for (std::size_t i = 0; i < num_bodies(par); ++i) {
    const BodyParams<S>& b = par.bodies[i];
    const Mat3& I = b.body.I_B;
    if (!(b.body.m > 0 && b.body.m - b.body.m == 0)) return Invalid::mass_not_positive;
    if (!((I - I.transpose()).norm() <= Real(1e-9) * I.norm() && principal_moments(I).x() > 0))
      return Invalid::inertia_not_positive;
    const Vec3 moments = principal_moments(I);
    if (!(b.body.anisotropy * b.body.anisotropy * moments.x() >= Real(0.999) * moments.z()))
      return Invalid::anisotropy_too_small;
    if (!is_valid(b.coupling) || !is_valid(b.feedback) || !is_valid(b.device)) return Invalid::gain_negative;
    if constexpr (uses<typename S::Joints>) {
      const Invalid joint = validate_joint<typename S::Joints>(b.joint, i);
      if (joint != Invalid::nothing) return joint;
    }
  }
  return Invalid::nothing;
}

/// The state before the first step: bodies where they are put, at rest or moving, devices released.
struct Start {
  Pose X_WB;
  Twist V_WB;
};

template <Scene S>
void place(State<S>& x, std::size_t i, const Start& start) noexcept {
  RigidBodyState& body = x.bodies[i].x;
  body.X_WB = {.p = start.X_WB.p, .q = start.X_WB.q.normalized()};
  body.v_W = start.V_WB.v;
  body.w_B = to_body(body.X_WB.q, start.V_WB.w);
}

/// Starts body i engaged, with the device's sample at the start of the first step: no ramp, no step missing.
template <Scene S>
void engage_at(State<S>& x, std::size_t i, const Target& sample) noexcept {
  auto& device = x.bodies[i].device;
  device.last = sample;
  device.last.X_WD.q = sample.X_WD.q.normalized();
  device.ramp = {.s = 1, .engaged = true};
}

}  // namespace godobject
