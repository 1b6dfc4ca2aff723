// Angular momentum of a body over a stage with contacts.
//
// A stage (11) is in axes of the body's attitude R_m, predicted for the middle of the stage. There the
// gyroscopic term is w+ x (I w+ + I w^) / 2, to third order. Its linear solution w+ turns the body and gives
// the torques. Their impulse J in world axes gives the angular velocity at the end,
//
//   (64)  R+ I w = R^ I w^ + J,   J = R_m ( I (w+ - w^) + h w x I w )
//
// Without a coupling, J is the impulse of the reported contact torques. Jointed bodies keep w+, which obeys
// the joints; their momentum has errors of third order.
#pragma once

#include "core/body/implicit_stage.h"

namespace godobject {

/// Impulse of the torques of a stage as a function of w+. Vectors are in axes of R_m.
template <class T>
struct StageImpulseOf {
  Quaternion<T> q_WM = Quaternion<T>::Identity();  // R_m
  Vector3<T> hw_B = Vector3<T>::Zero();            // rho h w^ / 2, rad
  Vector3<T> L_B = Vector3<T>::Zero();             // I w^, N m s
  T twice_energy = 0;                              // w^ . I w^, J
  Vector3<T> skew_B = Vector3<T>::Zero();          // skew part of the gyroscopic term
  Vector3<T> turn_B = Vector3<T>::Zero();          // angular velocity on which it acts (34), rad/s
  T is_joined = 0;                                 // 1: joints determine the angular velocity at the end

  /// Returns the impulse, N m s.
  Vector3<T> at(const Matrix3<T>& I_B, const Vector3<T>& w_B) const noexcept {
    const Vector3<T> L = I_B * w_B;
    const Vector3<T> bent = hw_B.cross(L) - I_B * hw_B.cross(w_B);
    return L - L_B + T(Real(0.5)) * bent + skew_B.cross(turn_B) - hw_B.cross(L_B);
  }
};

/// Returns the impulse of a stage from w^ and R_m, without turn_B. hw_B: as of implicit_rotation().
template <class T>
StageImpulseOf<T> stage_impulse(const Matrix3<T>& I_B, const Vector3<T>& w_B, const Vector3<T>& hw_B,
                                const Quaternion<T>& q_WM, Real h) noexcept {
  const Vector3<T> L_B = I_B * w_B;
  return {.q_WM = q_WM,
          .hw_B = hw_B,
          .L_B = L_B,
          .twice_energy = L_B.dot(w_B),
          .skew_B = T(Real(0.5)) * Vector3<T>(I_B.trace() * hw_B - I_B * hw_B) - T(h) * L_B};
}

/// Returns w+ of (11) without torques, body axes. The skew part of the gyroscopic term does no work on it.
template <class T>
Vector3<T> torque_free_turn(const Matrix3<T>& I_B, const StageImpulseOf<T>& J, Real h) noexcept {
  Matrix3<T> A;
  for (int j = 0; j < 3; ++j) A.col(j) = I_B.col(j) + J.hw_B.cross(I_B.col(j));
  A += skew<T>(-h * J.L_B);
  return solve3<T>(A, Vector3<T>(J.L_B + J.hw_B.cross(J.L_B)));
}

/// Returns the angular momentum R I w about the centre of mass, world axes.
template <class T>
Vector3<T> angular_momentum(const Matrix3<T>& I_B, const RigidBodyStateOf<T>& x) noexcept {
  return to_world<T>(x.X_WB.q, I_B * x.w_B);
}

/// Returns the angular velocity, body axes, at the attitude q_WB and the angular momentum L_W.
template <class T>
Vector3<T> angular_velocity(const Matrix3<T>& I_B, const Quaternion<T>& q_WB,
                            const Vector3<T>& L_W) noexcept {
  return solve3<T>(I_B, to_body<T>(q_WB, L_W));
}

/// Returns the angular velocity at the end of a stage (64), body axes. w_B: w+. q_WB: attitude at the end.
/// It is scaled down if its energy would exceed that of the base plus the work w+ . J, as after a radian.
template <class T>
Vector3<T> angular_velocity_after(const Matrix3<T>& I_B, const StageImpulseOf<T>& J,
                                  const RigidBodyStateOf<T>& base, const Vector3<T>& w_B,
                                  const Quaternion<T>& q_WB) noexcept {
  const Vector3<T> J_B = J.at(I_B, w_B);
  const Vector3<T> L_W = angular_momentum<T>(I_B, base) + to_world<T>(J.q_WM, J_B);
  Vector3<T> end_B = angular_velocity<T>(I_B, q_WB, L_W);
  const T twice_energy = end_B.dot(I_B * end_B), most = J.twice_energy + 2 * w_B.dot(J_B);
  if (any(twice_energy > most)) {
    using std::sqrt;
    end_B *= select(twice_energy > most, T(sqrt(select(most > 0, most, T(0)) / twice_energy)), T(1));
  }
  return select(J.is_joined > 0, w_B, end_B);
}

}  // namespace godobject
