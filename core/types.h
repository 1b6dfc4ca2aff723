// Scalars, vectors, poses, twists and wrenches: the words every other file speaks in.
// SI units. Frames are letters: W world, B body (origin = centre of mass), D device target.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace godobject {

using Real = double;
using Vec3 = Eigen::Matrix<Real, 3, 1>;
using Mat3 = Eigen::Matrix<Real, 3, 3>;
using Quat = Eigen::Quaternion<Real, Eigen::DontAlign>;  // unit, (w, x, y, z) in every file and trace

/// X_WB: position (m) and attitude of frame B in frame W; p_W = p + q * p_B.
struct Pose {
  Vec3 p = Vec3::Zero();
  Quat q = Quat::Identity();
};

/// V_WB in world axes, angular part first: w (rad/s), v (m/s) of the origin of B.
struct Twist {
  Vec3 w = Vec3::Zero();
  Vec3 v = Vec3::Zero();
};

/// F in world axes about the origin of the body it acts on: torque tau (N m), force f (N).
struct Wrench {
  Vec3 tau = Vec3::Zero();
  Vec3 f = Vec3::Zero();
};

}  // namespace godobject
