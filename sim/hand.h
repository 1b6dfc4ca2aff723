// The hand that moves a simulated device.
#pragma once

#include "core/body/target.h"
#include "hal/joint/kinematic_tree.h"

namespace godobject {

/// What the hand does, as functions of time (s of its motion). Evaluation does not allocate.
class Hand {
 public:
  virtual ~Hand() = default;
  /// It moves the device's joints; otherwise the target that the rig's first handle follows.
  virtual bool moves_joints() const noexcept = 0;
  virtual JointTarget joints(double t) const noexcept = 0;
  /// Where it moves one of the things that it holds: a handle of the rig, a tool of a tracker.
  virtual Target target(std::size_t index, double t) const noexcept = 0;
  /// The button that opens and closes the clutch of this target, and the one that takes hold.
  virtual bool presses_clutch(std::size_t index, double t) const noexcept = 0;
  virtual bool presses_hold(double t) const noexcept = 0;
};

}  // namespace godobject
