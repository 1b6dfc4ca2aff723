// Contacts of one ball with one shape: a sphere of a body, or a point of a shape (core/shape/points.h).
#pragma once

#include "core/contact/find/on_faces.h"
#include "core/contact/find/sweep.h"

namespace godobject {

/// Ball that touches shapes. Its own body may be the world if the shape's body is not.
struct TouchingBall {
  std::uint64_t key = 0;
  std::uint32_t of = 0, body = 0;  // element, as in NearContact, and its body
  Vec3 p_W = Vec3::Zero();         // centre, m
  Real r = 0;                      // radius, m
  Vec3 tip_W = Vec3::Zero();       // corner of a box, from the centre; zero: the ball itself touches
  bool is_corner = false;

  /// Returns the distance of the contact point from the centre along -n, m.
  Real reach_along(const Vec3& n_W) const noexcept { return is_corner ? -n_W.dot(tip_W) : r; }
};

/// Returns the contact of a ball with the shape o of body b, seen from the ball's centre. Contact points of
/// round shapes lie midway, so that the order of the bodies does not matter. Contacts of the world's points
/// are turned round, because the first body of a contact is none of the world.
template <std::size_t N>
NearContact contact_of(const TouchingBall& ball, const PlacedShape& shape, std::uint32_t b, std::uint32_t o,
                       const SurfacePoint& seen, bool is_point) noexcept {
  const Real from_centre = ball.reach_along(seen.n), d = from_centre - seen.distance;
  NearContact at{.key = ball.key,
                 .of = ball.of,
                 .on = o,
                 .a = ball.body,
                 .b = b,
                 .d = d,
                 .p_W = ball.is_corner ? Vec3(ball.p_W + ball.tip_W) : Vec3(ball.p_W - from_centre * seen.n),
                 .n_W = seen.n};
  if (is_point && !ball.is_corner && round_radius(shape.in_world()) > 0) at.p_W += d / 2 * seen.n;
  if (ball.body < N) return at;
  std::swap(at.of, at.on);
  std::swap(at.a, at.b);
  at.n_W = -at.n_W;
  return at;
}

/// Finds the contacts of a ball with the surface o of body b. travel: bound of their relative motion in the
/// stage, m. leaving_W: as in find_on_surfaces(). is_point: the ball is a point of a shape.
template <class Contacts, std::size_t N>
void find_on_shape(const ContactFinder<Contacts, N>& w, const TouchingBall& ball, std::uint32_t b,
                   std::uint32_t o, Real travel, const Vec3* leaving_W,
                   NearContacts<Contacts::max_contacts>& near, bool is_point = false) noexcept {
  const PlacedShape& shape = w.placed[o];
  const Vec3& p_W = ball.p_W;
  const Real r = ball.r, corner = ball.is_corner ? ball.tip_W.norm() - r : 0,
             reach = contact_reach * r + travel + corner;
  SurfacePoint surface = nearest(shape.in_world(), p_W, r + reach);
  const auto found = [&](const SurfacePoint& touched) noexcept {
    if (has_faces(shape.kind())) {
      const NearContact contact{.key = ball.key, .of = ball.of, .on = o, .a = ball.body, .b = b};
      find_on_faces(w, contact, shape, p_W, r, touched, surface, travel, near);
    } else {
      add_near(w, contact_of<N>(ball, shape, b, o, touched, is_point), contact_reach * r, near);
    }
  };
  if (travel > r || surface.distance < 0) {
    const Vec3 way_W = -w.since() * (swept_velocity_at(w, ball.body, p_W) - swept_velocity_at(w, b, p_W));
    const SweptContact touch = swept(shape, p_W, way_W, r);
    if (touch.touches) return found({.distance = r - touch.depth, .n = touch.n_W});
    if (shape.kind() == ShapeKind::box && (surface.distance < 0 || touch.was_inside))
      surface = behind_face_before(ball.key, *w.before, shape, p_W, surface, ball.body < N ? 1 : -1);
  }
  const Real depth = r - surface.distance;
  if (depth <= -reach || (leaving_W != nullptr && leaving_W->dot(surface.n) < 0)) return;
  found(surface);
}

}  // namespace godobject
