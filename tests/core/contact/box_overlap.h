// Bricks with spheres at their corners alone, and the depth of two boxes by the separating axes.
#pragma once

#include "tests/core/contact/bodies/bricks.h"

namespace godobject {

template <class P>
void add_cornered_brick(P& pile, const Start& start, Real m, const Vec3& half, Real r) {
  const std::size_t i = pile.add(solid_box(m, half), start);
  const Vec3 corner = half - Vec3::Constant(r);
  for (int k = 0; k < 8; ++k)
    add_sphere(pile.par, i,
               corner.cwiseProduct(Vec3(k % 2 == 0 ? -1 : 1, k % 4 < 2 ? -1 : 1, k < 4 ? -1 : 1)), r);
  pile.carry(i, {.kind = ShapeKind::box, .half_extents = half});
}

/// m; < 0: apart, by so much at least.
inline Real boxes_overlap(const Pose& a, const Vec3& half_a, const Pose& b, const Vec3& half_b) {
  const Mat3 R_a = a.q.toRotationMatrix(), R_b = b.q.toRotationMatrix();
  const Vec3 between = b.p - a.p;
  Real least = std::numeric_limits<Real>::infinity();
  const auto along = [&](const Vec3& axis) {
    const Real length = axis.norm();
    if (length < 1e-3) return;
    const Vec3 n = axis / length;
    least = std::min(least, half_a.dot((R_a.transpose() * n).cwiseAbs()) +
                                half_b.dot((R_b.transpose() * n).cwiseAbs()) - std::abs(n.dot(between)));
  };
  for (int i = 0; i < 3; ++i) {
    along(R_a.col(i));
    along(R_b.col(i));
    for (int j = 0; j < 3; ++j) along(R_a.col(i).cross(R_b.col(j)));
  }
  return least;
}

}  // namespace godobject
