// All joints of a case at one instant: the multipliers of (7), by a dense solve.
#pragma once

#include <vector>

#include <Eigen/Cholesky>

#include "tests/oracle/body_state.h"
#include "tests/oracle/case.h"
#include "tests/oracle/joint_rows.h"
#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// L of (4), with six columns per body (v, w in world axes), and L M^-1 L^T in factors. Rows of all joints, in
/// the order of the case.
class JointSystem {
 public:
  /// Throws std::runtime_error if the equations are redundant, as those of a universal joint with parallel
  /// axes. q of every state must be unit.
  JointSystem(const Case& problem, Scalar t, const std::vector<BodyState>& states);

  const ScalarVector& error() const { return g_; }
  const ScalarVector& rate() const { return rate_; }

  /// Multipliers that turn the accelerations A_t without joints (6 per body) into ones with g'' = 0:
  /// L M^-1 L^T lambda = E - L A_t, the velocity products in E.
  ScalarVector multipliers(const ScalarVector& A_t) const { return factors_.solve(-bias_ - L_ * A_t); }

  /// A_c = M^-1 L^T lambda.
  ScalarVector correction(const ScalarVector& lambda) const { return M_inverse_LT_ * lambda; }

  /// The displacement, smallest in the metric of the masses, that changes the rows by `change` to first order.
  ScalarVector displacement(const ScalarVector& change) const { return correction(factors_.solve(change)); }

  /// What lambda does to each child, at the child's anchor.
  std::vector<JointWrench> wrenches(const ScalarVector& lambda) const;

 private:
  void add_rows(const Joint& joint, const JointRows& rows, Eigen::Index first);
  void factorise(const Case& problem, const std::vector<BodyState>& states);

  ScalarVector g_, rate_, bias_;
  ScalarMatrix L_;
  ScalarMatrix M_inverse_LT_;
  Eigen::LLT<ScalarMatrix> factors_;

  struct Child {
    Eigen::Index first_row, num_rows, first_column;
    ScalarVector3 r;  // from the origin to the anchor
  };
  std::vector<Child> children_;  // of each joint
};

}  // namespace godobject::oracle
