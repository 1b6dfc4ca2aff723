// Faces of nets: triangles of their surfaces, which nodes touch.
//
// A node at p touches a face at its nearest point q = sum w_m p_m, w_m >= 0, sum w_m = 1. A force F on the
// node is balanced by -w_m F on the nodes of the face, so momentum is conserved.
#pragma once

#include <algorithm>

#include "core/math/componentwise.h"
#include "core/math/triangle.h"
#include "core/net/net.h"

namespace godobject {

/// Point of a triangle by its weights, which sum to 1.
struct FacePoint {
  Vec3 weights = Vec3::UnitX();

  /// Returns the weighted sum of three numbers or vectors.
  template <class T>
  T of(const std::array<T, 3>& t) const noexcept {
    return t[0] * weights[0] + t[1] * weights[1] + t[2] * weights[2];
  }
};

/// Returns the weights at which p projects onto the plane of a triangle. Not finite without an area.
inline Vec3 projected_weights(const Corners& t, const Vec3& p) noexcept {
  const Vec3 e = t[1] - t[0], f = t[2] - t[0], x = p - t[0], n = e.cross(f);
  const Real area_sq = n.squaredNorm(), b = x.cross(f).dot(n) / area_sq, c = e.cross(x).dot(n) / area_sq;
  return {1 - b - c, b, c};
}

/// Returns the point of a triangle nearest to p. The triangle may be without area.
inline FacePoint nearest_on_face(const Corners& t, const Vec3& p) noexcept {
  const Vec3 inside = projected_weights(t, p);
  if (min_component(inside) >= 0) return {inside};
  FacePoint best;
  Real least = std::numeric_limits<Real>::infinity();
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    const Vec3 &a = t[static_cast<std::size_t>(k)], e = t[static_cast<std::size_t>(next)] - a;
    const Real length_sq = e.squaredNorm(), along = e.dot(p - a);
    const Real s = along > 0 ? std::min(along / length_sq, Real(1)) : 0;
    const Real distance_sq = (a + s * e - p).squaredNorm();
    if (!(distance_sq < least)) continue;
    least = distance_sq;
    best.weights.setZero();
    best.weights[k] = 1 - s;
    best.weights[next] = s;
  }
  return best;
}

/// Returns the axes of a triangle as columns: along its first edge, across it, and its normal.
inline Mat3 axes_of_face(const Corners& t) noexcept {
  const auto unit = [](const Vec3& a, const Vec3& otherwise) noexcept -> Vec3 {
    const Real length = a.norm();
    return length > 0 ? Vec3(a / length) : otherwise;
  };
  const Vec3 x = unit(t[1] - t[0], Vec3::UnitX()),
             any = std::abs(x.x()) < 0.5 ? Vec3::UnitX() : Vec3::UnitY();
  const Vec3 z = unit(x.cross(t[2] - t[0]), unit(x.cross(any), Vec3::UnitZ()));
  Mat3 R;
  R << x, z.cross(x), z;
  return R;
}

/// True if a point crosses a triangle on the way from p_0 and t_0 to p and t.
inline bool crosses_face(const Corners& t_0, const Vec3& p_0, const Corners& t, const Vec3& p) noexcept {
  const auto side = [](const Corners& of, const Vec3& at) noexcept {
    return (of[1] - of[0]).cross(of[2] - of[0]).dot(at - of[0]);
  };
  const Real before = side(t_0, p_0), after = side(t, p);
  if (!(before * after < 0)) return false;
  const Real s = before / (before - after);
  Corners at;
  for (std::size_t k = 0; k < 3; ++k) at[k] = t_0[k] + s * (t[k] - t_0[k]);
  return min_component(projected_weights(at, p_0 + s * (p - p_0))) >= -face_rim;
}

/// Returns the row of a node; the number of rows if no spring holds it. Rows are in the order of their nodes.
template <class Params>
std::size_t row_of_node(const Params& par, std::uint32_t n) noexcept {
  const auto begin = par.rows.begin(), end = begin + static_cast<std::ptrdiff_t>(par.num_rows);
  const auto at = std::partition_point(begin, end, [n](const NodeRow& row) noexcept { return row.end <= n; });
  return at != end && at->holds(n) ? static_cast<std::size_t>(at - begin) : par.num_rows;
}

/// Orders faces by their rows, and within a row so that halves of each range are apart in space. Faces of
/// missing nodes stay in place for are_valid_faces() to reject.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
void put_faces_in_order(NetParams<max_nodes, max_springs, max_attachments, max_faces>& par) noexcept {
  if constexpr (max_faces > 0) {
    auto& faces = par.faces;
    faces.num_patches = 0;
    if (faces.size > max_faces) return;
    for (std::size_t f = 0; f < faces.size; ++f)
      for (const std::uint32_t n : faces.list[f].nodes)
        if (n >= par.num_nodes) return;
    const auto row_of = [&](const NetFace& face) noexcept { return row_of_node(par, face.nodes[0]); };
    const auto first = faces.list.begin();
    std::sort(first, first + static_cast<std::ptrdiff_t>(faces.size),
              [&](const NetFace& a, const NetFace& b) {
                const std::size_t row_a = row_of(a), row_b = row_of(b);
                return row_a != row_b ? row_a < row_b : a.nodes < b.nodes;
              });
    for (std::uint32_t f = 0; f < faces.size;) {
      const std::size_t k = row_of(faces.list[f]);
      if (k == par.num_rows) return;
      NetPatch patch{.first_node = par.rows[k].first, .end_node = par.rows[k].end, .first = f};
      for (; f < faces.size && row_of(faces.list[f]) == k; ++f)
        patch.touches_own = patch.touches_own || faces.list[f].touches_own;
      patch.end = f;
      split_in_space(par, patch.first, patch.end);
      faces.patches[faces.num_patches++] = patch;
    }
  }
}

/// Orders a range of faces by halves along its longest extent, and both halves likewise.
template <class Params>
void split_in_space(Params& par, std::uint32_t first, std::uint32_t end) noexcept {
  if (end - first < 2) return;
  const auto centre = [&](const NetFace& face) noexcept -> Vec3 {
    return par.nodes[face.nodes[0]].p_B + par.nodes[face.nodes[1]].p_B + par.nodes[face.nodes[2]].p_B;
  };
  Vec3 low = centre(par.faces.list[first]), high = low;
  for (std::uint32_t f = first; f < end; ++f) {
    low = componentwise_min(low, centre(par.faces.list[f]));
    high = componentwise_max(high, centre(par.faces.list[f]));
  }
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::uint32_t middle = first + (end - first) / 2;
  const auto begin = par.faces.list.begin();
  std::nth_element(begin + first, begin + middle, begin + end, [&](const NetFace& a, const NetFace& b) {
    const Real x = centre(a)[axis], y = centre(b)[axis];
    return x != y ? x < y : a.nodes < b.nodes;
  });
  split_in_space(par, first, middle);
  split_in_space(par, middle, end);
}

/// True if the faces were put in order, and each has three nodes of one row and one carrier.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
bool are_valid_faces(const NetParams<max_nodes, max_springs, max_attachments, max_faces>& par) noexcept {
  if constexpr (max_faces == 0) return true;
  else {
    const auto& faces = par.faces;
    if (faces.size > max_faces || faces.num_patches > par.num_rows) return false;
    std::uint32_t end = 0;
    for (std::size_t k = 0; k < faces.num_patches; ++k) {
      const NetPatch& patch = faces.patches[k];
      if (patch.first != end || patch.end <= end || patch.end > faces.size) return false;
      for (end = patch.first; end < patch.end; ++end) {
        const auto& n = faces.list[end].nodes;
        for (std::size_t j = 0; j < 3; ++j)
          if (n[j] < patch.first_node || n[j] >= patch.end_node || n[j] == n[(j + 1) % 3] ||
              par.nodes[n[j]].body != par.nodes[n[0]].body)
            return false;
      }
    }
    return end == faces.size;
  }
}

/// True if a spring joins two nodes. Springs are in order.
template <class Params>
bool are_joined(const Params& par, std::uint32_t i, std::uint32_t j) noexcept {
  const auto ends = std::minmax(i, j);
  const auto begin = par.springs.begin(), end = begin + static_cast<std::ptrdiff_t>(par.num_springs);
  const auto at = std::lower_bound(begin, end, ends, [](const NetSpring& s, const auto& of) noexcept {
    return s.i != of.first ? s.i < of.first : s.j < of.second;
  });
  return at != end && at->i == ends.first && at->j == ends.second;
}

/// True if a node of the net or carrier of a face is never in contact with it. It is part of the face or
/// joined to it, or within `thickness` of it in the nets' own shape.
template <class Params>
bool are_neighbours(const Params& par, std::uint32_t n, const NetFace& face, Real thickness) noexcept {
  Corners t;
  for (std::size_t j = 0; j < 3; ++j) {
    const std::uint32_t m = face.nodes[j];
    if (m == n || are_joined(par, n, m)) return true;
    t[j] = par.nodes[m].p_B;
  }
  const Vec3& p = par.nodes[n].p_B;
  return (nearest_on_face(t, p).of(t) - p).squaredNorm() <= thickness * thickness;
}

}  // namespace godobject
