// The model's differential equations, (1)-(3) and per body (6): no time step appears in them.
#pragma once

#include <vector>

#include "tests/oracle/case.h"
#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// State of all bodies in one vector; per body p (3), q as w x y z (4), v (3), w (3).
inline constexpr Eigen::Index state_size = 13;

ScalarVector pack(const std::vector<RigidState>& states);

/// Quaternions come out normalised.
std::vector<RigidState> unpack(const ScalarVector& y);

/// Scales every quaternion of y to length 1.
void normalise(ScalarVector& y);

/// The rotation vector alpha u of q, alpha in [0, pi]; q need not be exactly unit.
ScalarVector3 rotation_vector(const ScalarQuaternion& q);

/// y' = f(t, y) of (1) for all bodies of a case.
class Dynamics {
 public:
  /// Keeps a reference to the case.
  explicit Dynamics(const Case& problem) : case_(problem) {}

  void operator()(Scalar t, const ScalarVector& y, ScalarVector& dy_dt) const;

 private:
  const Case& case_;
};

}  // namespace godobject::oracle
