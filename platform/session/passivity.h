// Damping margin of each driven axis: the passivity condition (feedback adds no energy) and the stability
// condition. docs/theory/passivity.md derives both.
#pragma once

#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"
#include "hal/rig/passivity_controller.h"
#include "platform/motion/motion.h"
#include "platform/scene/scene.h"
#include "platform/session/sampled_axis.h"

namespace godobject {

/// Margin of one driven joint. The tool is taken as fixed, because a tool that yields displays lower gains.
struct JointMargin {
  std::string joint;
  bool hinge = true;
  SampledAxis axis;
  double K_weight = 0;  // part of axis.K that compensates the weight of the device's links
  bool stable_alone = true, stable_held = true;  // without a hand, and in the hand of [device.plant]
};

struct Passivity {
  std::vector<JointMargin> joints;  // the joints with a drive; empty without feedback
  /// Largest ratio of needed to own damping over all directions of joint motion. Passive up to 1.
  double worst_direction = 0;

  bool passive() const noexcept { return worst_direction <= 1; }
};

/// Computes the margins of the gains that the scene's handles display, at the joint coordinates q. The rig
/// must be valid.
Passivity passivity(const SceneConfig& scene, const JointVector& q);

/// Returns the parameters of the drives' passivity controllers, in the order of RigParams::drives, with the
/// margins at q. A controller with a margin is idle. Empty without a rig.
std::vector<PassivityParams> passivity_controllers(const SceneConfig& scene, const JointVector& q);

/// Returns the device's joint coordinates at the start of the motion. Zero if the pose cannot be inverted,
/// empty without a rig.
JointVector joints_at_start(const SceneConfig& scene, const Motion& motion);

/// Returns the margins as a table, one line a joint, with its assumptions. Empty if there are none.
std::vector<std::string> passivity_table(const Passivity& passivity);
/// Returns one warning for each axis without margin: the gain to lower and the percentage that remains.
std::vector<std::string> passivity_warnings(const Passivity& passivity);

}  // namespace godobject
