// Values of Bullet and of the oracle, converted into each other. Bullet is in double precision.
#pragma once

#include <btBulletDynamicsCommon.h>

#include "tests/bench/peer/peer.h"

namespace godobject::bench {

inline btVector3 vector(const oracle::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
inline oracle::Vector3d vector(const btVector3& a) { return {a.x(), a.y(), a.z()}; }
inline btQuaternion quaternion(const oracle::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

/// Returns the state of a body at this place, at rest.
inline oracle::RigidState state_of(const btTransform& X) {
  const btQuaternion q = X.getRotation();
  oracle::RigidState x;
  x.p = vector(X.getOrigin());
  x.q = {q.w(), q.x(), q.y(), q.z()};
  return x;
}
inline oracle::RigidState state_of(const btRigidBody& body) {
  oracle::RigidState x = state_of(body.getCenterOfMassTransform());
  x.v = vector(body.getLinearVelocity());
  x.w = vector(body.getAngularVelocity());
  return x;
}

}  // namespace godobject::bench
