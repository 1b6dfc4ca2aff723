// Direction in which deeply overlapping bodies separate.
//
// All spheres of such a pair, of both bodies, are pushed out through the faces along one direction. With the
// nearest face for each sphere, the forces would oppose each other, and the bodies would lock.
#pragma once

#include "core/contact/find/world_geometry.h"
#include "core/math/componentwise.h"

namespace godobject {

/// Transforms four points into the frame of a shape.
inline Vector3<Pack> in_frame(const Vec3& p_WS, const Mat3& R_WS, const Vector3<Pack>& p_W) noexcept {
  Vector3<Pack> apart, p_S;
  for (int k = 0; k < 3; ++k) apart[k] = p_W[k] - Pack(p_WS[k]);
  for (int k = 0; k < 3; ++k) p_S[k] = R_WS(0, k) * apart[0] + R_WS(1, k) * apart[1] + R_WS(2, k) * apart[2];
  return p_S;
}

/// Direction in the world and distance to the exit.
struct ExitDirection {
  Vec3 n_W = Vec3::UnitZ();
  Real distance = std::numeric_limits<Real>::infinity();
};

/// Returns the lowest coordinate of the surfaces of the spheres along a direction.
inline Real lowest_along(const Vec3& n_W, const SpherePack* packs, std::uint32_t num_packs) noexcept {
  Pack lowest = std::numeric_limits<Real>::infinity();
  for (std::uint32_t k = 0; k < num_packs; ++k) {
    const Vector3<Pack>& p = packs[k].p_W;
    lowest = min(lowest, n_W.x() * p[0] + n_W.y() * p[1] + n_W.z() * p[2] - packs[k].r);
  }
  return std::min({lowest[0], lowest[1], lowest[2], lowest[3]});
}
/// Returns the extent of a shape in a direction.
inline Real reach_along(const Vec3& n_W, const PlacedShape& shape) noexcept {
  const Vec3 n_S = shape.R_WS().transpose() * n_W;
  return n_W.dot(shape.p_W()) + n_S.cwiseAbs().dot(half_extents(shape.in_world()));
}
/// Returns the outward normal of a face of a box: those along x, -x, y, -y, z, -z.
inline Vec3 face_normal(const PlacedShape& box, int face) noexcept {
  const Vec3 n_W = box.R_WS().col(face / 2);
  return face % 2 == 0 ? n_W : Vec3(-n_W);
}

/// Returns the shortest way by which all spheres of a body leave the surfaces [first, end), through a face of
/// one of the boxes. pushed_W: force on the body by these surfaces in the previous step, N; if not zero, the
/// face must point along it.
template <class Contacts, std::size_t N>
ExitDirection exit_direction(const ContactFinder<Contacts, N>& w, std::uint32_t first, std::uint32_t end,
                             std::uint32_t body, const Vec3& pushed_W) noexcept {
  ExitDirection shortest;
  const Real least_along = same_contact * pushed_W.norm();
  const auto& owned = w.owned[body];
  const SpherePack* const packs = w.packs.data() + owned.first_pack;
  if (owned.num_packs() == 0) return shortest;
  for (std::uint32_t o = first; o < end; ++o) {
    for (int face = 0; face < 6 && w.placed[o].kind() == ShapeKind::box; ++face) {
      const Vec3 n_W = face_normal(w.placed[o], face);
      if (n_W.dot(pushed_W) < least_along) continue;
      Real up = -std::numeric_limits<Real>::infinity();
      for (std::uint32_t k = first; k < end; ++k) up = std::max(up, reach_along(n_W, w.placed[k]));
      const Real distance = up - lowest_along(n_W, packs, owned.num_packs());
      if (distance < shortest.distance) shortest = {.n_W = n_W, .distance = distance};
    }
  }
  return shortest;
}

/// Returns the shortest way of body a out of body b: of its spheres out of b's surfaces, or of b's spheres
/// out of its own. pushed_W: force on a by b in the previous step, N. Separation continues along it, because
/// nearer faces would let the bodies pass through each other's sides (test_tunnelling.cc).
template <class Contacts, std::size_t N>
Vec3 separation_direction(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b,
                          const Vec3& pushed_W) noexcept {
  const auto out_of = [&](std::uint32_t of, std::uint32_t body, const Vec3& pushed) noexcept {
    return exit_direction(w, w.owned[of].first_surface, w.owned[of].end_surface, body, pushed);
  };
  const ExitDirection a_moves = out_of(b, a, pushed_W), b_moves = out_of(a, b, -pushed_W);
  return a_moves.distance <= b_moves.distance ? a_moves.n_W : Vec3(-b_moves.n_W);
}

/// Axis along which two bodies with sunk boxes separate: the normal of a face of one of the boxes, off that
/// body. Spheres and edges of such a pair detect nothing, or push in all directions.
struct SinkingAxis {
  static constexpr std::uint32_t none = ~std::uint32_t(0);
  std::uint32_t number = none;  // packed axis id: box on its body, body a or b, face 0 to 5
  Vec3 n_W = Vec3::UnitZ();     // normal, from b to a
  Real depth = std::numeric_limits<Real>::infinity();
  Vec3 p_W = Vec3::Zero();  // point that is deepest behind the face, m

  static constexpr std::uint32_t of(std::uint32_t box, bool of_a, int face) noexcept {
    return box << 4 | (of_a ? 8u : 0u) | static_cast<std::uint32_t>(face);
  }
};

/// Part of a body that is farthest in a direction.
struct Farthest {
  Real reach = -std::numeric_limits<Real>::infinity();  // coordinate along the direction, m
  Vec3 p_W = Vec3::Zero();                              // m
  Real flat = 0;  // 1 for a face of a box across the direction, 0 for an edge or corner
};

/// Returns the part of a body, with its spheres and shapes, that is farthest in a direction. Its point is in
/// the middle of an edge or face across the direction.
template <class Contacts, std::size_t N>
Farthest farthest_along(const ContactFinder<Contacts, N>& w, std::uint32_t body, const Vec3& n_W) noexcept {
  const auto& owned = w.owned[body];
  const Real tilt = std::sqrt(1 - same_normal * same_normal);  // sine of an edge that is hardly across
  Farthest farthest;
  for (std::uint32_t o = owned.first_surface; o < owned.end_surface; ++o) {
    const PlacedShape& shape = w.placed[o];
    const Real reach = reach_along(n_W, shape);
    if (reach <= farthest.reach) continue;
    const Vec3 side = nearest_in_box(shape.R_WS().transpose() * n_W / tilt, -Vec3::Ones(), Vec3::Ones());
    farthest = {.reach = reach,
                .p_W = shape.p_W() + shape.R_WS() * points_apart(shape.in_world()).cwiseProduct(side),
                .flat = shape.kind() == ShapeKind::box ? std::max(2 - side.cwiseAbs().sum(), Real(0)) : 0};
  }
  for (std::uint32_t s = 0; s < owned.end_sphere - owned.first_sphere; ++s) {
    const Sphere one = sphere(&w.packs[owned.first_pack], s);
    const Real reach = n_W.dot(one.p_W) + one.r;
    if (reach > farthest.reach + rounding_tolerance * one.r) farthest = {.reach = reach, .p_W = one.p_W};
  }
  return farthest;
}

/// Returns the axis along which bodies a and b are least deep, or the axis of the given number, if any.
template <class Contacts, std::size_t N>
SinkingAxis sinking_axis(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b,
                         std::uint32_t number) noexcept {
  SinkingAxis least;
  for (const bool of_a : {true, false}) {
    const auto& owned = w.owned[of_a ? a : b];
    for (std::uint32_t o = owned.first_surface; o < owned.end_surface; ++o) {
      for (int face = 0; face < 6 && w.placed[o].kind() == ShapeKind::box; ++face) {
        const std::uint32_t one = SinkingAxis::of(o - owned.first_surface, of_a, face);
        if (number != SinkingAxis::none && one != number) continue;
        const Vec3 n_W = face_normal(w.placed[o], of_a ? face ^ 1 : face);
        const Farthest of_b = farthest_along(w, b, n_W), on_a = farthest_along(w, a, -n_W);
        const Real depth = of_b.reach + on_a.reach;
        if (depth >= least.depth) continue;
        const Farthest &behind = of_a ? of_b : on_a, &front = of_a ? on_a : of_b;
        // midway between two faces, so that the order of the bodies does not matter
        const Vec3 p_W = behind.p_W + behind.flat / 2 * (front.p_W - behind.p_W);
        least = {.number = one, .n_W = n_W, .depth = depth, .p_W = p_W};
      }
    }
  }
  return least;
}

}  // namespace godobject
