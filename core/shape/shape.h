// Fixed obstacles: solids at rest in the world, with one query: the distance of a point from the surface.
//
// A kind of shape answers it in its own frame S. A new kind is one file like sphere.h. A sphere of radius r
// about p touches a shape if the distance of p is below r.
#pragma once

#include <cstdint>
#include <limits>

#include "core/math/so3.h"

namespace godobject {

enum class ShapeKind : std::uint8_t { plane, box, sphere, capsule, height_field, mesh };

/// True for kinds of shapes that a body may carry: convex and bounded.
constexpr bool is_carried(ShapeKind kind) noexcept {
  return kind == ShapeKind::box || kind == ShapeKind::sphere || kind == ShapeKind::capsule;
}

struct HeightField;   // core/shape/height_field.h
struct TriangleMesh;  // core/shape/mesh.h

/// A fixed obstacle. Each kind reads only its own dimensions.
struct ShapeParams {
  ShapeKind kind = ShapeKind::plane;
  Pose X_WS{};
  Vec3 half_extents = Vec3::Zero();           // box: half its edges along x, y, z, m, > 0
  Real radius = 0;                            // sphere, capsule: m, > 0
  Real half_length = 0;                       // capsule: half the axis between the two centres, m, >= 0
  const HeightField* height_field = nullptr;  // owned by the caller
  const TriangleMesh* mesh = nullptr;         // owned by the caller
};

/// Surface seen from a point p: the nearest point of the surface is p - distance * n.
struct SurfacePoint {
  Real distance = 0;       // m, negative inside
  Vec3 n = Vec3::UnitZ();  // unit, outward
};

/// Returns a / length, with length = |a|; `otherwise` if a has no direction.
inline Vec3 direction(const Vec3& a, Real length, const Vec3& otherwise) noexcept {
  return length > min_length ? Vec3(a / length) : otherwise;
}

/// Returns the surface seen from p_W, n in world axes. Exact if |distance| < reach (m, >= 0). Beyond,
/// |distance| is at least reach, n is a unit vector, and inside a mesh the sign is lost (core/shape/mesh.h).
/// The cost of a height field or mesh grows with reach; that of other kinds is constant. A position that is
/// not finite gives the distance NaN.
template <class Shape>
SurfacePoint nearest_on(const ShapeParams& par, const Vec3& p_W, Real reach) noexcept {
  const Vec3 p_S = to_body(par.X_WS.q, p_W - par.X_WS.p);
  // NaN and infinity end here, before a kind clamps a coordinate or converts it to an index
  if (!(p_S.sum() - p_S.sum() == 0)) return {.distance = std::numeric_limits<Real>::quiet_NaN()};
  const SurfacePoint s = Shape::nearest(par, p_S, reach);
  return {.distance = s.distance, .n = to_world(par.X_WS.q, s.n)};
}

/// True if a dimension is valid: positive and finite.
inline bool is_dimension(Real a) noexcept { return a > 0 && a - a == 0; }

/// Returns the cell of `num` along an axis that contains x, clamped to the first and last. Monotone in x.
inline std::uint32_t grid_cell(Real x, Real spacing, std::uint32_t num) noexcept {
  const Real c = x / spacing;
  if (!(c > 0)) return 0;
  return c < num ? std::uint32_t(c) : num - 1;
}

}  // namespace godobject
