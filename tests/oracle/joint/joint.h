// A joint between a body, the child C, and its parent P in the tree. SI units; vectors in P axes or C axes as
// named. Frame F sits on the parent at the anchor, frame K on the child; the joint holds K to F in some
// directions.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace godobject::oracle {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// Freedom of K relative to F.
enum class JointType {
  fixed,
  ball,         // turn
  hinge,        // turn about the axis
  slider,       // shift along the axis, which the parent carries
  cylindrical,  // both
  universal,    // turn about axis_P, which the parent carries, and axis_C, which the child carries
};

/// Angle of a hinge (rad, right-handed about axis_P) or shift of a slider (m), and its time derivatives.
struct JointCoordinate {
  double value = 0;
  double d1 = 0;  // 1/s
  double d2 = 0;  // 1/s^2
};

/// A coordinate given as a function of time. `at` must return consistent derivatives and be smooth between
/// the knots (ascending); integration steps end there.
struct ImposedMotion {
  std::function<JointCoordinate(double t)> at;
  std::vector<double> knots = {};
};

struct Joint {
  std::string name;
  JointType type = JointType::ball;
  std::optional<std::size_t> parent = std::nullopt;  // index in Case::bodies; empty: the world
  std::size_t child = 0;                             // index in Case::bodies
  Vector3d anchor_P = Vector3d::Zero();        // m; in world axes from the world's origin if P is the world
  Vector3d anchor_C = Vector3d::Zero();        // m
  Vector3d axis_P = Vector3d::UnitZ();         // unit; not used by fixed and ball
  Vector3d axis_C = Vector3d::UnitX();         // unit, only used by universal: g = axis_P . axis_C = 0
  Quaterniond q_PC = Quaterniond::Identity();  // attitude of C in P at angle zero; not for ball, universal
  std::optional<ImposedMotion> imposed = std::nullopt;  // of hinge and slider only
};

/// Force and torque of a joint on its child, at the child's anchor, in world axes. The parent gets the
/// opposite force and torque at the same point of space. With a prescribed coordinate the drive is included.
struct JointWrench {
  Vector3d f = Vector3d::Zero();    // N
  Vector3d tau = Vector3d::Zero();  // N m
};

}  // namespace godobject::oracle
