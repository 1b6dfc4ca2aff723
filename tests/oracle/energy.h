// Conserved quantities of a motion, for tests.
#pragma once

#include <vector>

#include "tests/oracle/case/case.h"

namespace godobject::oracle {

inline double kinetic_energy(const Body& body, const RigidState& x) {
  const Vector3d w_B = x.q.conjugate() * x.w;
  return 0.5 * body.m * x.v.squaredNorm() + 0.5 * w_B.dot(body.I_B * w_B);
}

/// About the body's origin, world axes, N m s.
inline Vector3d angular_momentum(const Body& body, const RigidState& x) {
  return x.q * (body.I_B * (x.q.conjugate() * x.w));
}

inline double kinetic_energy(const Case& problem, const std::vector<RigidState>& states) {
  double sum = 0;
  for (std::size_t i = 0; i < states.size(); ++i) sum += kinetic_energy(problem.bodies[i], states[i]);
  return sum;
}

/// Kinetic energy, and that of gravity (zero at the world's origin), J.
inline double energy(const Case& problem, const std::vector<RigidState>& states) {
  double sum = kinetic_energy(problem, states);
  for (std::size_t i = 0; i < states.size(); ++i) {
    sum -= problem.bodies[i].m * problem.gravity.dot(states[i].p);
  }
  return sum;
}

/// N s
inline Vector3d momentum(const Case& problem, const std::vector<RigidState>& states) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < states.size(); ++i) sum += problem.bodies[i].m * states[i].v;
  return sum;
}

/// Angular momentum of all bodies about the world's origin, N m s.
inline Vector3d angular_momentum(const Case& problem, const std::vector<RigidState>& states) {
  Vector3d sum = Vector3d::Zero();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Body& body = problem.bodies[i];
    sum += angular_momentum(body, states[i]) + states[i].p.cross(body.m * states[i].v);
  }
  return sum;
}

}  // namespace godobject::oracle
