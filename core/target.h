// The target between two samples of the device.
#pragma once

#include "core/so3.h"

namespace godobject {

/// Where the device wants the body to be, at one instant.
struct Target {
  Pose X_WD;
  Twist V_WD;
};

/// (15)  target at the fraction s in [0, 1] of the time h between samples a and b: the cubic through both
/// poses and velocities, fourth order; on quaternions component-wise, then normalised.
/// a.q and b.q are of one sign (a.q . b.q >= 0).
inline Target interpolated(const Target& a, const Target& b, Real s, Real h) noexcept {
  const Real r = 1 - s;
  const Real a0 = r * r * (1 + 2 * s), b0 = s * s * (1 + 2 * r);  // Hermite: values
  const Real a1 = h * s * r * r, b1 = -h * s * s * r;             // Hermite: derivatives
  const Real d0 = 6 * s * r / h;                                  // and their rates
  const Real a2 = r * (1 - 3 * s), b2 = s * (1 - 3 * r);

  // q' = 1/2 (0, w) q
  const Quat qa_dot = Quat(0, a.V_WD.w.x(), a.V_WD.w.y(), a.V_WD.w.z()) * a.X_WD.q;
  const Quat qb_dot = Quat(0, b.V_WD.w.x(), b.V_WD.w.y(), b.V_WD.w.z()) * b.X_WD.q;

  Target t;
  t.X_WD.p = a0 * a.X_WD.p + b0 * b.X_WD.p + a1 * a.V_WD.v + b1 * b.V_WD.v;
  t.V_WD.v = d0 * (b.X_WD.p - a.X_WD.p) + a2 * a.V_WD.v + b2 * b.V_WD.v;
  t.X_WD.q.coeffs() = a0 * a.X_WD.q.coeffs() + b0 * b.X_WD.q.coeffs() +
                      Real(0.5) * (a1 * qa_dot.coeffs() + b1 * qb_dot.coeffs());
  t.X_WD.q.coeffs() *= 1 / std::sqrt(t.X_WD.q.coeffs().squaredNorm());
  t.V_WD.w = r * a.V_WD.w + s * b.V_WD.w;
  return t;
}

}  // namespace godobject
