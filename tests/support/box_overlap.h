// Penetration of two boxes by their separating axes, a simple reference.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/types.h"

namespace godobject::box_overlap {

/// A box in the world.
struct PosedBox {
  Vec3 p, h;  // centre, half extents
  Mat3 R;
};

/// Returns the extent of a box along a direction from its centre, m.
inline Real reach_along(const PosedBox& box, const Vec3& n) {
  return (box.R.transpose() * n).cwiseAbs().dot(box.h);
}

/// Returns the depth of a in b along a direction n from b to a, or from a to b, m; < 0: separated.
inline Real overlap_along(const Vec3& n, const PosedBox& a, const PosedBox& b) {
  return reach_along(a, n) + reach_along(b, n) - std::abs(n.dot(a.p - b.p));
}

/// Returns the least overlap along the normals of both boxes' faces.
inline Real overlap_of_faces(const PosedBox& a, const PosedBox& b) {
  Real least = std::numeric_limits<Real>::infinity();
  for (int k = 0; k < 3; ++k)
    least = std::min({least, overlap_along(a.R.col(k), a, b), overlap_along(b.R.col(k), a, b)});
  return least;
}

/// Axis perpendicular to edge i of a and edge j of b, from b to a. sine: of the angle between the edges.
struct EdgeAxis {
  int i = -1, j = -1;  // -1: none
  Real sine = 0, overlap = std::numeric_limits<Real>::infinity();
  Vec3 n = Vec3::Zero();
};
inline EdgeAxis edge_axis(int i, int j, const PosedBox& a, const PosedBox& b) {
  const Vec3 square = a.R.col(i).cross(b.R.col(j));
  EdgeAxis axis{.i = i, .j = j, .sine = square.norm()};
  axis.n = square / (square.dot(a.p - b.p) < 0 ? -axis.sine : axis.sine);
  axis.overlap = overlap_along(axis.n, a, b);
  return axis;
}
/// Returns the axis of least overlap among the edge pairs that are not parallel.
inline EdgeAxis least_edge_axis(Real min_sine, const PosedBox& a, const PosedBox& b) {
  EdgeAxis least;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (const EdgeAxis axis = edge_axis(i, j, a, b); axis.sine > min_sine && axis.overlap < least.overlap)
        least = axis;
  return least;
}

/// Returns the least overlap along the fifteen axes, except those of parallel edges, which faces cover.
inline Real overlap(const PosedBox& a, const PosedBox& b) {
  return std::min(overlap_of_faces(a, b), least_edge_axis(Real(1e-6), a, b).overlap);
}

}  // namespace godobject::box_overlap
