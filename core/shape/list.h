// List of all kinds of shapes. A new kind is one file, named here.
#pragma once

#include "core/shape/box.h"
#include "core/shape/capsule.h"
#include "core/shape/height_field.h"
#include "core/shape/mesh.h"
#include "core/shape/plane.h"
#include "core/shape/sphere.h"

namespace godobject {

/// Calls f with the shape type of this kind.
template <class F>
auto with_shape(ShapeKind kind, F&& f) noexcept {
  switch (kind) {
    case ShapeKind::plane: break;  // also for values that are no kind
    case ShapeKind::box: return f(BoxShape{});
    case ShapeKind::sphere: return f(SphereShape{});
    case ShapeKind::capsule: return f(CapsuleShape{});
    case ShapeKind::height_field: return f(HeightFieldShape{});
    case ShapeKind::mesh: return f(MeshShape{});
  }
  return f(PlaneShape{});
}

/// Returns nearest_on() of the shape's kind.
inline SurfacePoint nearest(const ShapeParams& par, const Vec3& p_W, Real reach) noexcept {
  return with_shape(par.kind, [&](auto shape) { return nearest_on<decltype(shape)>(par, p_W, reach); });
}

/// True if the dimensions of the kind are valid, the pose is finite and its quaternion has unit length.
inline bool is_valid(const ShapeParams& par) noexcept {
  const Vec3& p = par.X_WS.p;
  const bool pose = p.sum() - p.sum() == 0 && std::abs(par.X_WS.q.squaredNorm() - 1) <= quaternion_tolerance;
  return pose && with_shape(par.kind, [&](auto shape) { return decltype(shape)::is_valid(par); });
}

}  // namespace godobject
