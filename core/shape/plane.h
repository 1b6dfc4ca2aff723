// Half-space below z = 0 of its frame.
#pragma once

#include "core/shape/shape.h"

namespace godobject {

struct PlaneShape {
  static constexpr ShapeKind kind = ShapeKind::plane;

  static bool is_valid(const ShapeParams&) noexcept { return true; }

  static SurfacePoint nearest(const ShapeParams&, const Vec3& p, Real) noexcept {
    return {.distance = p.z(), .n = Vec3::UnitZ()};
  }
};

}  // namespace godobject
