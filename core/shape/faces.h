// Faces of a mesh or height field that a sphere touches beside the nearest one.
//
// A sphere touches a surface at each local minimum of the distance from its centre. Minima lie in faces and
// on convex edges and corners. The foot of the centre may pass a concave edge, which is no minimum. The
// farther face then keeps its contact, at its distance from the edge, until the edge leaves the sphere. So
// forces do not jump. A face near the tangent plane of a nearer contact is part of that contact
// (least_face_turn). So nearly flat and convex edges are not felt. Bound: one test for each triangle within
// reach.
#pragma once

#include <algorithm>

#include "core/math/componentwise.h"
#include "core/shape/list.h"

namespace godobject {

/// True for kinds of shapes that a sphere may touch at several faces.
constexpr bool has_faces(ShapeKind kind) noexcept {
  return kind == ShapeKind::mesh || kind == ShapeKind::height_field;
}

/// Face that a sphere touches, in the shape's frame. Not initialised, because each sphere has a list of many.
struct TouchedFace {
  Real distance;    // of the sphere's centre, m
  Vec3 n, q;        // normal, and contact point on the surface
  Corners corners;  // of the nearest face, which is no triangle, its contact point
};

/// Touched faces, the nearest first.
struct TouchedFaces {
  std::array<TouchedFace, max_touched_faces> list;
  std::size_t size = 0;
  bool has_nearest = false;  // true if the first one is the nearest point of the surface, as it was given
  bool is_full = false;      // true if a sphere of the given radius touches more: the nearest are kept

  /// Inserts a face by distance, once. Returns the distance of the face that a full list has lost, or
  /// infinity.
  template <std::size_t n>
  static Real insert(const TouchedFace& face, std::array<TouchedFace, n>& list, std::size_t& size) noexcept {
    constexpr Real none = std::numeric_limits<Real>::infinity();
    const auto end = list.begin() + static_cast<std::ptrdiff_t>(size);
    const auto is_nearer = [](const TouchedFace& a, const TouchedFace& b) noexcept {
      return a.distance < b.distance;
    };
    const auto place = std::lower_bound(list.begin(), end, face, is_nearer);
    for (auto same = place; same != end && same->distance == face.distance; ++same)
      if (same->q == face.q && same->n == face.n) return none;
    if (size == n && place == end) return face.distance;
    const bool has_room = size < n;
    const Real lost = has_room ? none : list[n - 1].distance;
    std::move_backward(place, has_room ? end : end - 1, has_room ? end + 1 : end);
    *place = face;
    size += has_room ? 1 : 0;
    return lost;
  }
};

/// True if no face round the triangle's point nearest to p is nearer, except beyond a concave edge. n: normal
/// of the triangle. neighbour_normal(k): normal of the face beyond edge k.
template <class NeighbourNormal>
bool is_touched_itself(const Corners& t, const Vec3& n, const TrianglePoint& nearest, const Vec3& p,
                       NeighbourNormal neighbour_normal) noexcept {
  const Vec3 up = p - nearest.p;
  const auto is_beyond = [&](std::size_t k) noexcept {  // true if p is nearer to the face beyond edge k
    const Vec3 along = (t[(k + 1) % 3] - t[k]).normalized(), outward = along.cross(n);
    const Vec3 n_beyond = neighbour_normal(k);
    if (-n_beyond.dot(outward) > least_face_turn) return false;
    const Vec3 into = along.cross(n_beyond);
    return into.dot(up) > rounding_share * (max_component(p.cwiseAbs()) + up.norm());
  };
  switch (nearest.feature) {
    case TriangleFeature::face: return true;
    case TriangleFeature::edge: return !is_beyond(nearest.k);
    case TriangleFeature::corner: return !is_beyond(nearest.k) && !is_beyond((nearest.k + 2) % 3);
  }
  return true;
}

/// True if the normals of two contacts differ by more than least_face_turn.
inline bool is_other_normal(const Vec3& a, const Vec3& b) noexcept {
  return 2 * (1 - a.dot(b)) > least_face_turn * least_face_turn;
}
/// True if a triangle rises above the tangent plane of a contact.
inline bool rises_above(const Corners& t, const TouchedFace& contact) noexcept {
  constexpr Real least_rise_sq = least_face_turn * least_face_turn * least_face_turn * least_face_turn;
  const auto rises = [&](const Vec3& x) noexcept {
    const Vec3 from = x - contact.q;
    const Real up = contact.n.dot(from);
    return up > 0 && up * up > least_rise_sq * from.squaredNorm();
  };
  return rises(t[0]) || rises(t[1]) || rises(t[2]);
}
/// True if a face is a contact beside a nearer one: it has another normal and rises above the nearer one's
/// tangent plane. Its contact point is not below that plane.
inline bool is_beside(const TouchedFace& face, const TouchedFace& nearer) noexcept {
  const Vec3& n = nearer.n;
  const Vec3 apart = face.q - nearer.q;
  return is_other_normal(n, face.n) && n.dot(apart) >= -least_face_turn * apart.norm() &&
         rises_above(face.corners, nearer);
}

/// Finds the faces of a shape within reach of a sphere. p: its centre in the shape's frame. first_seen:
/// surface seen from p, or from where a swept sphere touched it first. nearest: point of the surface nearest
/// to p. reach: distance from p, m, >= radius. came_by(n): true if the sphere touched a face of this normal
/// before. If p is inside and an edge or corner is nearest, the faces round it then replace that edge.
template <class Shape, class CameBy>
void find_faces(const ShapeParams& par, const Vec3& p, Real radius, const SurfacePoint& first_seen,
                const Vec3& nearest, Real reach, CameBy came_by, TouchedFaces& faces) noexcept {
  std::array<TouchedFace, 4 * max_touched_faces> others;  // some of which are part of nearer ones
  std::size_t num_others = 0;
  const Vec3 q = p - first_seen.distance * first_seen.n;
  const TouchedFace first{.distance = first_seen.distance, .n = first_seen.n, .q = q, .corners = {q, q, q}};
  bool is_edge = false;
  const Real rounding = rounding_share * max_component(p.cwiseAbs());
  Shape::each_triangle(par, p, reach, [&](const Corners& t, const Vec3& n, auto neighbour_normal) noexcept {
    const Real height = n.dot(p - t[0]);
    if (!(height < reach) || (height > 0 && !rises_above(t, first))) return;
    if (box_distance_sq(t, p) > reach * reach) return;
    const TrianglePoint at = nearest_on_triangle(t, n, p);
    if (height > 0) {
      if (!(at.distance_sq < reach * reach) || !is_touched_itself(t, n, at, p, neighbour_normal)) return;
      const Real distance = std::sqrt(at.distance_sq);
      const bool in_face = at.feature == TriangleFeature::face || is_touching(t, p, distance);
      const TouchedFace face{
          .distance = distance, .n = in_face ? n : Vec3((p - at.p) / distance), .q = at.p, .corners = t};
      if (!is_beside(face, first)) return;
      faces.is_full |= TouchedFaces::insert(face, others, num_others) < radius;
    } else if ((at.p - nearest).norm() <= rounding - rounding_share * height) {
      // p is behind a face that meets the nearest point
      is_edge = is_edge || (is_other_normal(n, first.n) && came_by(n));
      const TouchedFace face{.distance = height, .n = n, .q = at.p, .corners = t};
      faces.is_full |= TouchedFaces::insert(face, others, num_others) < radius;
    }
  });
  faces.size = 0;
  faces.has_nearest = !is_edge;
  if (faces.has_nearest) faces.list[faces.size++] = first;
  for (std::size_t i = 0; i < num_others; ++i) {
    if (!is_edge && others[i].distance <= 0) continue;
    const auto beside = [&](const TouchedFace& nearer) noexcept { return is_beside(others[i], nearer); };
    if (!std::all_of(faces.list.begin(), faces.list.begin() + static_cast<std::ptrdiff_t>(faces.size),
                     beside))
      continue;
    if (faces.size == max_touched_faces) {
      faces.is_full |= others[i].distance < radius;
      break;
    }
    faces.list[faces.size++] = others[i];
  }
}

}  // namespace godobject
