// The equations g(x, t) = 0 of one joint, exactly: g, its rate, and g'' = L A + bias.
#pragma once

#include "tests/oracle/body_state.h"
#include "tests/oracle/joint/joint.h"
#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// Up to six rows. Two kinds: n . d, the distance d from F to K along a direction n that F carries (m); and
/// u . b, the cosine of the angle between u that F carries and b that K carries (rad from square, to first
/// order).
struct JointRows {
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1, 0, 6, 1>;
  using Jacobian = Eigen::Matrix<Scalar, Eigen::Dynamic, 6, 0, 6, 6>;

  Column g;           // error
  Column rate;        // g'
  Column bias;        // the part of g'' that is not L A: velocity products and the prescribed motion
  Jacobian L_parent;  // columns v, w of the parent (world axes)
  Jacobian L_child;
  bool reversed = false;  // an axis that should point along its partner points away from it, yet g = 0

  Eigen::Index size() const { return g.size(); }
};

/// Number of equations of the joint.
Eigen::Index num_rows(const Joint& joint);

/// The equations at time t. q of both bodies must be unit. For a joint on the world, `parent` is BodyState{}.
JointRows joint_rows(const Joint& joint, Scalar t, const BodyState& parent, const BodyState& child);

}  // namespace godobject::oracle
