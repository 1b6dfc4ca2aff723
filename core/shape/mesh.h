// Triangle mesh: the solid inside a closed surface of triangles, searched through a uniform grid of cells.
//
// The sign of the distance is that of the angle-weighted pseudo-normal of the nearest feature, exact for a
// closed 2-manifold. Source: Baerentzen, Aanaes 2005, Signed distance computation using the angle weighted
// pseudonormal. All arrays belong to the caller; core/shape/mesh_setup.h fills the derived ones at load time.
#pragma once

#include <algorithm>
#include <span>

#include "core/math/triangle.h"
#include "core/shape/shape.h"

namespace godobject {

/// Corners of a triangle: indices of vertices, counter-clockwise seen from outside.
using TriangleIndices = std::array<std::uint32_t, 3>;

/// Unit pseudo-normals of a triangle's edges. Edge k runs from corner k to corner k + 1.
using EdgeNormals = std::array<Vec3, 3>;

/// Uniform grid over the mesh. Cell (i, j, k) has the index (k num[1] + j) num[0] + i.
struct MeshGrid {
  Vec3 origin = Vec3::Zero();
  Real spacing = 0;                      // m
  std::array<std::uint32_t, 3> num{};    // cells along x, y, z
  std::span<const std::uint32_t> start;  // start of each cell in `triangles`, and one past the last
  std::span<const std::uint32_t> triangles;

  /// Returns the index along an axis of the cell that contains x, clamped to the first and last.
  std::uint32_t along(std::size_t axis, Real x) const noexcept {
    return grid_cell(x - origin[Eigen::Index(axis)], spacing, num[axis]);
  }
  std::size_t index(std::uint32_t i, std::uint32_t j, std::uint32_t k) const noexcept {
    return (std::size_t(k) * num[1] + j) * num[0] + i;
  }
  Vec3 lower_corner(std::uint32_t i, std::uint32_t j, std::uint32_t k) const noexcept {
    return origin + spacing * Vec3(i, j, k);
  }
};

/// Calls f(i, j, k) for the cells that touch the box from `low` to `high`, i fastest.
template <class F>
void for_each_cell(const MeshGrid& grid, const Vec3& low, const Vec3& high, F&& f) noexcept {
  const std::uint32_t last_i = grid.along(0, high.x()), last_j = grid.along(1, high.y());
  const std::uint32_t last_k = grid.along(2, high.z());
  for (std::uint32_t k = grid.along(2, low.z()); k <= last_k; ++k)
    for (std::uint32_t j = grid.along(1, low.y()); j <= last_j; ++j)
      for (std::uint32_t i = grid.along(0, low.x()); i <= last_i; ++i) f(i, j, k);
}

struct TriangleMesh {
  std::span<const Vec3> vertices;  // m, in the shape's frame
  std::span<const TriangleIndices> triangles;
  std::span<const Vec3> face_normals;         // per triangle
  std::span<const EdgeNormals> edge_normals;  // per triangle
  std::span<const Vec3> vertex_normals;       // per vertex
  MeshGrid grid;

  Corners corners(std::size_t triangle) const noexcept {
    const TriangleIndices& t = triangles[triangle];
    return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
  }
};

struct MeshShape {
  static constexpr ShapeKind kind = ShapeKind::mesh;

  static bool is_valid(const ShapeParams& par) noexcept { return par.mesh && !par.mesh->grid.start.empty(); }

  /// Returns the surface seen from p. Without a surface within reach the distance is reach, also deep inside.
  /// reach must cover the sphere's radius about p plus its largest depth.
  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real reach) noexcept {
    std::uint32_t visited = 0;
    return nearest(*par.mesh, p, reach, visited);
  }

  /// Returns the surface seen from p. visited: increased by the number of triangles tested, those of the
  /// cells within reach.
  static SurfacePoint nearest(const TriangleMesh& mesh, const Vec3& p, Real reach,
                              std::uint32_t& visited) noexcept {
    Nearest best{.point = {.distance_sq = reach * reach}};
    const MeshGrid& grid = mesh.grid;
    for_each_cell(grid, p - Vec3::Constant(reach), p + Vec3::Constant(reach), [&](auto i, auto j, auto k) {
      const Vec3 low = grid.lower_corner(i, j, k), high = grid.lower_corner(i + 1, j + 1, k + 1);
      if ((p - nearest_in_box(p, low, high)).squaredNorm() > best.point.distance_sq) return;
      const std::size_t cell = grid.index(i, j, k);
      for (std::uint32_t c = grid.start[cell]; c < grid.start[cell + 1]; ++c) {
        update_nearest(mesh, grid.triangles[c], p, best);
        ++visited;
      }
    });
    if (best.triangle == none) return {.distance = reach};
    return surface_point(mesh, best, p);
  }

  /// Calls f(corners, normal, neighbour_normal) for the triangles in the cells within reach of p, for some
  /// several times. neighbour_normal(k): normal of the triangle beyond edge k.
  template <class F>
  static void each_triangle(const ShapeParams& par, const Vec3& p, Real reach, F f) noexcept {
    const TriangleMesh& mesh = *par.mesh;
    const MeshGrid& grid = mesh.grid;
    const Vec3 low = p - Vec3::Constant(reach), high = p + Vec3::Constant(reach);
    for_each_cell(grid, low, high, [&](auto i, auto j, auto k) {
      const std::size_t cell = grid.index(i, j, k);
      for (std::uint32_t c = grid.start[cell]; c < grid.start[cell + 1]; ++c) {
        const std::uint32_t t = grid.triangles[c];
        const Vec3& n = mesh.face_normals[t];
        // an edge's normal halves the angle between those of its triangles
        f(mesh.corners(t), n, [&](std::size_t edge) noexcept {
          const Vec3& half = mesh.edge_normals[t][edge];
          return Vec3(2 * half.dot(n) * half - n);
        });
      }
    });
  }

 private:
  static constexpr std::uint32_t none = static_cast<std::uint32_t>(-1);

  struct Nearest {
    TrianglePoint point;
    std::uint32_t triangle = none;
  };

  /// Replaces `best` if the triangle is nearer. Of triangles equally near, that with the lowest index,
  /// independent of the grid.
  static void update_nearest(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& p,
                             Nearest& best) noexcept {
    const Corners t = mesh.corners(triangle);
    const Vec3& n = mesh.face_normals[triangle];
    const Real height = n.dot(p - t[0]);
    if (height * height > best.point.distance_sq || box_distance_sq(t, p) > best.point.distance_sq) return;
    const TrianglePoint q = nearest_on_triangle(t, n, p);
    if (q.distance_sq < best.point.distance_sq ||
        (q.distance_sq == best.point.distance_sq && triangle < best.triangle))
      best = {.point = q, .triangle = triangle};
  }

  static const Vec3& pseudo_normal(const TriangleMesh& mesh, const Nearest& at) noexcept {
    switch (at.point.feature) {
      case TriangleFeature::face: break;
      case TriangleFeature::edge: return mesh.edge_normals[at.triangle][at.point.k];
      case TriangleFeature::corner: return mesh.vertex_normals[mesh.triangles[at.triangle][at.point.k]];
    }
    return mesh.face_normals[at.triangle];
  }

  static SurfacePoint surface_point(const TriangleMesh& mesh, const Nearest& at, const Vec3& p) noexcept {
    const Vec3 a = p - at.point.p;
    const Vec3& n = pseudo_normal(mesh, at);
    const Real side = a.dot(n) < 0 ? -1 : 1;
    const Real length = std::sqrt(at.point.distance_sq);
    if (at.point.feature == TriangleFeature::face || is_touching(mesh.corners(at.triangle), p, length))
      return {.distance = side * length, .n = n};
    return {.distance = side * length, .n = direction(side * a, length, n)};
  }
};

}  // namespace godobject
