// Sweep of shapes that move farther in a stage than their size. Their contacts are at the first touch along
// the path.
//
// At the predicted end of a stage, a fast sphere may be past the middle of a solid or behind the edge that it
// crossed. The nearest face there is not the one of entry and would let it pass.
#pragma once

#include "core/contact/find/edges.h"

namespace godobject {

/// Returns nearest(); for a box by its matrix, equal up to rounding and faster.
inline SurfacePoint nearest_of(const PlacedShape& shape, const Vec3& p_W, Real reach) noexcept {
  if (shape.kind() != ShapeKind::box) return nearest(shape.in_world(), p_W, reach);
  const Vec3 p_S = shape.R_WS().transpose() * (p_W - shape.p_W());
  const SurfacePoint s = BoxShape::nearest(shape.in_world(), p_S, reach);
  return {.distance = s.distance, .n = shape.R_WS() * s.n};
}

/// Place of a sphere against the surface that it touched first.
struct SweptContact {
  bool touches = false;
  bool was_inside = false;  // true if its centre was inside at the start, so that there is no entry
  Real depth = 0;           // depth at the predicted end of the stage against the plane of the touch, m
  Vec3 n_W = Vec3::UnitZ();
};

/// Returns the remaining share of the path through a stage at the first touch, if the path ends inside.
/// Otherwise returns the share at the last place that is in touch, or no deeper than the start. Conservative
/// advancement: `deep` changes by at most the distance moved.
/// deep(left): depth at the remaining share `left`, from 1 to 0. in_touch: depths that count as touching.
/// Result < 0: no touch.
template <class Depth>
Real remaining_at_touch(Real way, Real in_touch, Depth deep) noexcept {
  const Real first = deep(1), last = deep(0), touch = std::max(first, Real(0)) + in_touch;
  if (last > touch) {
    Real left = (last - touch) / way;
    for (int k = 0; k < max_advances && left < 1; ++k) {
      const Real over = deep(left) - touch;
      if (!(over > 0)) return left;
      left += std::max(over, in_touch) / way;
    }
    return 1;
  }
  if (first > 0) return -1;
  Real left = 1;
  for (int k = 0; k < max_advances; ++k) {
    const Real d = deep(left);
    if (d >= -in_touch) return left;
    left += d / way;
    if (!(left > 0)) return -1;
  }
  return -1;
}

/// Sweeps a sphere of radius r from p + back to p against the shape.
inline SweptContact swept(const PlacedShape& shape, const Vec3& p_W, const Vec3& back_W, Real r) noexcept {
  const Real way = back_W.norm(), reach = r + way;
  const auto at = [&](Real left) noexcept { return nearest_of(shape, p_W + left * back_W, reach); };
  const SurfacePoint start = at(1);
  if (!(start.distance > 0)) return {.was_inside = true};
  Real left =
      remaining_at_touch(way, sweep_tolerance * r, [&](Real part) noexcept { return r - at(part).distance; });
  if (left < 0 && start.distance < r && start.n.dot(back_W) > r)
    left = 1;  // in touch, and moving on through
               // the surface
  if (left < 0) return {};
  const SurfacePoint s = at(left);
  return {.touches = true, .depth = r - s.distance + left * s.n.dot(back_W), .n_W = s.n};
}

/// Returns an upper bound of the boxes' depth along the normal of a face or an edge; < 0: a lower bound of
/// their distance.
inline Real depth_of(const BoxOnBox& w) noexcept {
  Real depth = least_face(w).depth;
  for (int i = 0; i < 3; ++i) {
    const EdgeAxes n(w, i);
    for (std::size_t j = 0; j < 3; ++j)
      if (n.sine[j] > min_edge_sine) depth = std::min(depth, n.d[j]);
  }
  return depth;
}

/// Returns surface o of a body, a time before the end of the stage, s.
template <class Contacts, std::size_t N>
PlacedShape earlier(const ContactFinder<Contacts, N>& w, std::uint32_t body, std::uint32_t o,
                    Real before) noexcept {
  PlacedShape shape = w.placed[o];
  if (body < N)
    shape.move(-before * swept_velocity_at(w, body, shape.p_W()), exp_so3(Vec3(-before * w.at[body].V.w)));
  return shape;
}

/// Returns the time before the end of the stage at which boxes o of body a and q of body b first touch, s.
/// Not positive: no touch before the end, or the boxes are sunk at the start.
template <class Contacts, std::size_t N>
[[gnu::noinline]] Real time_from_touch(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t o,
                                       std::uint32_t b, std::uint32_t q, Real travel, Real reach) noexcept {
  const auto deep = [&](Real left) noexcept {
    return depth_of(BoxOnBox(earlier(w, a, o, left * w.since()), earlier(w, b, q, left * w.since())));
  };
  if (deep(1) > sunk_depth / edge_reach * reach) return -1;
  return w.since() * remaining_at_touch(travel, edge_touch * reach, deep);
}

}  // namespace godobject
