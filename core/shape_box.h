// Solid box about the origin of its frame, edges along its axes.
#pragma once

#include "core/pack.h"
#include "core/shape.h"

namespace godobject {

struct BoxShape {
  static constexpr ShapeKind kind = ShapeKind::box;

  static bool is_valid(const ShapeParams& par) noexcept {
    const Vec3& b = par.half_extents;
    return is_dimension(b.x()) && is_dimension(b.y()) && is_dimension(b.z());
  }

  /// Inside, the nearest face: of several the first of x, y, z; of two opposite ones the positive.
  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real) noexcept {
    const Vec3& b = par.half_extents;
    const Vec3 beyond = p.cwiseAbs() - b;
    Eigen::Index k = 0;
    const Real depth = beyond.maxCoeff(&k);
    Vec3 face = Vec3::Zero();
    face[k] = p[k] < 0 ? -1 : 1;
    if (!(depth > 0)) return {.distance = depth, .n = face};

    const Vec3 a = p - p.cwiseMax(-b).cwiseMin(b);
    const Real length = a.norm();
    return {.distance = length, .n = direction(a, length, face)};
  }

  /// The same for four points. Inside, of each pair of opposite faces the one on the side of `towards`.
  static void nearest(const Vec3& half_extents, const Vector3<Pack>& p, const Vector3<Pack>& towards,
                      Pack& distance, Vector3<Pack>& n) noexcept {
    Vector3<Pack> a, face;
    Pack depth = 0;
    for (int k = 0; k < 3; ++k) {
      const Pack beyond = abs(p[k]) - half_extents[k];
      a[k] = select(p[k] < 0, -max(beyond, Pack(0)), max(beyond, Pack(0)));
      const Pack side = select(towards[k] < 0, Pack(-1), Pack(1));
      const Pack d = side * p[k] - half_extents[k];
      if (k == 0) depth = d;
      const PackMask nearer = depth < d;
      for (int l = 0; l < k; ++l) face[l] = select(nearer, Pack(0), face[l]);
      face[k] = k == 0 ? side : select(nearer, side, Pack(0));
      depth = max(depth, d);
    }
    const Pack length = sqrt(a.squaredNorm());
    const PackMask outside = Pack(min_length) < length;
    const Pack scale = 1 / max(length, Pack(min_length));
    for (int k = 0; k < 3; ++k) n[k] = select(outside, a[k] * scale, face[k]);
    distance = select(outside, length, depth);
  }
};

}  // namespace godobject
