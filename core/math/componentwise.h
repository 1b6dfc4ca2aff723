// Minimum and maximum of vectors by component, and of their components. Same bits as Eigen's cwiseMin,
// cwiseMax, minCoeff and maxCoeff. Those call through a function pointer, behind which the compiler cannot
// prove that a step does not block (core/nonblocking.h).
#pragma once

#include <algorithm>

#include "core/math/types.h"

namespace godobject {

inline Vec3 componentwise_min(const Vec3& a, const Vec3& b) noexcept {
  return {std::min(a.x(), b.x()), std::min(a.y(), b.y()), std::min(a.z(), b.z())};
}

inline Vec3 componentwise_max(const Vec3& a, const Vec3& b) noexcept {
  return {std::max(a.x(), b.x()), std::max(a.y(), b.y()), std::max(a.z(), b.z())};
}

inline Real min_component(const Vec3& a) noexcept { return std::min(a.x(), std::min(a.y(), a.z())); }
inline Real max_component(const Vec3& a) noexcept { return std::max(a.x(), std::max(a.y(), a.z())); }

/// Returns the point of the box from low to high that is nearest to p.
inline Vec3 nearest_in_box(const Vec3& p, const Vec3& low, const Vec3& high) noexcept {
  return componentwise_min(componentwise_max(p, low), high);
}

}  // namespace godobject
