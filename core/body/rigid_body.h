// A rigid body: parameters and state.
#pragma once

#include <cstddef>

#include "core/math/so3.h"
#include "core/tuning.h"

namespace godobject {

/// Number of the world, in place of a body's.
inline constexpr std::size_t world = static_cast<std::size_t>(-1);

template <class T>
struct RigidBodyParamsOf {
  T m = 1;  // mass, kg, > 0
  Matrix3<T> I_B =
      Matrix3<T>::Identity();  // inertia about the centre of mass, body axes, kg m^2, positive definite
  // derived by rigid_body()
  T anisotropy = 1;                    // sqrt(I_max / I_min), for rho in implicit_rotation
  T max_turn = max_extrapolated_turn;  // rad, largest rotation in an extrapolated step of TrBdf2
};
using RigidBodyParams = RigidBodyParamsOf<Real>;

/// State of a body: translation in the world frame, rotation in the body frame, in which I_B is constant.
template <class T>
struct RigidBodyStateOf {
  PoseOf<T> X_WB;
  Vector3<T> v_W = Vector3<T>::Zero();  // velocity of the centre of mass, m/s
  Vector3<T> w_B = Vector3<T>::Zero();  // angular velocity in body axes, rad/s
};
using RigidBodyState = RigidBodyStateOf<Real>;

/// Returns a rotation vector, shortened to half a turn, the limit of exp_so3().
template <class T = Real>
Vector3<T> at_most_half_a_turn(Vector3<T> turn) noexcept {
  const T turn_sq = turn.squaredNorm();
  if (any(turn_sq > pi * pi)) {
    using std::sqrt;
    turn *= select(turn_sq > pi * pi, T(pi / sqrt(turn_sq)), T(1));
  }
  return turn;
}

/// Returns the pose after a time t of constant v_W and w_B (17). A body turns at most half a turn per step.
template <class T = Real>
PoseOf<T> moved(const PoseOf<T>& X_WB, const Vector3<T>& v_W, const Vector3<T>& w_B,
                const std::type_identity_t<T>& t) noexcept {
  const Vector3<T> turn_B = at_most_half_a_turn<T>(t * w_B);
  return {.p = X_WB.p + t * v_W, .q = X_WB.q * renormalizing<T>(exp_so3<T>(turn_B), X_WB.q)};
}

}  // namespace godobject
