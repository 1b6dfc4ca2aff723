// Contrast for the stability map: semi-implicit Euler with the spring's force at the start of the step. A
// general-purpose physics engine treats an external force so. Not for use.
#pragma once

#include "core/body/coupling.h"
#include "core/body/target.h"

namespace godobject::study {

/// v+ = v + h F(x, v) / m,  w+ = w + h I^-1 (T(x, w) - w x I w),  x+ = x + h v+,  R+ = R exp(h w+). The
/// target is at rest.
class ExplicitCoupling {
 public:
  ExplicitCoupling(const RigidBodyParams& body, const SpringParams& spring, const Pose& X_WD)
      : body_(body), inv_I_B_(body.I_B.inverse()), spring_(spring), X_WD_(X_WD) {}

  void step(Real h, RigidBodyState& x) const {
    const Vec3 f_W = spring_.k * (X_WD_.p - x.X_WB.p) - spring_.g * x.v_W;
    const Vec3 phi_B = rotation_error(x.X_WB.q, X_WD_.q, Vec3::Zero()).phi_B;
    const Vec3 tau_B = spring_.k_r * phi_B - spring_.g_r * x.w_B;
    x.v_W += h / body_.m * f_W;
    x.w_B += h * (inv_I_B_ * (tau_B - x.w_B.cross(body_.I_B * x.w_B)));
    x.X_WB.p += h * x.v_W;
    const Vec3 turn_B = h * x.w_B;
    const Real angle = turn_B.norm();
    if (angle > 0) x.X_WB.q = (x.X_WB.q * Quat(Eigen::AngleAxis<Real>(angle, turn_B / angle))).normalized();
  }

 private:
  RigidBodyParams body_;
  Mat3 inv_I_B_;
  SpringParams spring_;
  Pose X_WD_;
};

}  // namespace godobject::study
