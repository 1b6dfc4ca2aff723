// Solid capsule: all points within a radius of the segment from -half_length to half_length on the z axis.
#pragma once

#include <algorithm>

#include "core/shape/shape.h"

namespace godobject {

struct CapsuleShape {
  static constexpr ShapeKind kind = ShapeKind::capsule;

  static bool is_valid(const ShapeParams& par) noexcept {
    return is_dimension(par.radius) && (par.half_length == 0 || is_dimension(par.half_length));
  }

  /// Returns the surface seen from p; on the segment n = x.
  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real) noexcept {
    const Vec3 a = p - Vec3(0, 0, std::clamp(p.z(), -par.half_length, par.half_length));
    const Real length = a.norm();
    return {.distance = length - par.radius, .n = direction(a, length, Vec3::UnitX())};
  }
};

}  // namespace godobject
