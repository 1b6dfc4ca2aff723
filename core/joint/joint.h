// Joints between bodies, or a body and the world: parameters and allowed motion.
//
// A joint has a frame on the parent (P) and one on the child (C); they coincide at joint coordinate zero. Its
// motion is a list of axes, rotations about and translations along them, one per coordinate. At an instant a
// joint yields its axes and its violation e; the solver needs nothing else. A new joint is one file like
// hinge.h, named in list.h.
#pragma once

#include <array>
#include <cstdint>

#include "core/body/rigid_body.h"
#include "core/math/angle.h"

namespace godobject {

enum class JointKind : std::uint8_t;  // core/joint/list.h

/// Frame on a body, in body axes about its centre of mass; on the world, in world axes.
struct JointFrame {
  Vec3 p = Vec3::Zero();
  Mat3 R = Mat3::Identity();
};

inline JointFrame joint_frame(const Pose& X) noexcept { return {.p = X.p, .R = X.q.toRotationMatrix()}; }

/// Parameters of the joint between a body and its parent.
struct JointParams {
  JointKind kind{};            // free: no joint
  std::size_t parent = world;  // index of a body before this one, or world
  JointFrame P;                // frame on the parent
  JointFrame C;                // frame on this body
};

/// Both frames of a joint in world axes.
struct JointFrames {
  Mat3 R_WP;
  Mat3 R_WC;
  Vec3 d_W;  // vector from the parent's anchor to the child's, m
};

/// Allowed motion and violation of a joint, world axes. Coordinates are the rotations, then the translations.
/// Three rotations are all rotations, and no axes are named.
template <int turns, int slides>
struct JointMotion {
  static constexpr int num_turns = turns;
  static constexpr int num_slides = slides;
  std::array<Vec3, turns == 3 ? 0 : turns> turn{};  // unit
  std::array<Vec3, slides> slide{};                 // unit
  Vec3 e_w = Vec3::Zero();                          // rad: undone by turning the child by -e_w
  Vec3 e_v = Vec3::Zero();                          // m: undone by shifting the child's anchor by -e_v
};

/// Coordinates of a joint, at most two: rotations, then translations, rad and m.
using JointCoordinates = Eigen::Matrix<Real, 2, 1>;

/// Returns R turned about its own axis k by an angle, rad.
inline Mat3 turned(const Mat3& R, int k, Real angle) noexcept {
  Vec3 a = Vec3::Zero();
  a[k] = unwrapped(angle, 0);
  return R * exp_so3(a).toRotationMatrix();
}

}  // namespace godobject
