// What the oracle solves: rigid bodies, each free or pulled to a moving target, and the joints between them.
// SI units, world axes W; body frame B with its origin at the centre of mass. Nothing here comes from core,
// on purpose.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "tests/oracle/joint.h"

namespace godobject::oracle {

using Eigen::Matrix3d;

/// Motion of a frame at one instant. Of the body B here; of its target D in target.h.
struct RigidState {
  Vector3d p = Vector3d::Zero();            // p_WB, m
  Quaterniond q = Quaterniond::Identity();  // q_WB, unit
  Vector3d v = Vector3d::Zero();            // v_WB, m/s
  Vector3d w = Vector3d::Zero();            // w_WB in world axes, rad/s
};

class Target;

/// The damped spring (2) between a body and its target. The torque is k_r alpha u with alpha in [0, pi].
struct Coupling {
  double k_t = 0;                                  // N/m, >= 0
  double g_t = 0;                                  // N s/m, >= 0
  double k_r = 0;                                  // N m/rad, >= 0
  double g_r = 0;                                  // N m s/rad, >= 0
  std::shared_ptr<const Target> target = nullptr;  // must be set
};

struct Body {
  std::string name;
  double m = 1;                         // kg, > 0
  Matrix3d I_B = Matrix3d::Identity();  // about the origin of B, in B axes; symmetric, positive definite
  RigidState start;                     // at t = 0
  std::optional<Coupling> coupling;
};

struct Case {
  Vector3d gravity = Vector3d::Zero();  // m/s^2
  std::vector<Body> bodies;
  std::vector<Joint> joints =
      {};  // a tree: each body is the child of one joint at most, and there is no loop
};

}  // namespace godobject::oracle
