#include "tests/oracle/solids_apart.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Geometry>

namespace godobject::oracle {
namespace {

using Eigen::Vector3d;

constexpr double apart = 1e-7;  // m: boxes that are nearer touch

/// Returns the shortest way from a point of box b to a point of box a, without their radii. The squared
/// distance is convex in the coordinates of both points, each between its ends.
Vector3d shortest_way(const RoundedBox& a, const RoundedBox& b) {
  std::array<Vector3d, 6> axes;
  std::array<double, 6> half, at{};
  for (int k = 0; k < 3; ++k) {
    axes[k] = a.R_W.col(k);
    axes[k + 3] = -b.R_W.col(k);
    half[k] = a.half[k];
    half[k + 3] = b.half[k];
  }
  Vector3d way = a.p_W - b.p_W;
  for (int n = 0; n < 20000; ++n) {
    double moved = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const double to = std::clamp(at[k] - axes[k].dot(way), -half[k], half[k]);
      way += (to - at[k]) * axes[k];
      moved = std::max(moved, std::abs(to - at[k]));
      at[k] = to;
    }
    if (moved < 1e-13) break;
  }
  return way;
}

double extent(const RoundedBox& box, const Vector3d& n) {
  return (box.R_W.transpose() * n).cwiseAbs().dot(box.half) + box.radius;
}

}  // namespace

Overlap overlap(const RoundedBox& a, const RoundedBox& b) {
  const Vector3d way = shortest_way(a, b);
  const double distance = way.norm();
  if (distance > apart) return {.depth = a.radius + b.radius - distance, .n = way / distance, .sure = true};
  Overlap least{.depth = std::numeric_limits<double>::infinity(), .n = Vector3d::UnitZ()};
  double second = least.depth;
  const auto take = [&](const Vector3d& axis) {
    if (axis.norm() < 1e-2) return;
    const Vector3d n = (axis.dot(a.p_W - b.p_W) < 0 ? -axis : axis).normalized();
    const double depth = extent(a, n) + extent(b, n) - n.dot(a.p_W - b.p_W);
    if (depth < least.depth) {
      second = least.depth;
      least.depth = depth;
      least.n = n;
    } else {
      second = std::min(second, depth);
    }
  };
  for (int i = 0; i < 3; ++i) {
    take(a.R_W.col(i));
    take(b.R_W.col(i));
    for (int j = 0; j < 3; ++j) take(a.R_W.col(i).cross(b.R_W.col(j)));
  }
  least.sure = second > 1.5 * least.depth;
  return least;
}

}  // namespace godobject::oracle
