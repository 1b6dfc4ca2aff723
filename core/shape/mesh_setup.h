// Setup of a triangle mesh before the first step: checks, pseudo-normals and grid, in arrays of the caller.
#pragma once

#include "core/math/angle.h"
#include "core/shape/mesh.h"

namespace godobject {

/// First rule that a mesh breaks, or the array that is too small for it.
enum class MeshInvalid : std::uint8_t {
  nothing,
  no_triangle,          // no triangles, or 2^30 and more
  vertex_not_finite,    // `number` is the vertex
  index_out_of_range,   // `number` is the triangle, here and below
  degenerate_triangle,  // height below 1e-9 of the longest edge
  not_closed,           // an edge without exactly one other triangle running along it in the other direction
  folded,               // two triangles on an edge, or all on a vertex, cancel each other's normals
  inside_out,           // encloses a negative volume: clockwise triangles
  normals_full,         // a per-triangle or per-vertex array is shorter than the mesh
  spacing,              // the spacing of the grid is not positive or not finite
  cells_full,           // `number` cells needed: storage for one more, or a wider spacing
  cell_triangles_full,  // `number` entries needed
};

struct MeshReport {
  MeshInvalid invalid = MeshInvalid::nothing;
  std::size_t number = 0;
};

/// Arrays for derived data; they must live as long as the mesh.
struct MeshStorage {
  std::span<Vec3> face_normals;             // num_triangles
  std::span<EdgeNormals> edge_normals;      // num_triangles
  std::span<Vec3> vertex_normals;           // num_vertices
  std::span<std::uint32_t> half_edges;      // 3 num_triangles; unused after the setup
  std::span<std::uint32_t> cell_start;      // one more than cells in the grid
  std::span<std::uint32_t> cell_triangles;  // one for every triangle in every cell it touches
};

namespace mesh_setup {

inline MeshReport check_triangles(const TriangleMesh& mesh) noexcept {
  if (mesh.triangles.empty() || mesh.triangles.size() >= (std::size_t(1) << 30))
    return {.invalid = MeshInvalid::no_triangle};
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    if (!(mesh.vertices[v].sum() - mesh.vertices[v].sum() == 0)) return {MeshInvalid::vertex_not_finite, v};
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (const std::uint32_t v : mesh.triangles[t])
      if (v >= mesh.vertices.size()) return {MeshInvalid::index_out_of_range, t};
    const Corners c = mesh.corners(t);
    const Vec3 a = c[1] - c[0], b = c[2] - c[0];
    const Real longest_sq = std::max({a.squaredNorm(), b.squaredNorm(), (b - a).squaredNorm()});
    if (!(a.cross(b).norm() > input_tolerance * longest_sq)) return {MeshInvalid::degenerate_triangle, t};
  }
  return {};
}

/// Normalises a sum of unit normals. Returns false if they cancel.
inline bool normalise(Vec3& n) noexcept {
  const Real length = n.norm();
  if (!(length > input_tolerance)) return false;
  n /= length;
  return true;
}

/// Computes unit face normals, and vertex normals weighted by the triangles' angles.
inline MeshReport make_face_and_vertex_normals(const TriangleMesh& mesh, const MeshStorage& to) noexcept {
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) to.vertex_normals[v].setZero();
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners c = mesh.corners(t);
    const Vec3 n = (c[1] - c[0]).cross(c[2] - c[0]).normalized();
    to.face_normals[t] = n;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 a = c[(k + 1) % 3] - c[k], b = c[(k + 2) % 3] - c[k];
      to.vertex_normals[mesh.triangles[t][k]] += angle_of(a.cross(b).norm(), a.dot(b)) * n;
    }
  }
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (const std::uint32_t v : mesh.triangles[t])
      if (!normalise(to.vertex_normals[v])) return {MeshInvalid::folded, t};
  return {};
}

/// Half-edge from its first to its second vertex; half-edge 3 t + k is edge k of triangle t.
struct HalfEdge {
  std::uint32_t from, to;
};
inline HalfEdge half_edge(const TriangleMesh& mesh, std::uint32_t e) noexcept {
  const TriangleIndices& t = mesh.triangles[e / 3];
  return {t[e % 3], t[(e + 1) % 3]};
}

/// Pairs the half-edges by sorting, checks that the surface is closed, and adds their face normals.
inline MeshReport make_edge_normals(const TriangleMesh& mesh, const MeshStorage& to) noexcept {
  const std::size_t num = 3 * mesh.triangles.size();
  const std::span<std::uint32_t> sorted = to.half_edges.first(num);
  for (std::size_t e = 0; e < num; ++e) sorted[e] = std::uint32_t(e);
  const auto key = [&](std::uint32_t e) {
    const HalfEdge h = half_edge(mesh, e);
    return std::uint64_t(std::min(h.from, h.to)) << 32 | std::max(h.from, h.to);
  };
  std::ranges::sort(sorted, [&](auto a, auto b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  for (std::size_t s = 0; s < num; s += 2) {
    const std::uint32_t a = sorted[s], b = s + 1 < num ? sorted[s + 1] : a;
    const bool third = s + 2 < num && key(sorted[s + 2]) == key(a);
    if (key(a) != key(b) || half_edge(mesh, a).from == half_edge(mesh, b).from || third)
      return {MeshInvalid::not_closed, a / 3};
    Vec3 n = to.face_normals[a / 3] + to.face_normals[b / 3];
    if (!normalise(n)) return {MeshInvalid::folded, a / 3};
    to.edge_normals[a / 3][a % 3] = n;
    to.edge_normals[b / 3][b % 3] = n;
  }
  return {};
}

/// Returns six times the enclosed volume, about a vertex of the mesh, m^3.
inline Real volume_6(const TriangleMesh& mesh) noexcept {
  const Vec3 o = mesh.corners(0)[0];
  Real sum = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Corners c = mesh.corners(t);
    sum += (c[0] - o).dot((c[1] - o).cross(c[2] - o));
  }
  return sum;
}

/// Calls f(cell index) for the cells whose circumscribed sphere touches the triangle, a superset of the cells
/// that it crosses.
template <class F>
void for_each_cell_of(const TriangleMesh& mesh, std::size_t triangle, F&& f) noexcept {
  const MeshGrid& grid = mesh.grid;
  const Corners t = mesh.corners(triangle);
  const auto [low, high] = box_of(t);
  const Real radius_sq = cell_radius_sq * grid.spacing * grid.spacing;
  for_each_cell(grid, low, high, [&](auto i, auto j, auto k) {
    const Vec3 centre = grid.lower_corner(i, j, k) + Vec3::Constant(grid.spacing / 2);
    const TrianglePoint q = nearest_on_triangle(t, mesh.face_normals[triangle], centre);
    if (q.distance_sq <= radius_sq) f(grid.index(i, j, k));
  });
}

/// Computes the grid's box and numbers of cells.
inline MeshReport lay_out_grid(TriangleMesh& mesh, Real spacing, std::size_t max_cells) noexcept {
  Vec3 low = mesh.vertices[0], high = low;
  for (const Vec3& v : mesh.vertices) {
    low = componentwise_min(low, v);
    high = componentwise_max(high, v);
  }
  mesh.grid.origin = low;
  mesh.grid.spacing = spacing;
  Real cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Real num = (high - low)[Eigen::Index(axis)] / spacing + 1;
    if (!(num < Real(1u << 30))) return {MeshInvalid::cells_full, std::size_t(-1)};
    mesh.grid.num[axis] = std::uint32_t(num);
    cells *= mesh.grid.num[axis];
  }
  if (!(cells < Real(1u << 31))) return {MeshInvalid::cells_full, std::size_t(-1)};
  if (!(cells <= Real(max_cells))) return {MeshInvalid::cells_full, std::size_t(cells)};
  return {};
}

/// Counts the triangles of every cell, then lists them, cell after cell.
inline MeshReport fill_grid(TriangleMesh& mesh, const MeshStorage& to) noexcept {
  MeshGrid& grid = mesh.grid;
  const std::size_t cells = std::size_t(grid.num[0]) * grid.num[1] * grid.num[2];
  const std::span<std::uint32_t> start = to.cell_start.first(cells + 1);
  std::ranges::fill(start, 0u);
  std::size_t entries = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    for_each_cell_of(mesh, t, [&](std::size_t cell) {
      ++start[cell];
      ++entries;
    });
  }
  const std::size_t room =
      std::min(to.cell_triangles.size(), std::size_t(std::numeric_limits<std::uint32_t>::max()));
  if (entries > room) return {MeshInvalid::cell_triangles_full, entries};

  // Sums of the counts are the end of each cell's list. Lists are filled from the back, which moves each end
  // to the start.
  for (std::size_t c = 1; c <= cells; ++c) start[c] += start[c - 1];
  for (std::size_t t = mesh.triangles.size(); t-- > 0;)
    for_each_cell_of(mesh, t, [&](std::size_t cell) { to.cell_triangles[--start[cell]] = std::uint32_t(t); });
  grid.start = start;
  grid.triangles = to.cell_triangles.first(entries);
  return {};
}

}  // namespace mesh_setup

/// Prepares `mesh` for queries. It refers to the arrays given, which the caller keeps. grid_spacing: edge of
/// the grid's cells, m; about the reach of the queries or the edges of the triangles, whichever is longer. On
/// a report other than `nothing` the mesh has no grid, and MeshShape::is_valid() rejects it.
inline MeshReport set_up_mesh(std::span<const Vec3> vertices, std::span<const TriangleIndices> triangles,
                              Real grid_spacing, const MeshStorage& to, TriangleMesh& mesh) noexcept {
  using namespace mesh_setup;
  mesh = {};
  mesh.vertices = vertices;
  mesh.triangles = triangles;
  MeshReport report = check_triangles(mesh);
  const auto ok = [&] { return report.invalid == MeshInvalid::nothing; };
  if (!ok()) return report;
  if (!is_dimension(grid_spacing)) return {.invalid = MeshInvalid::spacing};
  const std::size_t num = triangles.size();
  if (to.face_normals.size() < num || to.edge_normals.size() < num || to.half_edges.size() < 3 * num ||
      to.vertex_normals.size() < vertices.size() || to.cell_start.empty())
    return {.invalid = MeshInvalid::normals_full};

  report = make_face_and_vertex_normals(mesh, to);
  if (ok()) report = make_edge_normals(mesh, to);
  if (ok() && !(volume_6(mesh) > 0)) report = {.invalid = MeshInvalid::inside_out};
  if (!ok()) return report;
  mesh.face_normals = to.face_normals.first(num);
  mesh.edge_normals = to.edge_normals.first(num);
  mesh.vertex_normals = to.vertex_normals.first(vertices.size());

  report = lay_out_grid(mesh, grid_spacing, to.cell_start.size() - 1);
  if (ok()) report = fill_grid(mesh, to);
  return report;
}

}  // namespace godobject
