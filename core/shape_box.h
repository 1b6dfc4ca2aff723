// Solid box about the origin of its frame, edges along its axes.
#pragma once

#include "core/shape.h"

namespace godobject {

struct BoxShape {
  static constexpr ShapeKind kind = ShapeKind::box;

  static bool is_valid(const ShapeParams& par) noexcept {
    const Vec3& b = par.half_extents;
    return is_dimension(b.x()) && is_dimension(b.y()) && is_dimension(b.z());
  }

  /// Inside, the nearest face: of several the first of x, y, z; of two opposite ones the positive.
  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real) noexcept {
    const Vec3& b = par.half_extents;
    const Vec3 beyond = p.cwiseAbs() - b;
    Eigen::Index k = 0;
    const Real depth = beyond.maxCoeff(&k);
    Vec3 face = Vec3::Zero();
    face[k] = p[k] < 0 ? -1 : 1;
    if (!(depth > 0)) return {.distance = depth, .n = face};

    const Vec3 a = p - p.cwiseMax(-b).cwiseMin(b);
    const Real length = a.norm();
    return {.distance = length, .n = direction(a, length, face)};
  }
};

}  // namespace godobject
