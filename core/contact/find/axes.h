// Contacts of the axes of capsules with each other and with edges of boxes.
//
// With u_1 and u_2 along two axes, or along an axis and an edge, of which the nearest points lie between both
// ends,
//
//   (59)  n = +-u_1 x u_2 / |u_1 x u_2|
//
// away from the second capsule, or from the box. Parallel axes touch by their ends.
#pragma once

#include "core/contact/find/edges.h"
#include "core/contact/memory.h"

namespace godobject {

/// Axis of a capsule or edge of a box, in the world.
struct AxisSegment {
  Vec3 p_W, u_W;  // its middle, unit vector along it
  Real half;      // m
};
inline AxisSegment axis_of(const PlacedShape& capsule) noexcept {
  return {.p_W = capsule.p_W(), .u_W = capsule.R_WS().col(2), .half = capsule.half_length()};
}

/// Nearest points of two lines, if both lie between the ends.
struct AxisCrossing {
  bool crosses = false;
  Vec3 p_a, p_b;  // nearest points, m
  Vec3 n_W;       // unit normal of both; the sign is that of u_a x u_b
};
inline AxisCrossing crossing_of(const AxisSegment& a, const AxisSegment& b) noexcept {
  const Vec3 normal = a.u_W.cross(b.u_W), apart = b.p_W - a.p_W;
  const Real sine_sq = normal.squaredNorm(), cosine = a.u_W.dot(b.u_W);
  if (!(sine_sq > min_edge_sine * min_edge_sine)) return {};
  const Real to_a = apart.dot(a.u_W), to_b = apart.dot(b.u_W);
  const Real t_a = (to_a - cosine * to_b) / sine_sq, t_b = (cosine * to_a - to_b) / sine_sq;
  if (!(std::abs(t_a) < a.half && std::abs(t_b) < b.half)) return {};
  return {.crosses = true,
          .p_a = a.p_W + t_a * a.u_W,
          .p_b = b.p_W + t_b * b.u_W,
          .n_W = normal / std::sqrt(sine_sq)};
}

/// True for kinds of shapes that have an axis or edges.
constexpr bool has_edges(ShapeKind kind) noexcept {
  return kind == ShapeKind::box || kind == ShapeKind::capsule;
}

/// Calls f(number, d, p_W, n_W) for the crossing of the axes of two capsules. n_W: off b. before: memory of
/// the contact, or null. Its normal keeps its side, because axes that are pressed may pass each other.
template <class F>
void each_axis_crossing(const PlacedShape& a, const PlacedShape& b, const ContactMemory* before,
                        F f) noexcept {
  const AxisCrossing at = crossing_of(axis_of(a), axis_of(b));
  if (!at.crosses) return;
  const Vec3 from = before != nullptr ? Vec3(before->n_W.vec()) : Vec3(at.p_a - at.p_b);
  const Real side = from.dot(at.n_W) < 0 ? -1 : 1;
  const Vec3 n_W = side * at.n_W;
  const Real d = a.radius() + b.radius() - n_W.dot(at.p_a - at.p_b);
  f(0u, d, Vec3(at.p_a - (a.radius() - d / 2) * n_W), n_W);
}

/// Calls f(number, d, p_W, n_W) for the edges of a box that cross the axis of a capsule, less deep than its
/// diameter. Only edges to which the normal points, as for boxes, up to the angle of lying flat. n_W: off the
/// box.
template <class F>
void each_axis_on_edges(const PlacedShape& capsule, const PlacedShape& box, F f) noexcept {
  const AxisSegment axis = axis_of(capsule);
  const Vec3 h = box.half_extents();
  const Real flat = std::sqrt(1 - same_normal * same_normal);
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3, l = (i + 2) % 3;
    const Vec3 a_k = box.R_WS().col(k), a_l = box.R_WS().col(l);
    for (std::uint32_t sides = 0; sides < 4; ++sides) {
      const Real s_k = (sides & 1) != 0 ? 1 : -1, s_l = (sides & 2) != 0 ? 1 : -1;
      const AxisCrossing at = crossing_of(
          axis,
          {.p_W = box.p_W() + s_k * h[k] * a_k + s_l * h[l] * a_l, .u_W = box.R_WS().col(i), .half = h[i]});
      if (!at.crosses) continue;
      const Vec3 n_W = at.n_W.dot(axis.p_W - box.p_W()) < 0 ? Vec3(-at.n_W) : at.n_W;
      if (s_k * n_W.dot(a_k) < -flat || s_l * n_W.dot(a_l) < -flat) continue;
      const Real d = capsule.radius() - n_W.dot(at.p_a - at.p_b);
      if (d > 2 * capsule.radius()) continue;
      f(static_cast<std::uint32_t>(i) << 2 | sides, d, Vec3(at.p_b - d / 2 * n_W), n_W);
    }
  }
}

}  // namespace godobject
