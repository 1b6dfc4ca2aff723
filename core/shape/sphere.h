// Solid ball about the origin of its frame.
#pragma once

#include "core/shape/shape.h"

namespace godobject {

struct SphereShape {
  static constexpr ShapeKind kind = ShapeKind::sphere;

  static bool is_valid(const ShapeParams& par) noexcept { return is_dimension(par.radius); }

  /// Returns the distance; at the centre n = z.
  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real) noexcept {
    const Real length = p.norm();
    return {.distance = length - par.radius, .n = direction(p, length, Vec3::UnitZ())};
  }
};

}  // namespace godobject
