// The model's differential equations, (1)-(3) and, of joined bodies, (4) and (6): no time step appears in
// them.
#pragma once

#include <vector>

#include "tests/oracle/body_state.h"
#include "tests/oracle/case/case.h"
#include "tests/oracle/joint/joint.h"
#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// The rotation vector alpha u of q, alpha in [0, pi]; q need not be exactly unit.
ScalarVector3 rotation_vector(const ScalarQuaternion& q);

/// Returns the force of the floor (22) on a sphere of the body, N; 0 if it does not press.
Scalar floor_force(const FloorSphere& sphere, const BodyState& body);

/// y' = f(t, y) of all bodies of a case. Joints hold as accelerations, g'' = 0 (index 1), without
/// stabilisation: their errors g and g' come from the start and the integrator.
class Dynamics {
 public:
  /// Keeps a reference to the case.
  explicit Dynamics(const Case& problem) : case_(problem) {}

  void operator()(Scalar t, const ScalarVector& y, ScalarVector& dy_dt) const;

  /// Moves y to the nearest state with g = 0 and g' = 0 (nearest in the metric of the masses) and returns the
  /// largest |g| it had, m or rad. For small errors: two Newton steps, so 1e-6 ends below rounding.
  double project(Scalar t, ScalarVector& y) const;

  /// Wrench of each joint, at (t, y).
  std::vector<JointWrench> reactions(Scalar t, const ScalarVector& y) const;

 private:
  ScalarVector tendency(Scalar t, const std::vector<BodyState>& x) const;

  const Case& case_;
};

}  // namespace godobject::oracle
