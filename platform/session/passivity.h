// Damping margin of each driven axis: the passivity condition (feedback adds no energy) and the stability
// condition. docs/theory/passivity.md derives both.
#pragma once

#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"
#include "hal/rig/passivity_controller.h"
#include "platform/motion/motion.h"
#include "platform/scene/scene.h"
#include "platform/session/joint_ranges.h"
#include "platform/session/sampled_axis.h"

namespace godobject {

/// Margin of one driven joint. The tool is taken as fixed, because a tool that yields displays lower gains.
struct JointMargin {
  std::string joint;
  bool hinge = true;
  SampledAxis axis;
  double needed = 0;  // smallest damping of its own with which it is passive alone, N m s/rad or N s/m
  /// Damping with which it is passive while all axes move, if each has as much; `needed` if they are anyway.
  double needed_together = 0;
  double K_weight = 0;  // part of axis.K that compensates the weight of the device's links
  JointVector q{};      // pose of these gains
  bool stable_alone = true, stable_held = true;  // without a hand, and in the hand of [device.plant]
};

struct Passivity {
  std::vector<JointMargin> joints;  // the joints with a drive; empty without feedback
  /// Largest ratio of needed to own damping over all directions of joint motion. Passive up to 1.
  double worst_direction = 0;
  JointVector worst_q{};  // pose of that ratio
  JointRanges ranges{};   // in which these are the worst poses

  bool passive() const noexcept { return worst_direction <= 1; }
};

/// Computes the margins of the gains that the scene's handles display, at the joint coordinates q. The rig
/// must be valid.
Passivity passivity(const SceneConfig& scene, const JointVector& q);

/// Returns for each axis the margin at the pose, within the ranges of the joints, where it needs most. A
/// bounded number of poses is drawn, and the worst are refined. start: of the joints without a stated range.
Passivity worst_passivity(const SceneConfig& scene, const JointVector& start);

/// Returns the parameters of the drives' passivity controllers, in the order of RigParams::drives, by
/// worst_passivity(). A controller with a margin is idle. Empty without a rig.
std::vector<PassivityParams> passivity_controllers(const SceneConfig& scene, const JointVector& start);

/// Returns the device's joint coordinates at the start of the motion. Zero if the pose cannot be inverted,
/// empty without a rig.
JointVector joints_at_start(const SceneConfig& scene, const Motion& motion);

/// Returns the margins as a table, one line a joint, with its assumptions. Empty if there are none.
std::vector<std::string> passivity_table(const Passivity& passivity);
/// Returns one warning for each axis without margin: the gain to lower and the percentage that remains.
std::vector<std::string> passivity_warnings(const Passivity& passivity);

}  // namespace godobject
