// Target between two samples of the device.
#pragma once

#include "core/math/so3.h"

namespace godobject {

/// Pose and velocity that the device demands of a body at one instant.
template <class T>
struct TargetOf {
  PoseOf<T> X_WD;
  TwistOf<T> V_WD;
};
using Target = TargetOf<Real>;

/// Returns value q + rate q',  q' = 1/2 (0, w) q.
template <class T>
Quaternion<T> scaled_with_rate(const PoseOf<T>& X, const TwistOf<T>& V, Real value, Real rate) noexcept {
  const Vector3<T> u = X.q.vec();
  const Vector3<T> a = (Real(0.5) * rate) * V.w;
  const Vector3<T> vec = value * u + X.q.w() * a + a.cross(u);
  return {value * X.q.w() - a.dot(u), vec.x(), vec.y(), vec.z()};
}

template <class T>
Quaternion<T> plus(const Eigen::Quaternion<T, Eigen::DontAlign>& a, const Quaternion<T>& b) noexcept {
  return {a.w() + b.w(), a.x() + b.x(), a.y() + b.y(), a.z() + b.z()};
}

/// Interpolates the target (15) at the fraction s in [0, 1] of the time h between samples a and b. Cubic
/// through both poses and velocities, fourth order; quaternions by component, then normalised. a.q and b.q
/// must have one sign (a.q . b.q >= 0).
template <class T>
TargetOf<T> interpolated(const TargetOf<T>& a, const TargetOf<T>& b, Real s, Real h) noexcept {
  const Real r = 1 - s;
  const Real a0 = r * r * (1 + 2 * s), b0 = s * s * (1 + 2 * r);  // Hermite: values
  const Real a1 = h * s * r * r, b1 = -h * s * s * r;             // Hermite: derivatives
  const Real d0 = 6 * s * r / h;                                  // and their rates
  const Real a2 = r * (1 - 3 * s), b2 = s * (1 - 3 * r);

  TargetOf<T> t;
  t.X_WD.p = a0 * a.X_WD.p + b0 * b.X_WD.p + a1 * a.V_WD.v + b1 * b.V_WD.v;
  t.V_WD.v = d0 * (b.X_WD.p - a.X_WD.p) + a2 * a.V_WD.v + b2 * b.V_WD.v;
  using std::sqrt;
  const Quaternion<T> q =
      plus(scaled_with_rate(a.X_WD, a.V_WD, a0, a1), scaled_with_rate(b.X_WD, b.V_WD, b0, b1));
  t.X_WD.q.coeffs() = q.coeffs() * T(1 / sqrt(q.coeffs().squaredNorm()));
  t.V_WD.w = r * a.V_WD.w + s * b.V_WD.w;
  return t;
}

}  // namespace godobject
