// Problems of the oracle: rigid bodies, free or coupled to a moving target, and the joints between them.
// SI units, world axes W; body frame B with its origin at the centre of mass. Independent of core on purpose.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "tests/oracle/joint/joint.h"

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

/// A spring (36) between points of two bodies, or of the world and a body. With the ends x apart its force on
/// b is -k (|x| - l_0) u - g (u . x') u.
/// Without a rest length it is -k x - g x'. An anchor of a net (42) has no rest length either.
struct Spring {
  std::optional<std::size_t> a = std::nullopt;  // index in Case::bodies; empty: the world
  std::size_t b = 0;                            // likewise
  Vector3d p_A = Vector3d::Zero();              // m; in world axes if a is the world
  Vector3d p_B = Vector3d::Zero();              // m
  double k = 0;                                 // N/m, >= 0
  double g = 0;                                 // N s/m, >= 0
  double l_0 = 0;                               // m, >= 0
  bool is_anchor = false;  // its damper and its force on a act at the point of a that coincides with b
};

/// A sphere of a body on the floor z = 0, without friction (22). Its force is k d - c v_z upwards, if that
/// and the depth d of its lowest point are positive.
struct FloorSphere {
  std::size_t body = 0;             // index in Case::bodies
  Vector3d p_B = Vector3d::Zero();  // its centre, m
  double radius = 0;                // m
  double k = 0;                     // N/m, >= 0
  double c = 0;                     // N s/m, >= 0
};

struct Case {
  Vector3d gravity = Vector3d::Zero();  // m/s^2
  std::vector<Body> bodies;
  std::vector<Joint> joints =
      {};  // a tree: each body is the child of one joint at most, and there is no loop
  std::vector<Spring> springs = {};
  std::vector<FloorSphere> on_floor = {};
};

}  // namespace godobject::oracle
