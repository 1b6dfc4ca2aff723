// Solid box about the origin of its frame, edges along its axes.
#pragma once

#include "core/math/componentwise.h"
#include "core/math/simd4.h"
#include "core/shape/shape.h"

namespace godobject {

struct BoxShape {
  static constexpr ShapeKind kind = ShapeKind::box;

  static bool is_valid(const ShapeParams& par) noexcept {
    const Vec3& b = par.half_extents;
    return is_dimension(b.x()) && is_dimension(b.y()) && is_dimension(b.z());
  }

  /// Returns the surface seen from p. For p inside, that of the nearest face. Of equally near faces x
  /// precedes y and z, and the positive face precedes its opposite.
  static SurfacePoint nearest(const ShapeParams& par, const Vec3& p, Real) noexcept {
    const Vec3& b = par.half_extents;
    const Vec3 beyond = p.cwiseAbs() - b;
    Eigen::Index k = 0;
    const Real depth = beyond.maxCoeff(&k);
    Vec3 face = Vec3::Zero();
    face[k] = p[k] < 0 ? -1 : 1;
    if (!(depth > 0)) return {.distance = depth, .n = face};

    const Vec3 a = p - nearest_in_box(p, -b, b);
    const Real length = a.norm();
    return {.distance = length, .n = direction(a, length, face)};
  }

  /// Computes distances and normals of four points outside. Inside, there is no distance and no normal.
  static void nearest(const Vec3& half_extents, const Vector3<Pack>& p, Pack& distance,
                      Vector3<Pack>& n) noexcept {
    Vector3<Pack> a;
    for (int k = 0; k < 3; ++k) {
      const Pack beyond = max(abs(p[k]) - half_extents[k], Pack(0));
      a[k] = select(p[k] < 0, -beyond, beyond);
    }
    const Pack length = sqrt(a.squaredNorm());
    distance = select(Pack(min_length) < length, length, Pack(0));
    const Pack scale = 1 / max(length, Pack(min_length));
    for (int k = 0; k < 3; ++k) n[k] = a[k] * scale;
  }
  /// Computes distances and normals of four points. For points inside, distance and normal are those of one
  /// face, given by its outward normal exit_direction.
  static void nearest(const Vec3& half_extents, const Vector3<Pack>& p, const Vec3& exit_direction,
                      Pack& distance, Vector3<Pack>& n) noexcept {
    nearest(half_extents, p, distance, n);
    const PackMask outside = Pack(0) < distance;
    const Pack depth = p[0] * exit_direction[0] + p[1] * exit_direction[1] + p[2] * exit_direction[2] -
                       half_extents.dot(exit_direction.cwiseAbs());
    for (int k = 0; k < 3; ++k) n[k] = select(outside, n[k], Pack(exit_direction[k]));
    distance = select(outside, distance, depth);
  }
};

}  // namespace godobject
