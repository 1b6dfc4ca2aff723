// A rigid body: what it is (params) and where it is (state).
#pragma once

#include "core/so3.h"

namespace godobject {

struct RigidBodyParams {
  Real m = 1;                   // mass, kg, > 0
  Mat3 I_B = Mat3::Identity();  // inertia about the centre of mass in body axes, kg m^2, positive definite
  Real anisotropy = 1;          // sqrt(I_max / I_min): see rho in implicit_rotation; rigid_body() fills it in
};

/// The translation lives in the world frame, the rotation in the body frame, where I_B is constant.
struct RigidBodyState {
  Pose X_WB;
  Vec3 v_W = Vec3::Zero();  // of the centre of mass, m/s
  Vec3 w_B = Vec3::Zero();  // angular velocity in body axes, rad/s
};

/// (17)  pose after moving for a time t with constant v_W and w_B. A body turns at most half a turn per step.
inline Pose moved(const Pose& X_WB, const Vec3& v_W, const Vec3& w_B, Real t) noexcept {
  Vec3 turn_B = t * w_B;
  const Real turn_sq = turn_B.squaredNorm();
  if (turn_sq > pi * pi) turn_B *= pi / std::sqrt(turn_sq);
  return {.p = X_WB.p + t * v_W, .q = X_WB.q * renormalizing(exp_so3(turn_B), X_WB.q)};
}

}  // namespace godobject
