// The nearest point of a solid, by brute force over the triangles of its surface or the axis within it.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace godobject::oracle {

/// All points within `radius` of these triangles, which may be segments or points; or all points that they
/// enclose.
struct Solid {
  using Triangle = std::array<Eigen::Vector3d, 3>;
  std::vector<Triangle> triangles;  // m, in the solid's frame
  double radius = 0;                // m
  /// True for a point that the triangles enclose; none: they enclose nothing.
  std::function<bool(const Eigen::Vector3d&)> encloses;
};

Solid ball(double radius);
/// Half its axis along z, between the centres of its ends.
Solid capsule(double radius, double half_length);
Solid box(const Eigen::Vector3d& half_extents);
/// A closed surface, counter-clockwise from outside.
Solid mesh(const std::vector<Eigen::Vector3d>& vertices,
           const std::vector<std::array<std::uint32_t, 3>>& triangles);
/// heights[j columns + i] at x = i spacing, y = j spacing; cells split from their first corner; walls without
/// end down.
Solid height_field(const std::vector<double>& heights, int columns, int rows, double spacing);

struct NearestPoint {
  double distance = 0;  // m, negative inside
  Eigen::Vector3d n;    // unit, outward
};

/// The surface of a solid seen from a point of its frame.
NearestPoint nearest_point(const Solid& solid, const Eigen::Vector3d& p);

/// All points of a closed surface that are nearer to a point outside than the surface round them, each once.
std::vector<NearestPoint> nearest_points(const Solid& solid, const Eigen::Vector3d& p);

}  // namespace godobject::oracle
