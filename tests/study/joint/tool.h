// Tools of bodies on joints: scene, joint violations, energy.
#pragma once

#include <algorithm>
#include <cmath>

#include "core/godobject.h"

namespace godobject {

template <class I, class J = TreeJoints<>, std::size_t N = 8>
struct Articulated {
  static constexpr std::size_t max_bodies = N;
  using Integrator = I;
  using Device = PoseDevice;
  using Joints = J;
  using Coupling = DampedSpring;
  using Feedback = None;
};

/// Returns the joint of body i at the present poses.
template <Scene S>
JointAt joint_of(const Params<S>& par, const State<S>& x, std::size_t i) {
  const JointParams& joint = par.bodies[i].joint;
  return joint_at(joint, place_of(par, x, joint.parent), place_of(par, x, i));
}

/// Violation of a joint, m and rad.
struct Drift {
  double m = 0, rad = 0;
};
inline Drift worst(const Drift& a, const Drift& b) {
  return {.m = std::max(a.m, b.m), .rad = std::max(a.rad, b.rad)};
}

/// Returns the violation of the joint of body i: e_w and e_v of its motion.
template <Scene S>
Twist violation(const Params<S>& par, const State<S>& x, std::size_t i) {
  Twist e;
  with_joint(par.bodies[i].joint.kind, [&](auto kind) {
    const auto motion = kind.motion(joint_of(par, x, i).X);
    e = {.w = motion.e_w, .v = motion.e_v};
  });
  return e;
}

/// Returns the largest violation of all joints.
template <Scene S>
Drift drift(const Params<S>& par, const State<S>& x) {
  Drift all;
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    const Twist e = violation(par, x, i);
    all = worst(all, {.m = e.v.norm(), .rad = e.w.norm()});
  }
  return all;
}

/// Returns the energy: kinetic, coupling and gravity, J.
template <Scene S>
Real energy(const Params<S>& par, const State<S>& x) {
  Real sum = 0;
  for (std::size_t i = 0; i < par.num_bodies; ++i) {
    const RigidBodyParams& body = par.bodies[i].body;
    sum += kinetic_energy(body, x.bodies[i].x) + coupling_at(par, x, i).energy -
           body.m * par.gravity_W.dot(x.bodies[i].x.X_WB.p);
  }
  return sum;
}

template <Scene S>
Real kinetic_energy(const Params<S>& par, const State<S>& x) {
  Real sum = 0;
  for (std::size_t i = 0; i < par.num_bodies; ++i) sum += kinetic_energy(par.bodies[i].body, x.bodies[i].x);
  return sum;
}

/// Returns gains for a damping ratio, as in (2): zeta = g / sqrt(m k), g_r / sqrt(I_max k_r).
inline SpringParams spring(const RigidBodyParams& body, Real k, Real k_r, Real zeta = 1.4) {
  const Real I_max = principal_moments(body.I_B).z();
  return {.k = k, .g = zeta * std::sqrt(body.m * k), .k_r = k_r, .g_r = zeta * std::sqrt(I_max * k_r)};
}

}  // namespace godobject
