// State of the bodies in the integrator: one vector of numbers.
#pragma once

#include <vector>

#include "tests/oracle/case/case.h"
#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// State of all bodies in one vector; per body p (3), q as w x y z (4), v (3), w (3).
inline constexpr Eigen::Index state_size = 13;

/// RigidState in the numbers of the integrator; q not always unit.
struct BodyState {
  ScalarVector3 p = ScalarVector3::Zero();
  ScalarQuaternion q = ScalarQuaternion::Identity();
  ScalarVector3 v = ScalarVector3::Zero();
  ScalarVector3 w = ScalarVector3::Zero();
};

/// Returns the offset of a body in the state vector.
inline Eigen::Index offset_of(std::size_t body) { return state_size * static_cast<Eigen::Index>(body); }

inline Eigen::Matrix<Scalar, 4, 1> wxyz(const ScalarQuaternion& q) { return {q.w(), q.x(), q.y(), q.z()}; }

std::vector<BodyState> body_states(const ScalarVector& y);
ScalarVector pack(const std::vector<BodyState>& states);

ScalarVector pack(const std::vector<RigidState>& states);

/// Returns the states with normalised quaternions.
std::vector<RigidState> unpack(const ScalarVector& y);

/// Scales every quaternion of y to length 1.
void normalise(ScalarVector& y);

}  // namespace godobject::oracle
