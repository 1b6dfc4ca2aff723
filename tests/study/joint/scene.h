// Scenes in closed form with a device that can be slowed down, and articulated tools: for study and
// benchmarks.
#pragma once

#include "tests/oracle/case/case.h"

namespace godobject::study {

/// Motion of the device of a scene; 1 and 1 is the motion of its description.
struct Motion {
  double amplitude = 1;
  double rate = 1;
};

/// S1 of the oracle.
oracle::Case scene_s1(Motion motion);

/// S3, a grasper: trocar on a universal joint at the origin, tube on a cylindrical joint in it, two jaws on
/// hinges at the tube's end. All four are coupled. Stiff: the rotational damping of the tube, chosen for its
/// pitch, gives its roll a rate of 4e4 1/s. Starts at the device.
oracle::Case scene_s3(Motion motion = {});

/// Returns a case with every stiffness multiplied and damping ratios kept.
oracle::Case stiffened(oracle::Case problem, double factor);

/// S5: links of 0.1 m and 0.1 kg on ball joints, hung at the origin 45 degrees from the vertical, released.
oracle::Case scene_s5(std::size_t num_links);

/// Two rods, the second a child of the first by a joint with axes along x, y and z. Both are coupled to the
/// device, which moves as in S1 and also loads the joint.
oracle::Case scene_pair(oracle::JointType type, Motion motion = {});

}  // namespace godobject::study
