// A coupling as rows of ODE's constraint solver.
// F = k (x_D+ - x - h v+) + g (v_D+ - v+) is a motor of velocity (k e + g v_D) / (h k + g) with e = x_D+ - x,
// softened by CFM = 1 / (h k + g). The same by axis for the rotation vector: implicit Euler.
#pragma once

#include <ode/ode.h>

#include "tests/bench/peer/peer.h"

namespace godobject::bench {

static_assert(sizeof(dReal) == sizeof(double));

inline oracle::Vector3d vector(const dReal* a) { return {a[0], a[1], a[2]}; }

inline void place(dBodyID body, const oracle::RigidState& x) {
  const dQuaternion q{x.q.w(), x.q.x(), x.q.y(), x.q.z()};
  dBodySetPosition(body, x.p.x(), x.p.y(), x.p.z());
  dBodySetQuaternion(body, q);
  dBodySetLinearVel(body, x.v.x(), x.v.y(), x.v.z());
  dBodySetAngularVel(body, x.w.x(), x.w.y(), x.w.z());
}

inline oracle::RigidState state_of(dBodyID body) {
  oracle::RigidState x;
  x.p = vector(dBodyGetPosition(body));
  const dReal* const q = dBodyGetQuaternion(body);
  x.q = {q[0], q[1], q[2], q[3]};
  x.v = vector(dBodyGetLinearVel(body));
  x.w = vector(dBodyGetAngularVel(body));
  return x;
}

/// A body with its mass, at the origin.
inline dBodyID make_body(dWorldID world, const oracle::Body& par) {
  dMass mass;
  const oracle::Matrix3d& I = par.I_B;
  dMassSetParameters(&mass, par.m, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
  const dBodyID body = dBodyCreate(world);
  dBodySetMass(body, &mass);
  dBodySetGyroscopicMode(body, 1);
  return body;
}

/// Returns the rotation vector from one attitude to the other, world axes.
inline oracle::Vector3d turn_to(const oracle::Quaterniond& q_D, const oracle::Quaterniond& q) {
  const Eigen::AngleAxisd turn(q_D * q.conjugate());
  return turn.angle() * turn.axis();
}

class OdeRows {
 public:
  /// The world owns the joints and destroys them.
  OdeRows(dWorldID world, dBodyID body, const oracle::Coupling& coupling, double h)
      : h_(h),
        coupling_(&coupling),
        body_(body),
        slide_(dJointCreateLMotor(world, nullptr)),
        turn_(dJointCreateAMotor(world, nullptr)) {
    dJointAttach(slide_, body, nullptr);
    dJointAttach(turn_, body, nullptr);
    dJointSetLMotorNumAxes(slide_, 3);
    dJointSetAMotorMode(turn_, dAMotorUser);
    dJointSetAMotorNumAxes(turn_, 3);
    for (int k = 0; k < 3; ++k) {
      const oracle::Vector3d axis = oracle::Vector3d::Unit(k);
      const int group = k * dParamGroup;
      dJointSetLMotorAxis(slide_, k, 0, axis.x(), axis.y(), axis.z());
      dJointSetAMotorAxis(turn_, k, 0, axis.x(), axis.y(), axis.z());
      dJointSetLMotorParam(slide_, dParamFMax + group, dInfinity);
      dJointSetAMotorParam(turn_, dParamFMax + group, dInfinity);
      dJointSetLMotorParam(slide_, dParamCFM + group, 1 / (h * coupling.k_t + coupling.g_t));
      dJointSetAMotorParam(turn_, dParamCFM + group, 1 / (h * coupling.k_r + coupling.g_r));
    }
  }

  /// D: the target of the step to come.
  void aim(const oracle::RigidState& D) {
    const oracle::Coupling& c = *coupling_;
    const oracle::RigidState x = state_of(body_);
    const oracle::Vector3d v = (c.k_t * (D.p - x.p) + c.g_t * D.v) / (h_ * c.k_t + c.g_t);
    const oracle::Vector3d w = (c.k_r * turn_to(D.q, x.q) + c.g_r * D.w) / (h_ * c.k_r + c.g_r);
    for (int k = 0; k < 3; ++k) {
      dJointSetLMotorParam(slide_, dParamVel + k * dParamGroup, v[k]);
      dJointSetAMotorParam(turn_, dParamVel + k * dParamGroup, w[k]);
    }
  }

 private:
  double h_;
  const oracle::Coupling* coupling_;
  dBodyID body_;
  dJointID slide_, turn_;
};

}  // namespace godobject::bench
