// Joints between bodies, or a body and the world: what they are and how they let the child move.
//
// A joint has a frame on the parent (P) and one on the child (C); they coincide at joint coordinate zero. At an
// instant a joint gives, in world axes, the motion it allows, S (one column per coordinate), and how far it
// is violated, e; both as angular part and linear part at the child's anchor. The solver needs nothing else.
#pragma once

#include "core/rotation_error.h"

namespace godobject {

enum class JointKind : std::uint8_t { free, fixed, ball, hinge, slider, cylindrical, universal };

inline constexpr std::size_t world = static_cast<std::size_t>(-1);

/// How a body hangs on its parent.
struct JointParams {
  JointKind kind = JointKind::free;
  std::size_t parent = world;  // index of a body before this one, or world
  Pose X_BP;                   // joint frame on the parent body (or in the world)
  Pose X_BC;                   // joint frame on this body
};

/// Both frames of a joint in world axes.
struct JointFrames {
  Mat3 R_WP;
  Mat3 R_WC;
  Vec3 d_W;  // from the parent's anchor to the child's, m
};

/// Allowed motion and violation of a joint with D coordinates.
template <int D>
struct JointMotion {
  Eigen::Matrix<Real, 3, D> S_w = Eigen::Matrix<Real, 3, D>::Zero();  // angular velocity per coordinate rate
  Eigen::Matrix<Real, 3, D> S_v =
      Eigen::Matrix<Real, 3, D>::Zero();  // velocity of the anchor per coordinate rate
  Vec3 e_w = Vec3::Zero();                // rad: undone by turning the child by -e_w
  Vec3 e_v = Vec3::Zero();                // m: undone by shifting the child by -e_v
};

}  // namespace godobject
