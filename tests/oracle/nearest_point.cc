#include "tests/oracle/nearest_point.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace godobject::oracle {
namespace {

using Eigen::Vector3d;

constexpr double far_down = 100;  // m: the walls of a height field have no end

Vector3d on_segment(const Vector3d& a, const Vector3d& b, const Vector3d& p) {
  const Vector3d along = b - a;
  const double length_sq = along.squaredNorm();
  return length_sq > 0 ? Vector3d(a + std::clamp(along.dot(p - a) / length_sq, 0.0, 1.0) * along) : a;
}

Vector3d on_triangle(const Solid::Triangle& t, const Vector3d& p) {
  const Vector3d a = t[1] - t[0], b = t[2] - t[0], n = a.cross(b);
  if (n.squaredNorm() > 0) {
    Eigen::Matrix3d axes;
    axes << a, b, n;
    const Vector3d u = axes.partialPivLu().solve(p - t[0]);
    if (u.x() >= 0 && u.y() >= 0 && u.x() + u.y() <= 1) return t[0] + u.x() * a + u.y() * b;
  }
  Vector3d best = on_segment(t[0], t[1], p);
  for (const Vector3d& q : {on_segment(t[1], t[2], p), on_segment(t[2], t[0], p)})
    if ((p - q).squaredNorm() < (p - best).squaredNorm()) best = q;
  return best;
}

/// Solid angle of a triangle seen from a point (van Oosterom, Strackee 1983).
double solid_angle(const Solid::Triangle& t, const Vector3d& p) {
  const Vector3d a = t[0] - p, b = t[1] - p, c = t[2] - p;
  const double A = a.norm(), B = b.norm(), C = c.norm();
  return 2 * std::atan2(a.dot(b.cross(c)), A * B * C + a.dot(b) * C + b.dot(c) * A + c.dot(a) * B);
}

void add_quad(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d, Solid& solid) {
  solid.triangles.push_back({a, b, c});
  solid.triangles.push_back({a, c, d});
}

}  // namespace

Solid ball(double radius) { return capsule(radius, 0); }

Solid capsule(double radius, double half_length) {
  const Vector3d end = half_length * Vector3d::UnitZ();
  return {.triangles = {{-end, end, end}}, .radius = radius, .encloses = {}};
}

Solid box(const Vector3d& half) {
  Solid solid;
  for (int k = 0; k < 3; ++k) {
    Vector3d u = Vector3d::Zero(), v = u, w = u;
    u[k] = half[k];
    v[(k + 1) % 3] = half[(k + 1) % 3];
    w[(k + 2) % 3] = half[(k + 2) % 3];
    for (const double side : {-1.0, 1.0})
      add_quad(side * u - v - w, side * u + v - w, side * u + v + w, side * u - v + w, solid);
  }
  solid.encloses = [half](const Vector3d& p) { return (p.cwiseAbs() - half).maxCoeff() < 0; };
  return solid;
}

Solid mesh(const std::vector<Vector3d>& vertices,
           const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  Solid solid;
  for (const auto& [a, b, c] : triangles) solid.triangles.push_back({vertices[a], vertices[b], vertices[c]});
  solid.encloses = [surface = solid.triangles](const Vector3d& p) {
    double sum = 0;
    for (const Solid::Triangle& t : surface) sum += solid_angle(t, p);
    return std::abs(sum) > 6;  // 4 pi inside, 0 outside
  };
  return solid;
}

Solid height_field(const std::vector<double>& heights, int columns, int rows, double spacing) {
  const auto point = [=](int i, int j) {
    return Vector3d(i * spacing, j * spacing, heights[static_cast<std::size_t>(j * columns + i)]);
  };
  const auto down = [](Vector3d p) {
    p.z() = -far_down;
    return p;
  };
  Solid solid;
  for (int j = 0; j + 1 < rows; ++j)
    for (int i = 0; i + 1 < columns; ++i)
      add_quad(point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1), solid);
  const auto wall = [&](const Vector3d& a, const Vector3d& b) { add_quad(a, b, down(b), down(a), solid); };
  for (int i = 0; i + 1 < columns; ++i)
    for (const int j : {0, rows - 1}) wall(point(i, j), point(i + 1, j));
  for (int j = 0; j + 1 < rows; ++j)
    for (const int i : {0, columns - 1}) wall(point(i, j), point(i, j + 1));
  solid.encloses = [=](const Vector3d& p) {
    const double u = p.x() / spacing, v = p.y() / spacing;
    if (!(u > 0 && v > 0 && u < columns - 1 && v < rows - 1)) return false;
    const int i = static_cast<int>(u), j = static_cast<int>(v);
    const double x = u - i, y = v - j, a = point(i, j).z(), b = point(i + 1, j).z(),
                 c = point(i + 1, j + 1).z(), d = point(i, j + 1).z();
    return p.z() < (x > y ? a + x * (b - a) + y * (c - b) : a + y * (d - a) + x * (c - d));
  };
  return solid;
}

NearestPoint nearest_point(const Solid& solid, const Vector3d& p) {
  double nearest_sq = std::numeric_limits<double>::infinity();
  Vector3d at = p;
  for (const Solid::Triangle& t : solid.triangles) {
    const Vector3d q = on_triangle(t, p);
    if ((p - q).squaredNorm() >= nearest_sq) continue;
    nearest_sq = (p - q).squaredNorm();
    at = q;
  }
  const double side = solid.encloses && solid.encloses(p) ? -1 : 1, length = std::sqrt(nearest_sq);
  return {.distance = side * length - solid.radius, .n = side * (p - at) / length};
}

std::vector<NearestPoint> nearest_points(const Solid& solid, const Vector3d& p) {
  constexpr double rounding = 1e-12;  // m
  std::vector<Vector3d> kept;
  std::vector<NearestPoint> nearest;
  for (const Solid::Triangle& t : solid.triangles) {
    const Vector3d q = on_triangle(t, p);
    const double distance = (p - q).norm();
    // triangles are convex, so any that meets q and is nearer leads down from q
    const bool is_lowest =
        std::all_of(solid.triangles.begin(), solid.triangles.end(), [&](const Solid::Triangle& u) {
          return (on_triangle(u, q) - q).norm() > rounding ||
                 (on_triangle(u, p) - p).norm() > distance - rounding;
        });
    const bool is_known = std::any_of(kept.begin(), kept.end(),
                                      [&](const Vector3d& k) { return (k - q).norm() < 1e3 * rounding; });
    if (!is_lowest || is_known || (t[1] - t[0]).cross(t[2] - t[0]).dot(p - q) <= 0) continue;
    kept.push_back(q);
    nearest.push_back({distance, (p - q) / distance});
  }
  return nearest;
}

}  // namespace godobject::oracle
