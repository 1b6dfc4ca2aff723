// Scenes with a target in closed form, for tests and studies that need no files.
#pragma once

#include <memory>

#include "tests/oracle/case/case.h"

namespace godobject::oracle {

/// Target of scene S1: sums of no two equal frequencies in all six degrees of freedom, with exact velocities.
RigidState scene_s1_target(double t);

/// Scene S1: a slender body of 0.1 kg on a spring of 1 kN/m and 1 N m/rad. It starts with the pose and the
/// velocity of its target. Rotational modes at 40 1/s and 937 1/s.
Case scene_s1();

/// Target of the reference case coupling-lissajous: a turn about z after one about an axis in the plane of x
/// and y, both of which change. Its motion.csv holds the same motion at 1 ms.
RigidState lissajous_device(double t);

/// Target of the reference case press, with knots: lowered by 4 cm within 0.5 s, and rocking about y.
std::shared_ptr<const Target> press_device();

/// A body of the device of the reference case grasper, by index: trocar, tube, left, right. Its motion.csv
/// holds the same motion at 1 ms, rounded to 12 digits.
RigidState grasper_device(std::size_t body, double t);

}  // namespace godobject::oracle
