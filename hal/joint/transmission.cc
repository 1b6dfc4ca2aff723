#include "hal/joint/transmission.h"

#include <algorithm>
#include <cmath>

#include <Eigen/LU>
#include <Eigen/SVD>

namespace godobject {

namespace {

// Least ratio of the singular values of an invertible matrix. Below it, counts of encoders decide the result.
constexpr double least_condition = 1e-6;

std::ptrdiff_t index_of(std::span<const DeviceJoint> joints, const std::string& name) {
  return std::ranges::find(joints, name, &DeviceJoint::name) - joints.begin();
}

bool is_square(const TransmissionParams& t) {
  return t.joint_per_actuator.size() == t.joints.size() &&
         std::ranges::all_of(t.joint_per_actuator,
                             [&](const auto& row) { return row.size() == t.joints.size(); });
}

Eigen::MatrixXd matrix_of(const TransmissionParams& t) {
  const auto n = static_cast<Eigen::Index>(t.joints.size());
  Eigen::MatrixXd M(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      M(i, j) = t.joint_per_actuator[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  return M;
}

// Returns the error of the matrix; empty if it is finite, square and invertible.
std::string error_of_matrix(const TransmissionParams& t) {
  const std::string n = std::to_string(t.joints.size());
  if (!is_square(t))
    return "joint_per_actuator must have " + n + " rows of " + n + " numbers, one row for each of its joints";
  const Eigen::MatrixXd M = matrix_of(t);
  if (!M.allFinite()) return "joint_per_actuator must be finite";
  // Scaled by rows, since joints in rad and in m differ by decades.
  const Eigen::VectorXd rows = M.rowwise().norm();
  if (rows.minCoeff() > 0) {
    const Eigen::MatrixXd scaled = rows.cwiseInverse().asDiagonal() * M;
    const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(scaled).singularValues();
    if (values.minCoeff() > least_condition * values.maxCoeff()) return "";
  }
  return "joint_per_actuator is singular: some motion of its joints moves no actuator";
}

}  // namespace

std::vector<std::string> validate(std::span<const TransmissionParams> transmissions,
                                  std::span<const DeviceJoint> joints) {
  std::vector<std::string> errors;
  std::vector<std::string> seen;
  for (const TransmissionParams& t : transmissions) {
    if (t.joints.empty()) {
      errors.emplace_back("joints must name at least one joint");
      continue;
    }
    for (const std::string& joint : t.joints) {
      if (index_of(joints, joint) == std::ssize(joints))
        errors.push_back("the device has no joint '" + joint + "'");
      if (std::ranges::find(seen, joint) != seen.end())
        errors.push_back("joint '" + joint + "' is named twice: a joint belongs to one transmission");
      seen.push_back(joint);
    }
    if (const std::string error = error_of_matrix(t); !error.empty()) errors.push_back(error);
  }
  return errors;
}

Transmission::Transmission(std::span<const TransmissionParams> transmissions,
                           std::span<const DeviceJoint> joints) {
  if (transmissions.empty()) return;
  const auto n = std::ssize(joints);
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(n, n), M_inverse = M;
  for (const TransmissionParams& t : transmissions) {
    std::vector<Eigen::Index> group;
    for (const std::string& joint : t.joints) group.push_back(index_of(joints, joint));
    const Eigen::MatrixXd block = matrix_of(t),
                          inverse = Eigen::PartialPivLU<Eigen::MatrixXd>(block).inverse();
    M(group, group) = block;
    M_inverse(group, group) = inverse;
  }
  M_ = M;
  M_transposed_ = M.transpose();
  M_inverse_ = M_inverse;
  M_inverse_transposed_ = M_inverse.transpose();
}

Eigen::MatrixXd Transmission::at_actuators(const Eigen::MatrixXd& A) const {
  if (M_.size() == 0) return A;
  return M_transposed_ * A * M_;
}

JointVector Transmission::product(const JointMatrix& A, const JointVector& x) noexcept {
  if (A.size() == 0) return x;
  JointVector y = JointVector::Zero(x.size());
  for (Eigen::Index j = 0; j < x.size(); ++j) y += A.col(j) * x(j);
  return y;
}

}  // namespace godobject
