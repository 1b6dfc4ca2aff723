// Points of a shape that touch other shapes: centre of a ball, ends of a capsule, corners of a box.
//
// Each point is the centre of a ball in the shape that is tangent to its surface. The ball of a corner only
// selects the face that the corner meets. Depth and contact point are those of the corner itself.
#pragma once

#include "core/math/componentwise.h"
#include "core/shape/shape.h"
#include "core/tuning.h"

namespace godobject {

/// Returns the number of points of a kind of shape; 0 for kinds that only obstacles have.
constexpr std::uint32_t num_points(ShapeKind kind) noexcept {
  switch (kind) {
    case ShapeKind::sphere: return 1;
    case ShapeKind::capsule: return 2;
    case ShapeKind::box: return 8;
    default: return 0;
  }
}
inline constexpr std::uint32_t max_points = 8;

/// True if a shape has points whose bits are not set in `rounded` (Surface::rounded).
constexpr bool has_points(ShapeKind kind, std::uint8_t rounded) noexcept {
  return (rounded + 1u) >> num_points(kind) == 0;
}

/// Point of a shape, in the shape's frame.
struct ShapePoint {
  Vec3 p_S = Vec3::Zero();    // centre of its ball
  Real r = 0;                 // radius of its ball, m
  Vec3 tip_S = Vec3::Zero();  // corner of a box, from the centre of its ball; zero for other kinds
};

/// Returns the half extent of a bounded shape along its thinnest axis, m; of other kinds infinity.
inline Real half_thickness(const ShapeParams& shape) noexcept {
  if (shape.kind == ShapeKind::box) return min_component(shape.half_extents);
  return is_carried(shape.kind) ? shape.radius : std::numeric_limits<Real>::infinity();
}

/// Returns the radius of a ball or capsule, m; 0 of other kinds.
inline Real round_radius(const ShapeParams& shape) noexcept {
  return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule ? shape.radius : 0;
}

/// Returns half the distances of the points of a shape along its axes, m.
inline Vec3 points_apart(const ShapeParams& shape) noexcept {
  if (shape.kind == ShapeKind::box) return shape.half_extents;
  return Vec3(0, 0, shape.kind == ShapeKind::capsule ? shape.half_length : 0);
}

/// Returns point j of a shape. thinnest: half thickness of the shape, or less for the ball in a corner, m.
inline ShapePoint point_of(const ShapeParams& shape, std::uint32_t j, Real thinnest) noexcept {
  if (shape.kind == ShapeKind::sphere) return {.r = shape.radius};
  if (shape.kind == ShapeKind::capsule)
    return {.p_S = Vec3(0, 0, j == 0 ? -shape.half_length : shape.half_length), .r = shape.radius};
  const Vec3 side((j & 1) != 0 ? 1 : -1, (j & 2) != 0 ? 1 : -1, (j & 4) != 0 ? 1 : -1);
  const Real r = corner_ball * thinnest;
  return {.p_S = side.cwiseProduct(Vec3(shape.half_extents - Vec3::Constant(r))), .r = r, .tip_S = r * side};
}

/// True if a ball about p_S (m, in the shape's frame) of radius r (m) rounds point j. It contains a ball or
/// the end of a capsule. It is as near to a corner of a box as a ball tangent to the three faces there.
inline bool rounds(const Vec3& p_S, Real r, const ShapeParams& shape, std::uint32_t j) noexcept {
  const ShapePoint point = point_of(shape, j, half_thickness(shape));
  const Real apart = (point.p_S + point.tip_S - p_S).norm(), largest = (1 + rounding_tolerance) * r;
  if (shape.kind == ShapeKind::box) return apart * apart <= 3 * largest * largest;
  return apart + point.r <= largest;
}

}  // namespace godobject
