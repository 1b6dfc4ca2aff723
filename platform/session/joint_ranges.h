// Ranges of a device's joints, and poses that fill them.
#pragma once

#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"

namespace godobject {

/// Ends of the joints' coordinates. A hinge without stated ends turns half a turn either way from the start.
/// A slider without them stays there.
class JointRanges {
 public:
  JointRanges() = default;
  JointRanges(const KinematicTreeParams& tree, const JointVector& start);

  /// True if any coordinate varies.
  bool vary() const noexcept { return (high_.array() > low_.array()).any(); }
  bool varies(Eigen::Index joint) const noexcept { return high_(joint) > low_(joint); }
  double width(Eigen::Index joint) const noexcept { return high_(joint) - low_(joint); }

  /// Returns the pose with one coordinate moved, within its range.
  JointVector moved(JointVector q, Eigen::Index joint, double by) const noexcept;
  /// Returns the start, and num_poses poses that fill the ranges evenly if any coordinate varies.
  std::vector<JointVector> poses(std::size_t num_poses) const;
  /// Returns a pose as text, of the coordinates that vary: "shoulder 0.31, elbow -1.2".
  std::string text(const JointVector& q) const;

 private:
  std::vector<std::string> names_;
  JointVector start_, low_, high_;
};

}  // namespace godobject
