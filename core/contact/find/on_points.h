// Contacts of the points of shapes, of bodies and of the world, with shapes of each other.
//
// Spheres of a body touch instead of the points that they round. Each contact has one finder: the centre of
// the rounder shape. So a ball's centre touches capsules and boxes, ends of capsules touch boxes, and corners
// touch the sides of capsules and the faces of boxes. Of two points the one touches that no sphere rounds, or
// that of the first body. Bound: for each two shapes that are near, a query for each point.
#pragma once

#include "core/contact/find/on_shape.h"

namespace godobject {

/// Returns the number of the point of a round shape that is nearest to p_W. Of a ball the centre, of a
/// capsule the end beyond which p_W lies. Returns max_points if there is none.
inline std::uint32_t point_towards(const PlacedShape& shape, const Vec3& p_W) noexcept {
  if (shape.kind() == ShapeKind::sphere) return 0;
  if (shape.kind() != ShapeKind::capsule) return max_points;
  const Real z = shape.R_WS().col(2).dot(p_W - shape.p_W());
  return z <= -shape.half_length() ? 0 : z >= shape.half_length() ? 1 : max_points;
}

/// True if point j of shape s at p_W finds the contact with shape o. Of two ends of capsules each must be
/// nearest to the other. is_first: true if shape s is of the contact's first body.
template <class Contacts, std::size_t N>
bool is_finder(const ContactFinder<Contacts, N>& w, std::uint32_t s, std::uint32_t j, const Vec3& p_W,
               std::uint32_t o, bool is_first) noexcept {
  const PlacedShape &of = w.placed[s], &on = w.placed[o];
  const std::uint32_t other = point_towards(on, p_W);
  if (other >= max_points) return true;
  if (of.kind() != on.kind()) return of.kind() == ShapeKind::sphere;
  const Vec3 other_W = on.p_W() + on.R_WS() * point_of(on.in_world(), other, on.radius()).p_S;
  return (w.rounded[o] >> other & 1) == 0 && is_first && point_towards(of, other_W) == j;
}

/// Finds the contacts of the points of surfaces [s, s_end) of body a with surfaces [o, o_end) of body b. One
/// of both may be the world, N. key: of the pair of bodies, and of the side of a. is_first: true if a is the
/// first body of the pair.
template <class Contacts, std::size_t N>
void find_on_points(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t s,
                    std::uint32_t s_end, std::uint32_t b, const std::uint32_t first, std::uint32_t o_end,
                    std::uint64_t key, bool is_first, const Vec3* leaving_W,
                    NearContacts<Contacts::max_contacts>& near) noexcept {
  using Finder = ContactFinder<Contacts, N>;
  const Real travel = (a < N ? w.owned[a].travel : 0) + (b < N ? w.owned[b].travel : 0);
  for (; s < s_end; ++s) {
    const PlacedShape& of = w.placed[s];
    const std::uint32_t num = num_points(of.kind());
    if (!has_points(of.kind(), w.rounded[s])) continue;
    const Vec3 half_S = points_apart(of.in_world());
    // a corner whose ball is near is within two diameters of the ball
    const Real reach = travel + (of.kind() == ShapeKind::box ? 4 * corner_ball * half_thickness(of.in_world())
                                                             : (1 + contact_reach) * of.radius());
    for (std::uint32_t o = first; o < o_end; ++o) {
      const PlacedShape& on = w.placed[o];
      if (is_carried(on.kind())) {
        const Vec3 from_nearest = (of.R_WS().transpose() * (on.p_W() - of.p_W())).cwiseAbs() - half_S;
        const Real round = reach + ball_round(on);
        if (from_nearest.squaredNorm() > round * round) continue;
      }
      const Real thinnest = std::min(half_thickness(of.in_world()), half_thickness(on.in_world()));
      for (std::uint32_t j = 0; j < num; ++j) {
        if ((w.rounded[s] >> j & 1) != 0) continue;
        const ShapePoint point = point_of(of.in_world(), j, thinnest);
        const Vec3 p_W = of.p_W() + of.R_WS() * point.p_S;
        if (!is_finder(w, s, j, p_W, o, is_first)) continue;
        const auto number = static_cast<std::uint32_t>(Finder::max_spheres + max_points * s + j);
        const TouchingBall ball{.key = key | touch_key(number, o),
                                .of = s,
                                .body = a,
                                .p_W = p_W,
                                .r = point.r,
                                .tip_W = of.R_WS() * point.tip_S,
                                .is_corner = of.kind() == ShapeKind::box};
        find_on_shape(w, ball, b, o, travel, leaving_W, near, true);
      }
    }
  }
}

}  // namespace godobject
