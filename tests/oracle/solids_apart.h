// How far two convex solids are apart, or how deep in each other, by brute force.
#pragma once

#include <Eigen/Core>

namespace godobject::oracle {

/// All points within `radius` of a box, whose half extents may be zero: a ball has three of them, a capsule
/// two.
struct RoundedBox {
  Eigen::Vector3d half = Eigen::Vector3d::Zero();  // m
  double radius = 0;                               // m
  Eigen::Matrix3d R_W = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
};

struct Overlap {
  double depth = 0;   // m, < 0: apart
  Eigen::Vector3d n;  // unit, off b
  bool sure = false;  // true if no other normal has nearly the same depth
};

/// Overlap of a and b. Nearest points of the two boxes by descent, one coordinate at a time. For two sharp
/// boxes in each other the least depth along their 15 possible axes.
Overlap overlap(const RoundedBox& a, const RoundedBox& b);

}  // namespace godobject::oracle
