// Cues for a hand without force feedback: the distance of tool and device, and contact events with their
// speeds. Pure functions of a step's output, which the step itself never calls.
#pragma once

#include <algorithm>

#include "core/body/rigid_body.h"
#include "core/math/rotation_error.h"
#include "core/math/so3.h"

namespace godobject {

/// Distance of a body from its target.
struct Divergence {
  Real distance = 0;  // m
  Real angle = 0;     // rad, 0 to pi
};

/// Returns the divergence of a body at X_WB from the device's pose X_WD.
inline Divergence divergence(const Pose& X_WD, const Pose& X_WB) noexcept {
  return {.distance = (X_WD.p - X_WB.p).norm(),
          .angle = rotation_error(X_WB.q, X_WD.q, Vec3::Zero()).phi_B.norm()};
}

/// Returns the speed of an impact, m/s: the power of the contact wrench at the velocity before the step, per
/// unit of force. With one contact it is the speed of the contact point against the force. Zero for a body
/// that moves away, and without a force.
/// F_W: contact wrench on the body, about its centre of mass. V_WB: the body's velocity before the step.
inline Real impact_speed(const Wrench& F_W, const Twist& V_WB) noexcept {
  const Real F = F_W.f.norm();
  return F > 0 ? std::max(-(F_W.f.dot(V_WB.v) + F_W.tau.dot(V_WB.w)) / F, Real(0)) : 0;
}

/// Contact events of one body, step by step.
class ContactCue {
 public:
  /// Returns the impact speed if the contact of the body began in this step, else a negative number.
  /// F_W: contact wrench of the step. V_WB: velocity after it.
  Real observe(const Wrench& F_W, const Twist& V_WB) noexcept {
    const bool touches = F_W.f.squaredNorm() > 0;
    const Real speed = touches && !touched_ ? impact_speed(F_W, V_before_) : -1;
    touched_ = touches;
    V_before_ = V_WB;
    return speed;
  }

 private:
  bool touched_ = false;
  Twist V_before_;
};

}  // namespace godobject
