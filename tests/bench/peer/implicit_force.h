// Coupling of engines that receive forces alone.
// The force takes the end of the step into account,
// F = m (m + h g + h^2 k)^-1 (k (x_D - x - h v) + g (v_D - v)),
// as an implicit step of the body alone would have it. Rotations alike.
#pragma once

#include "tests/oracle/case/case.h"

namespace godobject::bench {

struct ForceAndTorque {
  oracle::Vector3d f, tau;  // N, N m, world axes
};

/// x: state of the body at the start of the step. D: target.
inline ForceAndTorque implicit_force(const oracle::Body& body, const oracle::RigidState& x,
                                     const oracle::RigidState& D, double h) {
  const oracle::Coupling& c = *body.coupling;
  const double s = body.m / (body.m + h * c.g_t + h * h * c.k_t);
  const Eigen::AngleAxisd turn(D.q * x.q.conjugate());
  const oracle::Matrix3d R = x.q.toRotationMatrix();
  const oracle::Matrix3d I = R * body.I_B * R.transpose();
  const oracle::Matrix3d A = I + (h * c.g_r + h * h * c.k_r) * oracle::Matrix3d::Identity();
  const oracle::Vector3d wanted = c.k_r * (turn.angle() * turn.axis() - h * x.w) + c.g_r * (D.w - x.w);
  return {.f = s * (c.k_t * (D.p - x.p - h * x.v) + c.g_t * (D.v - x.v)), .tau = I * A.inverse() * wanted};
}

}  // namespace godobject::bench
