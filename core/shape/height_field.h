// Height field: the solid below z = f(x, y) over a rectangle, with vertical sides and no bottom.
//
// Each cell of the grid is two triangles, not a bilinear patch. The nearest point is then exact in closed
// form with bounded cost. That of a patch needs an iteration, may not be unique, and has no smoother normal
// across the edges of cells. The distance of a closed solid is continuous everywhere, and so is the force of
// a penalty contact: over a ridge n turns with the point. Without the sides, the distance would jump where a
// point below the surface leaves the rectangle.
#pragma once

#include <algorithm>
#include <span>

#include "core/math/triangle.h"
#include "core/shape/shape.h"

namespace godobject {

/// Heights on a grid: column i, row j is at x = i spacing, y = j spacing, z = height[j columns + i].
struct HeightField {
  std::span<const Real> height;  // m, rows * columns, owned by the caller
  std::uint32_t columns = 0;     // along x, >= 2
  std::uint32_t rows = 0;        // along y, >= 2
  Real spacing = 0;              // m, > 0

  Vec3 point(std::uint32_t i, std::uint32_t j) const noexcept {
    return {i * spacing, j * spacing, height[std::size_t(j) * columns + i]};
  }
};

inline bool is_valid(const HeightField& field) noexcept {
  const std::size_t needed = std::size_t(field.columns) * field.rows;
  return field.columns >= 2 && field.rows >= 2 && field.height.size() >= needed &&
         is_dimension(field.spacing) &&
         std::ranges::all_of(field.height.first(needed), [](Real z) { return z - z == 0; });
}

/// Returns one of the two triangles of a cell, split from its first corner to the opposite one;
/// counter-clockwise seen from above.
inline Corners cell_triangle(const HeightField& field, std::uint32_t i, std::uint32_t j,
                             bool upper) noexcept {
  const Vec3 a = field.point(i, j), c = field.point(i + 1, j + 1);
  if (upper) return {a, c, field.point(i, j + 1)};
  return {a, field.point(i + 1, j), c};
}

inline Vec3 upward_normal(const Corners& t) noexcept { return (t[1] - t[0]).cross(t[2] - t[0]).normalized(); }

/// Returns f(x, y) for (x, y) in the rectangle.
inline Real surface_height(const HeightField& field, Real x, Real y) noexcept {
  const std::uint32_t i = grid_cell(x, field.spacing, field.columns - 1);
  const std::uint32_t j = grid_cell(y, field.spacing, field.rows - 1);
  const Real u = x / field.spacing - i, v = y / field.spacing - j;
  const Corners t = cell_triangle(field, i, j, v > u);
  if (v > u) return t[0].z() + v * (t[2].z() - t[0].z()) + u * (t[1].z() - t[2].z());
  return t[0].z() + u * (t[1].z() - t[0].z()) + v * (t[2].z() - t[1].z());
}

struct HeightFieldShape {
  static constexpr ShapeKind kind = ShapeKind::height_field;

  static bool is_valid(const ShapeParams& par) noexcept {
    return par.height_field && godobject::is_valid(*par.height_field);
  }

  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real reach) noexcept {
    std::uint32_t visited = 0;
    return nearest(*par.height_field, p, reach, visited);
  }

  /// Returns the surface seen from p. visited: increased by the number of triangles tested, two for each cell
  /// within reach along x and y.
  static SurfacePoint nearest(const HeightField& field, const Vec3& p, Real reach,
                              std::uint32_t& visited) noexcept {
    const Real x = std::clamp(p.x(), Real(0), (field.columns - 1) * field.spacing);
    const Real y = std::clamp(p.y(), Real(0), (field.rows - 1) * field.spacing);
    const Real z = surface_height(field, x, y);
    const bool beside = x != p.x() || y != p.y();
    const Vec3 a = p - Vec3(x, y, beside ? std::min(p.z(), z) : z);
    const Real length = a.norm();
    if (beside && p.z() <= z) return {.distance = length, .n = direction(a, length, Vec3::UnitX())};

    // The surface below or above p, or the nearest point of the border, bounds the search.
    const Real side = !beside && p.z() < z ? -1 : 1;
    SurfacePoint best = nearest_triangle(field, p, std::min(reach, length), side, visited);
    if (side < 0) visit_walls(field, p, best);
    return best;
  }

  /// Calls f(corners, normal, neighbour_normal) for the triangles in the cells within reach of p along x and
  /// y. neighbour_normal(k): normal of the triangle or wall beyond edge k.
  template <class F>
  static void each_triangle(const ShapeParams& par, const Vec3& p, Real reach, F f) noexcept {
    const HeightField& field = *par.height_field;
    const std::uint32_t columns = field.columns - 1, rows = field.rows - 1;
    const std::uint32_t last_i = grid_cell(p.x() + reach, field.spacing, columns);
    const std::uint32_t last_j = grid_cell(p.y() + reach, field.spacing, rows);
    for (std::uint32_t j = grid_cell(p.y() - reach, field.spacing, rows); j <= last_j; ++j)
      for (std::uint32_t i = grid_cell(p.x() - reach, field.spacing, columns); i <= last_i; ++i)
        for (const bool upper : {false, true}) {
          const Corners t = cell_triangle(field, i, j, upper);
          f(t, upward_normal(t),
            [&, i, j, upper](std::size_t k) noexcept { return neighbour_normal(field, i, j, upper, k); });
        }
  }

 private:
  /// Returns the normal of the triangle or wall beyond edge k of a cell's triangle.
  static Vec3 neighbour_normal(const HeightField& field, std::uint32_t i, std::uint32_t j, bool upper,
                               std::size_t k) noexcept {
    if (k == (upper ? 0 : 2)) return upward_normal(cell_triangle(field, i, j, !upper));
    const bool along_x = k == (upper ? 2 : 1), next = upper != along_x;  // where the neighbour lies
    const std::uint32_t at = along_x ? i : j, last = (along_x ? field.columns : field.rows) - 2;
    if (at == (next ? last : 0))
      return (next ? 1 : -1) * (along_x ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY()));
    const std::uint32_t to = next ? at + 1 : at - 1;
    return upward_normal(cell_triangle(field, along_x ? to : i, along_x ? j : to, !upper));
  }

  /// Returns the nearest point of the triangles in the cell nearest to p in x and y, and in all others within
  /// reach. Of points equally near, that of the first triangle.
  static SurfacePoint nearest_triangle(const HeightField& field, const Vec3& p, Real reach, Real side,
                                       std::uint32_t& visited) noexcept {
    const std::uint32_t columns = field.columns - 1, rows = field.rows - 1;
    const std::uint32_t own_i = grid_cell(p.x(), field.spacing, columns);
    const std::uint32_t own_j = grid_cell(p.y(), field.spacing, rows);
    const std::uint32_t last_i = grid_cell(p.x() + reach, field.spacing, columns);
    const std::uint32_t last_j = grid_cell(p.y() + reach, field.spacing, rows);
    SurfacePoint best{.distance = side * std::numeric_limits<Real>::infinity()};
    visit_cell(field, own_i, own_j, p, side, best);
    visited += 2;
    for (std::uint32_t j = grid_cell(p.y() - reach, field.spacing, rows); j <= last_j; ++j) {
      for (std::uint32_t i = grid_cell(p.x() - reach, field.spacing, columns); i <= last_i; ++i) {
        if (i == own_i && j == own_j) continue;
        visit_cell(field, i, j, p, side, best);
        visited += 2;
      }
    }
    return best;
  }

  static void visit_cell(const HeightField& field, std::uint32_t i, std::uint32_t j, const Vec3& p, Real side,
                         SurfacePoint& best) noexcept {
    for (const bool upper : {false, true}) {
      const Corners t = cell_triangle(field, i, j, upper);
      if (box_distance_sq(t, p) > best.distance * best.distance) continue;
      const SurfacePoint s = seen_triangle(t, p, side);
      if (side * s.distance < side * best.distance) best = s;
    }
  }

  /// Returns a triangle's nearest point. side: 1 for p above the surface, -1 below.
  static SurfacePoint seen_triangle(const Corners& t, const Vec3& p, Real side) noexcept {
    const Vec3 n = upward_normal(t);
    const TrianglePoint q = nearest_on_triangle(t, n, p);
    const Real length = std::sqrt(q.distance_sq);
    if (q.feature == TriangleFeature::face || is_touching(t, p, length)) {
      return {.distance = side * length, .n = n};
    }
    return {.distance = side * length, .n = direction(side * (p - q.p), length, n)};
  }

  /// Updates `best` for p inside if a wall is nearer. The walls have no lower end. Their upper edges belong
  /// to the triangles.
  static void visit_walls(const HeightField& field, const Vec3& p, SurfacePoint& best) noexcept {
    const Vec3 end((field.columns - 1) * field.spacing, (field.rows - 1) * field.spacing, 0);
    for (int k = 0; k < 2; ++k) {
      for (const Real sign : {Real(-1), Real(1)}) {
        Vec3 foot = p;
        foot[k] = sign < 0 ? 0 : end[k];
        const Real distance = -std::abs(p[k] - foot[k]);
        if (!(distance > best.distance && p.z() <= surface_height(field, foot.x(), foot.y()))) continue;
        Vec3 n = Vec3::Zero();
        n[k] = sign;
        best = {.distance = distance, .n = n};
      }
    }
  }
};

}  // namespace godobject
