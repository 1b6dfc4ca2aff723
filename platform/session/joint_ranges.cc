#include "platform/session/joint_ranges.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace godobject {

JointRanges::JointRanges(const KinematicTreeParams& tree, const JointVector& start)
    : start_(start), low_(start), high_(start) {
  for (std::size_t j = 0; j < tree.joints.size(); ++j) {
    const DeviceJoint& joint = tree.joints[j];
    const auto i = static_cast<Eigen::Index>(j);
    const double reach = joint.kind == DeviceJointKind::hinge ? std::numbers::pi : 0;
    names_.push_back(joint.name);
    low_(i) = joint.lower.value_or(start(i) - reach);
    high_(i) = joint.upper.value_or(start(i) + reach);
  }
}

JointVector JointRanges::moved(JointVector q, Eigen::Index joint, double by) const noexcept {
  q(joint) = std::clamp(q(joint) + by, low_(joint), high_(joint));
  return q;
}

// Additive recurrence with the powers of 1 / r, r^(n + 1) = r + 1 (M. Roberts 2018): for any number of poses
// the gaps are of similar size.
std::vector<JointVector> JointRanges::poses(std::size_t num_poses) const {
  std::vector<JointVector> poses{start_};
  if (!vary()) return poses;
  double r = 1;
  const auto n = static_cast<double>(names_.size());
  for (int i = 0; i < 60; ++i) r = std::pow(1 + r, 1 / (n + 1));
  for (std::size_t k = 1; k <= num_poses; ++k) {
    JointVector q = low_;
    for (Eigen::Index j = 0; j < q.size(); ++j) {
      const double share = 0.5 + static_cast<double>(k) * std::pow(r, -static_cast<double>(j + 1));
      q(j) += (share - std::floor(share)) * width(j);
    }
    poses.push_back(q);
  }
  return poses;
}

std::string JointRanges::text(const JointVector& q) const {
  std::string text;
  for (std::size_t j = 0; j < names_.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    if (!varies(i)) continue;
    std::array<char, 32> number{};
    std::snprintf(number.data(), number.size(), " %.3g", q(i));
    text += (text.empty() ? "" : ", ") + names_[j] + number.data();
  }
  return text;
}

}  // namespace godobject
