// All joints of a case at one instant: the multipliers of (7), by a dense
// factorisation of L M^-1 L^T.
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "tests/oracle/body_state.h"
#include "tests/oracle/case/case.h"
#include "tests/oracle/joint/rows.h"
#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// L of (4), with six columns per body (v, w in world axes), in blocks, and L M^-1 L^T in factors. Rows of
/// all joints, in the order of the case.
class JointSystem {
 public:
  /// q of every state must be unit. The joints of a tree are independent while they hold. A bad trial step
  /// can break that (a universal joint with parallel axes). Multipliers and displacements are then NaN, which
  /// makes the integrator try a smaller step.
  JointSystem(const Case& problem, Scalar t, const std::vector<BodyState>& states);

  const ScalarVector& error() const { return g_; }
  const ScalarVector& rate() const { return rate_; }

  /// Multipliers that turn the accelerations A_t without joints (6 per body) into ones with g'' = 0:
  /// L M^-1 L^T lambda = E - L A_t, the velocity products in E.
  ScalarVector multipliers(const ScalarVector& A_t) const;

  /// A_c = M^-1 L^T lambda.
  ScalarVector correction(const ScalarVector& lambda) const;

  /// The displacement, smallest in the metric of the masses, that changes the rows by `change` to first
  /// order.
  ScalarVector displacement(const ScalarVector& change) const { return correction(solve(change)); }

  /// Returns the wrench of lambda on each child, at the child's anchor.
  std::vector<JointWrench> wrenches(const ScalarVector& lambda) const;

 private:
  /// The rows of one joint in the columns of one of its bodies.
  struct Block {
    Eigen::Index row;
    std::size_t body;
    JointRows::Jacobian L;
    JointRows::Jacobian L_M_inverse;
  };

  void add_block(Eigen::Index row, std::size_t body, const JointRows::Jacobian& L);
  void weigh_with_masses(const Case& problem, const std::vector<BodyState>& states);
  void factorise();
  ScalarVector solve(const ScalarVector& rhs) const;

  ScalarVector g_, rate_, bias_;
  std::vector<Block> blocks_;
  Eigen::LLT<ScalarMatrix> factors_;
  Eigen::Index num_columns_ = 0;
  std::vector<ScalarVector3> anchor_of_child_;  // of each joint, from the child's origin, world axes
  std::vector<std::size_t> block_of_child_;     // of each joint
};

}  // namespace godobject::oracle
