// How much damping each driven axis of a device has left: the condition under which what it shows to the hand never
// gives energy, and the one under which it is stable. docs/theory/passivity.md derives both.
#pragma once

#include <string>
#include <vector>

#include "hal/joint/kinematic_tree.h"
#include "platform/motion/motion.h"
#include "platform/scene/scene.h"

namespace godobject {

/// An axis with a spring and a damper in software, sampled once a period: m q'' = -b q' + u + hand, where
/// u = -K q_k - B (q_k - q_(k-1)) / T from `delay` periods after sample k on, held for a period.
struct SampledAxis {
  double inertia = 1;      // m, kg m^2 or kg, > 0
  double damping = 0;      // b, the device's own, N m s/rad or N s/m
  double K = 0;            // N m/rad or N/m
  double B = 0;            // N m s/rad or N s/m
  double period_s = 1e-3;  // T
  int delay = 1;           // whole periods from the sample to the torque

  /// K (T/2 + t_d) + |B|: the axis is passive where its b is at least this.
  double needed() const noexcept;
  double margin() const noexcept { return damping - needed(); }
  bool passive() const noexcept { return margin() >= 0; }
};

/// Growth of the axis's motion per period, held by a hand of this stiffness and damping: stable below 1.
double growth_per_period(const SampledAxis& axis, double hand_stiffness = 0, double hand_damping = 0);

/// The B from which an axis without a spring and without damping of its own is unstable: 2 m/T without delay,
/// 0.83 m/T with one period of it.
double largest_stable_damping(double inertia, double period_s, int delay);

/// The tool counts as fixed: one that yields shows less.
struct JointMargin {
  std::string joint;
  bool hinge = true;
  SampledAxis axis;
  bool stable_alone = true, stable_held = true;  // without a hand, and in that of [device.plant]
};

struct Passivity {
  std::vector<JointMargin> joints;  // that have a drive, where there is feedback
  /// Joints that move together: the largest of needed over own damping among all directions. Passive up to 1.
  double worst_direction = 0;

  bool passive() const noexcept { return worst_direction <= 1; }
};

/// The margins of the gains that the scene's handles show, at these joint coordinates. The rig must be valid.
/// Where the motion begins; coordinates of zero where a pose cannot be inverted. Of a scene with a rig.
/// Where the motion begins; coordinates of zero where a pose cannot be inverted. The scene has a rig.
Passivity passivity(const SceneConfig& scene, const JointVector& q);

/// Where the motion begins; coordinates of zero where a pose cannot be inverted. Of a scene with a rig.
JointVector joints_at_start(const SceneConfig& scene, const Motion& motion);

/// The margins as a table, one line each, and what is assumed. Empty without any.
std::vector<std::string> passivity_table(const Passivity& passivity);
/// For each axis without margin what to lower, and how far.
std::vector<std::string> passivity_warnings(const Passivity& passivity);

}  // namespace godobject
