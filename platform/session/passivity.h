// Damping margin of each driven axis: the passivity condition (feedback adds no energy) and the stability
// condition. docs/theory/passivity.md derives both.
#pragma once

#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"
#include "hal/rig/passivity_controller.h"
#include "platform/motion/motion.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Axis with a spring and a damper in software, sampled once a period: m q'' = -b q' + u + hand.
/// The torque u = -K q_k - B (q_k - q_(k-1)) / T is held for a period, from `delay` periods after sample k.
struct SampledAxis {
  double inertia = 1;      // m, kg m^2 or kg, > 0
  double damping = 0;      // b, the device's own, N m s/rad or N s/m
  double K = 0;            // stiffness, N m/rad or N/m
  double B = 0;            // damping of the feedback, N m s/rad or N s/m
  double period_s = 1e-3;  // T, s
  int delay = 1;           // whole periods from the sample to the torque

  /// Returns the smallest b of a passive axis, K (T/2 + t_d) + |B|, with t_d = delay T.
  double needed() const noexcept;
  double margin() const noexcept { return damping - needed(); }
  bool passive() const noexcept { return margin() >= 0; }
};

/// Returns the largest growth factor of the motion per period, with a hand of this stiffness and damping. The
/// axis is stable below 1.
double growth_per_period(const SampledAxis& axis, double hand_stiffness = 0, double hand_damping = 0);

/// Returns the smallest B at which an axis without spring and own damping is unstable: 2 m/T without delay,
/// 0.83 m/T with one period of delay.
double largest_stable_damping(double inertia, double period_s, int delay);

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
