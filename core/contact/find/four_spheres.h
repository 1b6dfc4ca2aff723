// Tests of four spheres at a time against a shape.
#pragma once

#include "core/contact/find/exit_direction.h"
#include "core/tuning.h"

namespace godobject {

/// Tests four spheres against a box. Bit j of the result: sphere j is near. For a centre inside the box,
/// depth and normal are those of the exit direction. Without one the depth is the radius, and there is no
/// normal.
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

/// Tests four spheres of a body that leaves a box through one face. Bit j of the result: sphere j touches the
/// box. d: depth of the spheres behind the plane of that face.
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

/// Tests four spheres against a half-space.
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

/// Tests four spheres against a ball of radius `size` about p. Bit j: sphere j may touch it; true for
/// undefined positions.
inline std::uint32_t within(const Vec3& p, const SpherePack& pack, Real size) noexcept {
  Pack distance_sq = 0;
  for (int c = 0; c < 3; ++c) {
    const Pack a = pack.p_W[c] - p[c];
    distance_sq += a * a;
  }
  const Pack reach = pack.r * (1 + contact_reach) + size;
  return ~bits(reach * reach <= distance_sq);
}

/// Tests four spheres against a capsule.
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

/// Tests four spheres against any shape, by a ball of the given radius round it.
inline std::uint32_t may_touch(const PlacedShape& shape, Real ball, const SpherePack& pack,
                               Real travel) noexcept {
  if (shape.kind() == ShapeKind::capsule) return within_capsule(shape, pack, travel);
  return is_carried(shape.kind()) ? within(shape.p_W(), pack, ball + travel) : ~0u;
}

}  // namespace godobject
