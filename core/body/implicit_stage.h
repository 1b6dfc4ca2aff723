// Linearly implicit Euler stage of a rigid body on its spring: the kernel of every integrator.
//
// It discretises (3), that is Newton-Euler (1) with the coupling (2). A stage starts from a base: pose X^,
// velocities v^, w^. It computes the velocities v+, w+ of the motion over a time h, with forces at the end of
// the stage, linearised once:
//
//   (10)  m (v+ - v^)   = h ( F_W + g (v_D - v+) + k (p_D - p^ - h v+) )
//   (11)  I (w+ - w^)   = h ( T_B + g_r (w_D - w+) + k_r (phi - h J w+) - w x I w )
//
// Both are linear in the unknown. While the target rests, a stage never adds energy, for any step length and
// stiffness. Proof: docs/theory/stage.md; sweep: tests/core/test_stability.cc.
#pragma once

#include "core/body/coupling.h"
#include "core/body/rigid_body.h"

namespace godobject {

/// Returns the largest rotation of a body in an extrapolated step of TrBdf2, rad, so that the gyroscopic term
/// is resolved. It is smaller for couplings without damping, which would keep a step's energy gain.
inline Real max_extrapolated_turn_of(const RigidBodyParams& body, const SpringParams& coupling,
                                     bool with_nets) noexcept {
  if (coupling.k_r > 0 && !(coupling.g_r > 0)) return max_swing / body.anisotropy;
  return with_nets ? std::min(body.max_turn, max_carrier_turn) : body.max_turn;
}

/// Velocities of a body during a stage.
template <class T>
struct StageVelocityOf {
  Vector3<T> v_W = Vector3<T>::Zero();
  Vector3<T> w_B = Vector3<T>::Zero();
};
using StageVelocity = StageVelocityOf<Real>;

/// Solves A x = b by cofactors. A: 3 x 3, regular; one division.
template <class T = Real>
Vector3<T> solve3(const Matrix3<T>& A, const Vector3<T>& b) noexcept {
  const Vector3<T> a0 = A.col(0), a1 = A.col(1), a2 = A.col(2);
  const Vector3<T> c0 = a1.cross(a2), c1 = a2.cross(a0), c2 = a0.cross(a1);
  return Vector3<T>(c0.dot(b), c1.dot(b), c2.dot(b)) * T(1 / a0.dot(c0));
}

/// Translational system (10) as M v+ = b, world axes.
template <class T>
struct TranslationSystemOf {
  T M = 1;
  Vector3<T> b_W = Vector3<T>::Zero();
};
using TranslationSystem = TranslationSystemOf<Real>;

/// Rotational system (11) as A w+ = b, body axes.
template <class T>
struct RotationSystemOf {
  Matrix3<T> A_B = Matrix3<T>::Identity();
  Vector3<T> b_B = Vector3<T>::Zero();
  Vector3<T> hw_B = Vector3<T>::Zero();  // rho h w^ of the gyroscopic term, rad
};
using RotationSystem = RotationSystemOf<Real>;

/// Returns (m + h g + h^2 k) v+ = m v^ + h (F_W + g v_D + k e).
template <class T>
TranslationSystemOf<T> implicit_translation(const std::type_identity_t<T>& m, const SpringParamsOf<T>& spring,
                                            const Vector3<T>& v_W, const Vector3<T>& e_W,
                                            const Vector3<T>& v_D, const Vector3<T>& F_W, Real h) noexcept {
  const T hk = h * spring.k;
  return {.M = m + h * (spring.g + hk), .b_W = m * v_W + h * (F_W + spring.g * v_D) + hk * e_W};
}

/// Axes of a stage (11): the body's at its end, or at its middle (64). Angular velocity has the same
/// coordinates in both. In axes of the middle the spring has no skew part, w_D and T turn half as far, and
/// the Newton term of w x I w is halved.
enum class TorqueAxes : std::uint8_t { end, middle };

/// Returns the rotational system in body axes. With L = I w^, the terms of (11) linearised in w+ are:
///   gyroscopic    w x I w    ->  w+ x L                    (never does work on w+)
///                                + rho w^ x (I w+ - L)     (makes it Newton's: second order)
///   spring        log        ->  phi - h J w+,  J = 1 - [phi]x / 2 + c [phi]x^2
///   damping       R+^T w_D   ->  w_D + h w_D x w+
///   torque        R+^T T_W   ->  T + h T x w+
/// rho = 1 unless a step turns the body so far that the Newton term could do work.
template <TorqueAxes axes = TorqueAxes::end, class T>
RotationSystemOf<T> implicit_rotation(const RigidBodyParamsOf<T>& body, const SpringParamsOf<T>& spring,
                                      const Vector3<T>& w_B, const RotationErrorOf<T>& error,
                                      const Vector3<T>& w_D_B, const Vector3<T>& T_B, Real h) noexcept {
  const Vector3<T>& phi = error.phi_B;
  const Vector3<T> L = body.I_B * w_B;
  const T hk = h * spring.k_r;

  // rho h |w| sqrt(I_max / I_min) <= 1/2
  const T swing_sq =
      1 / (max_swing * max_swing) * h * h * body.anisotropy * body.anisotropy * w_B.squaredNorm();
  const T rho = select(swing_sq <= 1, T(1), T(1 / swing_sq));
  const Vector3<T> hw = T(rho * (axes == TorqueAxes::end ? h : Real(0.5) * h)) * w_B;

  // A = I + h (g_r + h k_r) 1 + [hw]x I - [turn]x + h^2 k_r c [phi]x^2,  [phi]x^2 = phi phi^T - |phi|^2 1
  Vector3<T> turn;
  if constexpr (axes == TorqueAxes::end)
    turn = h * (L + T(Real(0.5) * hk) * phi + T(h * spring.g_r) * w_D_B + h * T_B);
  else turn = h * (L + T(Real(0.5) * h * spring.g_r) * w_D_B + (Real(0.5) * h) * T_B);
  const Vector3<T> bent = T(h * hk * error.curvature) * phi;
  const T diagonal = h * (spring.g_r + hk) - bent.dot(phi);
  RotationSystemOf<T> system{.hw_B = hw};
  Matrix3<T>& A = system.A_B;
  for (int j = 0; j < 3; ++j) A.col(j) = body.I_B.col(j) + hw.cross(body.I_B.col(j)) + phi[j] * bent;
  A += skew<T>(-turn);
  A.diagonal().array() += diagonal;
  system.b_B = L + hw.cross(L) + h * (T_B + spring.g_r * w_D_B) + hk * phi;
  return system;
}

/// Adds the torque k_r turns_B of counted turns (16) to the system. Its axis lies midway between those of
/// body and target, so in axes of the end its derivative is skew, as the [phi]x / 2 of (11).
template <TorqueAxes axes, class T>
void add_turns(const SpringParamsOf<T>& spring, const Vector3<T>& turns_B, Real h,
               RotationSystemOf<T>& system) noexcept {
  const Vector3<T> impulse = T(h * spring.k_r) * turns_B;
  if constexpr (axes == TorqueAxes::end) system.A_B += skew<T>(T(Real(-0.5) * h) * impulse);
  system.b_B += impulse;
}

}  // namespace godobject
