#include "tests/oracle/joint/system.h"

#include <limits>

#include <Eigen/LU>

namespace godobject::oracle {

namespace {

Eigen::Index first_column_of(std::size_t body) { return 6 * static_cast<Eigen::Index>(body); }

}  // namespace

JointSystem::JointSystem(const Case& problem, Scalar t, const std::vector<BodyState>& states)
    : num_columns_(first_column_of(states.size())) {
  Eigen::Index count = 0;
  for (const Joint& joint : problem.joints) count += num_rows(joint);
  for (ScalarVector* column : {&g_, &rate_, &bias_}) column->resize(count);

  const BodyState world;
  Eigen::Index row = 0;
  for (const Joint& joint : problem.joints) {
    const BodyState& child = states[joint.child];
    const JointRows rows = joint_rows(joint, t, joint.parent ? states[*joint.parent] : world, child);
    g_.segment(row, rows.size()) = rows.g;
    rate_.segment(row, rows.size()) = rows.rate;
    bias_.segment(row, rows.size()) = rows.bias;
    if (joint.parent) add_block(row, *joint.parent, rows.L_parent);
    block_of_child_.push_back(blocks_.size());
    add_block(row, joint.child, rows.L_child);
    anchor_of_child_.push_back(child.q * joint.anchor_C.cast<Scalar>());
    row += rows.size();
  }
  weigh_with_masses(problem, states);
  factorise();
}

void JointSystem::add_block(Eigen::Index row, std::size_t body, const JointRows::Jacobian& L) {
  blocks_.push_back({row, body, L, L});
}

void JointSystem::weigh_with_masses(const Case& problem, const std::vector<BodyState>& states) {
  std::vector<ScalarMatrix3> I_W_inverse;
  for (std::size_t i = 0; i < states.size(); ++i) {
    const ScalarMatrix3 R_WB = states[i].q.toRotationMatrix();
    I_W_inverse.push_back(R_WB * problem.bodies[i].I_B.cast<Scalar>().inverse() * R_WB.transpose());
  }
  for (Block& block : blocks_) {
    block.L_M_inverse.leftCols<3>() = block.L.leftCols<3>() * (1 / Scalar(problem.bodies[block.body].m));
    block.L_M_inverse.rightCols<3>() = block.L.rightCols<3>().lazyProduct(I_W_inverse[block.body]);
  }
}

/// Two joints meet in L M^-1 L^T where they share a body. Only the lower triangle is filled and used.
void JointSystem::factorise() {
  ScalarMatrix system = ScalarMatrix::Zero(g_.size(), g_.size());
  for (const Block& a : blocks_) {
    for (const Block& b : blocks_) {
      if (a.body != b.body || b.row > a.row) continue;
      system.block(a.row, b.row, a.L.rows(), b.L.rows()) += a.L.lazyProduct(b.L_M_inverse.transpose());
    }
  }
  factors_.compute(system);
}

ScalarVector JointSystem::solve(const ScalarVector& rhs) const {
  if (factors_.info() == Eigen::Success) return factors_.solve(rhs);
  return ScalarVector::Constant(rhs.size(), std::numeric_limits<Scalar>::quiet_NaN());
}

ScalarVector JointSystem::multipliers(const ScalarVector& A_t) const {
  ScalarVector rhs = -bias_;
  for (const Block& block : blocks_) {
    rhs.segment(block.row, block.L.rows()) -=
        block.L.lazyProduct(A_t.segment<6>(first_column_of(block.body)));
  }
  return solve(rhs);
}

ScalarVector JointSystem::correction(const ScalarVector& lambda) const {
  ScalarVector A_c = ScalarVector::Zero(num_columns_);
  for (const Block& block : blocks_) {
    A_c.segment<6>(first_column_of(block.body)) +=
        block.L_M_inverse.transpose().lazyProduct(lambda.segment(block.row, block.L.rows()));
  }
  return A_c;
}

std::vector<JointWrench> JointSystem::wrenches(const ScalarVector& lambda) const {
  std::vector<JointWrench> result;
  for (std::size_t joint = 0; joint < block_of_child_.size(); ++joint) {
    const Block& block = blocks_[block_of_child_[joint]];
    const Eigen::Matrix<Scalar, 6, 1> at_origin =
        block.L.transpose() * lambda.segment(block.row, block.L.rows());
    const ScalarVector3 f = at_origin.head<3>();
    const ScalarVector3 tau = at_origin.tail<3>() - anchor_of_child_[joint].cross(f);
    result.push_back({f.cast<double>(), tau.cast<double>()});
  }
  return result;
}

}  // namespace godobject::oracle
