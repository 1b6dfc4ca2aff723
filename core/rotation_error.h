// The attitude error alpha u of (2) and its derivative, near the half turn too.
#pragma once

#include "core/so3.h"

namespace godobject {

/// Error of a body with attitude q_WB towards a target q_WD, in body axes.
struct RotationError {
  Vec3 phi_B = Vec3::Zero();  // alpha u, rad: R_WB exp(phi) = R_WD
  Real s = 1;                 // (alpha/2) cot(alpha/2): how the error transverse to u shrinks per rad
};

/// Half-turn hysteresis: |cos(alpha/2)| below this keeps the side of the previous error, so the torque
/// changes sides only 0.1 rad behind the half turn and a target held there cannot make it chatter.
inline constexpr Real half_turn_band = 0.05;

/// alpha u = log(q_WB^-1 q_WD) on the shorter way round; within the band on the side of `previous`.
inline RotationError rotation_error(const Quat& q_WB, const Quat& q_WD, const Vec3& previous_B) noexcept {
  const Quat q_BD = q_WB.conjugate() * q_WD;
  const Real w = q_BD.w();
  const Real side = std::abs(w) < half_turn_band ? previous_B.dot(q_BD.vec()) : w;
  const Real sign = side < 0 ? Real(-1) : Real(1);
  const Real f = log_factor(sign * w);
  return {.phi_B = sign * f * q_BD.vec(), .s = Real(0.5) * f * sign * w};
}

}  // namespace godobject
