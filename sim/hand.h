// The hand that moves a simulated device.
#pragma once

#include "core/body/target.h"
#include "hal/joint/kinematic_tree.h"

namespace godobject {

/// Motion of the hand as functions of time (s of its motion). Evaluation does not allocate.
class Hand {
 public:
  virtual ~Hand() = default;
  /// True if it moves the device's joints; otherwise the rig's first handle follows its target.
  virtual bool moves_joints() const noexcept = 0;
  virtual JointTarget joints(double t) const noexcept = 0;
  /// Returns the target of a grip: a handle of the rig, or a tool of a tracker.
  virtual Target target(std::size_t index, double t) const noexcept = 0;
  /// True while the clutch button of this target, or the hold button, is pressed.
  virtual bool presses_clutch(std::size_t index, double t) const noexcept = 0;
  virtual bool presses_hold(double t) const noexcept = 0;
};

}  // namespace godobject
