#include "tests/oracle/joint_system.h"

#include <stdexcept>

#include <Eigen/LU>

namespace godobject::oracle {

namespace {

Eigen::Index first_column_of(std::size_t body) { return 6 * static_cast<Eigen::Index>(body); }

}  // namespace

JointSystem::JointSystem(const Case& problem, Scalar t, const std::vector<BodyState>& states) {
  Eigen::Index count = 0;
  for (const Joint& joint : problem.joints) count += num_rows(joint);
  for (ScalarVector* column : {&g_, &rate_, &bias_}) column->resize(count);
  L_.setZero(count, first_column_of(states.size()));

  const BodyState world;
  Eigen::Index first = 0;
  for (const Joint& joint : problem.joints) {
    const BodyState& child = states[joint.child];
    const JointRows rows = joint_rows(joint, t, joint.parent ? states[*joint.parent] : world, child);
    children_.push_back(
        {first, rows.size(), first_column_of(joint.child), child.q * joint.anchor_C.cast<Scalar>()});
    add_rows(joint, rows, first);
    first += rows.size();
  }
  factorise(problem, states);
}

void JointSystem::add_rows(const Joint& joint, const JointRows& rows, Eigen::Index first) {
  const Eigen::Index count = rows.size();
  g_.segment(first, count) = rows.g;
  rate_.segment(first, count) = rows.rate;
  bias_.segment(first, count) = rows.bias;
  L_.block(first, first_column_of(joint.child), count, 6) = rows.L_child;
  if (joint.parent) L_.block(first, first_column_of(*joint.parent), count, 6) = rows.L_parent;
}

void JointSystem::factorise(const Case& problem, const std::vector<BodyState>& states) {
  M_inverse_LT_ = L_.transpose();
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Body& body = problem.bodies[i];
    const ScalarMatrix3 R_WB = states[i].q.toRotationMatrix();
    const ScalarMatrix3 I_W_inverse = R_WB * body.I_B.cast<Scalar>().inverse() * R_WB.transpose();
    const Eigen::Index column = first_column_of(i);
    M_inverse_LT_.middleRows(column, 3) /= body.m;
    M_inverse_LT_.middleRows(column + 3, 3) = (I_W_inverse * M_inverse_LT_.middleRows(column + 3, 3)).eval();
  }
  factors_.compute(L_ * M_inverse_LT_);
  if (factors_.info() != Eigen::Success) throw std::runtime_error("the joints' equations are redundant");
}

std::vector<JointWrench> JointSystem::wrenches(const ScalarVector& lambda) const {
  std::vector<JointWrench> result;
  for (const Child& child : children_) {
    const Eigen::Matrix<Scalar, 6, 1> at_origin =
        L_.block(child.first_row, child.first_column, child.num_rows, 6).transpose() *
        lambda.segment(child.first_row, child.num_rows);
    const ScalarVector3 f = at_origin.head<3>();
    const ScalarVector3 tau = at_origin.tail<3>() - child.r.cross(f);
    result.push_back({f.cast<double>(), tau.cast<double>()});
  }
  return result;
}

}  // namespace godobject::oracle
