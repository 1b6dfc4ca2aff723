// Products and inverses of poses, for programs: X_AC = X_AB * X_BC, p_A = X_AB * p_B, X_BA = inverse(X_AB).
#pragma once

#include "core/math/so3.h"

namespace godobject {

/// Returns X_AC = X_AB X_BC. Its quaternion is of unit length if theirs are, for any number of products.
inline Pose operator*(const Pose& X_AB, const Pose& X_BC) noexcept {
  return {.p = X_AB.p + to_world(X_AB.q, X_BC.p), .q = renormalized(X_AB.q * X_BC.q)};
}

/// Returns the point p_A = p + q p_B, m. A direction is turned by the quaternion alone: X_AB.q * d_B.
inline Vec3 operator*(const Pose& X_AB, const Vec3& p_B) noexcept { return X_AB.p + to_world(X_AB.q, p_B); }

/// Returns X_BA = X_AB^-1.
inline Pose inverse(const Pose& X_AB) noexcept {
  const Quat q_BA = X_AB.q.conjugate();
  return {.p = -to_world(q_BA, X_AB.p), .q = q_BA};
}

}  // namespace godobject
