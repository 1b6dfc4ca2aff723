// Attitude error alpha u of (2) and its derivative, also near the half turn.
#pragma once

#include <algorithm>

#include "core/math/so3.h"
#include "core/tuning.h"

namespace godobject {

/// Error of a body with attitude q_WB towards a target q_WD, in body axes.
template <class T>
struct RotationErrorOf {
  Vector3<T> phi_B = Vector3<T>::Zero();  // alpha u, rad: R_WB exp(phi) = R_WD
  T curvature = 0;                        // c of d phi = -(1 - [phi]x / 2 + c [phi]x^2) d xi, 1/rad^2
};
using RotationError = RotationErrorOf<Real>;

inline constexpr std::array<Real, 6> error_curvature_terms{8.33333227436018897e-02, 1.11123359357362377e-02,
                                                           3.94568561542213425e-03, 1.77127598946016864e-03,
                                                           2.76911391896794928e-04, 8.25641477324351599e-04};

/// Returns c = (1 - (alpha/2) cot(alpha/2)) / alpha^2 from w = cos(alpha/2), relative error 2e-7. Beyond 2.33
/// rad, where c alpha^2 exceeds 1/2, a line below 1/(2 alpha^2). The stiffness that a stage assumes is then
/// at least k_r / 2, so that the stage cannot gain energy (docs/theory/stage.md).
template <class T = Real>
T error_curvature(const std::type_identity_t<T>& w) noexcept {
  using std::min;
  const T z = 1 - w;
  return min(polynomial<T>(error_curvature_terms, z), T(Real(0.1959) - Real(0.1716) * z));
}

/// Returns alpha u = log(q_WB^-1 q_WD) on the shorter way round; within the band, on the side of `previous`
/// (16). The torque then changes sides only 0.1 rad behind the half turn, and a target held there causes no
/// chatter.
template <class T = Real>
RotationErrorOf<T> rotation_error(const Quaternion<T>& q_WB, const Quaternion<T>& q_WD,
                                  const Vector3<T>& previous_B) noexcept {
  using std::abs;
  const Quaternion<T> q_BD = q_WB.conjugate() * q_WD;
  const T w = q_BD.w();
  const T side = select(abs(w) < half_turn_band, previous_B.dot(q_BD.vec()), w);
  const T sign = select(side < 0, T(-1), T(1));
  const T factor = sign * log_factor<T>(sign * w);
  return {.phi_B = factor * q_BD.vec(), .curvature = error_curvature<T>(sign * w)};
}

}  // namespace godobject
