// Four spheres at a time against a shape: which of them are near it.
#pragma once

#include "core/contact/find/exit_direction.h"
#include "core/tuning.h"

namespace godobject {

/// Four spheres and a box: bit j of the result, sphere j is near. Where its centre is inside, its depth is its radius,
/// and it has no normal; with a way out, it is that from there.
inline std::uint32_t near_box(const PlacedShape& box, const SpherePack& pack, Real travel,
                              const Vec3* way_out_S, Pack& d, Vector3<Pack>& n_W) noexcept {
  const Mat3& R_WS = box.R_WS();
  const Vector3<Pack> p_S = in_frame(box.p_W(), R_WS, pack.p_W);
  Vector3<Pack> n_S;
  Pack distance;
  if (way_out_S == nullptr) BoxShape::nearest(box.half_extents(), p_S, distance, n_S);
  else BoxShape::nearest(box.half_extents(), p_S, *way_out_S, distance, n_S);
  for (int k = 0; k < 3; ++k) n_W[k] = R_WS(k, 0) * n_S[0] + R_WS(k, 1) * n_S[1] + R_WS(k, 2) * n_S[2];
  d = pack.r - distance;
  return bits(-contact_reach * pack.r - travel < d);
}

/// Four spheres and a box that their body leaves through one face: the same, of those that touch it, behind that face.
inline std::uint32_t behind_face(const PlacedShape& box, const SpherePack& pack, const Vec3& way_out_S,
                                 Pack& d, Vector3<Pack>& n_W) noexcept {
  const std::uint32_t hits = near_box(box, pack, 0, nullptr, d, n_W) & bits(Pack(0) < d);
  const Vec3 n = box.R_WS() * way_out_S;
  Pack distance = -box.half_extents().dot(way_out_S.cwiseAbs());
  for (int k = 0; k < 3; ++k) {
    n_W[k] = n[k];
    distance += (pack.p_W[k] - box.p_W()[k]) * n[k];
  }
  d = pack.r - distance;
  return hits;
}

/// Four spheres and a half-space: the same.
inline std::uint32_t near_plane(const PlacedShape& plane, const SpherePack& pack, Real travel, Pack& d,
                                Vector3<Pack>& n_W) noexcept {
  const Mat3& R_WS = plane.R_WS();
  Pack distance = 0;
  for (int k = 0; k < 3; ++k) {
    n_W[k] = R_WS(k, 2);
    distance += (pack.p_W[k] - plane.p_W()[k]) * R_WS(k, 2);
  }
  d = pack.r - distance;
  return ~bits(d <= -contact_reach * pack.r - travel);
}

/// The radius of a ball round a shape about the origin of its frame, of those that have one.
inline Real ball_round(const PlacedShape& shape) noexcept {
  return shape.kind() == ShapeKind::box ? shape.half_extents().norm() : shape.radius() + shape.half_length();
}

/// Four spheres and what is within `size` of p: bit j, sphere j may touch it. One that is nowhere may.
inline std::uint32_t within(const Vec3& p, const SpherePack& pack, Real size) noexcept {
  Pack distance_sq = 0;
  for (int c = 0; c < 3; ++c) {
    const Pack a = pack.p_W[c] - p[c];
    distance_sq += a * a;
  }
  const Pack reach = pack.r * (1 + contact_reach) + size;
  return ~bits(reach * reach <= distance_sq);
}

/// Four spheres and a capsule: the same.
inline std::uint32_t within_capsule(const PlacedShape& shape, const SpherePack& pack, Real travel) noexcept {
  const Mat3& R_WS = shape.R_WS();
  Vector3<Pack> a = pack.p_W;
  for (int c = 0; c < 3; ++c) a[c] -= shape.p_W()[c];
  const Pack z = a[0] * R_WS(0, 2) + a[1] * R_WS(1, 2) + a[2] * R_WS(2, 2);
  const Pack along = max(min(z, Pack(shape.half_length())), Pack(-shape.half_length()));
  for (int c = 0; c < 3; ++c) a[c] -= along * R_WS(c, 2);
  const Pack reach = pack.r * (1 + contact_reach) + (shape.radius() + travel);
  return ~bits(reach * reach <= a.squaredNorm());
}

/// Four spheres and any shape, with a ball of this radius round it: the same.
inline std::uint32_t may_touch(const PlacedShape& shape, Real ball, const SpherePack& pack,
                               Real travel) noexcept {
  if (shape.kind() == ShapeKind::capsule) return within_capsule(shape, pack, travel);
  return is_carried(shape.kind()) ? within(shape.p_W(), pack, ball + travel) : ~0u;
}

}  // namespace godobject
