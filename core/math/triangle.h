// Point of a triangle nearest to a given point, and the feature that it lies on.
#pragma once

#include <array>
#include <limits>

#include "core/math/componentwise.h"
#include "core/tuning.h"

namespace godobject {

using Corners = std::array<Vec3, 3>;

enum class TriangleFeature : unsigned char { face, edge, corner };

struct TrianglePoint {
  Vec3 p = Vec3::Zero();
  Real distance_sq = std::numeric_limits<Real>::infinity();  // m^2
  TriangleFeature feature = TriangleFeature::face;
  std::size_t k = 0;  // edge from corner k to corner k + 1, or corner k
};

/// Bounding box of a triangle.
struct TriangleBox {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
};
inline TriangleBox box_of(const Corners& t) noexcept {
  return {.low = componentwise_min(componentwise_min(t[0], t[1]), t[2]),
          .high = componentwise_max(componentwise_max(t[0], t[1]), t[2])};
}

/// Returns the squared distance from p to the triangle's bounding box, a lower bound of that to the triangle.
inline Real box_distance_sq(const Corners& t, const Vec3& p) noexcept {
  const auto [low, high] = box_of(t);
  return (p - nearest_in_box(p, low, high)).squaredNorm();
}

/// Returns the point nearest to p on the edge from corner k to the next one.
inline TrianglePoint nearest_on_edge(const Corners& t, std::size_t k, const Vec3& p) noexcept {
  const Vec3& a = t[k];
  const Vec3& b = t[(k + 1) % 3];
  const Vec3 e = b - a;
  const Real s = e.dot(p - a), length_sq = e.squaredNorm();
  TrianglePoint q{.p = a, .feature = TriangleFeature::corner, .k = k};
  if (s >= length_sq) {
    q.p = b;
    q.k = (k + 1) % 3;
  } else if (s > 0) {
    q.p = a + s / length_sq * e;
    q.feature = TriangleFeature::edge;
  }
  q.distance_sq = (p - q.p).squaredNorm();
  return q;
}

/// Returns the point of a triangle nearest to p. n: unit normal of the triangle, corners counter-clockwise
/// about it. Of points equally near, that of the first edge.
inline TrianglePoint nearest_on_triangle(const Corners& t, const Vec3& n, const Vec3& p) noexcept {
  TrianglePoint best;
  bool outside = false;
  for (std::size_t k = 0; k < 3; ++k) {
    // Seen along n, p lies beyond edge k; the nearest point is on an edge that p lies beyond.
    if (!((t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(n) < 0)) continue;
    outside = true;
    const TrianglePoint q = nearest_on_edge(t, k, p);
    if (q.distance_sq < best.distance_sq) best = q;
  }
  if (outside) return best;
  const Real d = n.dot(p - t[0]);
  return {.p = p - d * n, .distance_sq = d * d, .feature = TriangleFeature::face};
}

/// True if p is so near to the triangle that the direction from its nearest point is rounding error.
inline bool is_touching(const Corners& t, const Vec3& p, Real distance) noexcept {
  const Real size = max_component(p.cwiseAbs()) + max_component((t[1] - t[0]).cwiseAbs());
  return !(distance > rounding_share * size);
}

}  // namespace godobject
