// Damped spring of zero length between a body and its target (2).
#pragma once

#include "core/math/rotation_error.h"

namespace godobject {

/// Gains of the spring: F = g e_t' + k e_t,  T = g_r (w_D - w_B) + k_r alpha u.
template <class T>
struct SpringParamsOf {
  T k = 0;    // N/m, >= 0
  T g = 0;    // N s/m, >= 0
  T k_r = 0;  // N m/rad, >= 0
  T g_r = 0;  // N m s/rad, >= 0
};
using SpringParams = SpringParamsOf<Real>;

/// True if any gain is not zero.
inline bool pulls(const SpringParams& spring) noexcept {
  return spring.k > 0 || spring.g > 0 || spring.k_r > 0 || spring.g_r > 0;
}

/// Coupling part of a scene. Bodies without a coupling have zero gains.
struct DampedSpring {
  using Params = SpringParams;
  template <class T>
  struct StateOf {
    Vector3<T> phi_B =
        Vector3<T>::Zero();  // attitude error of the last step; selects the side near the half turn (16)
  };
  using State = StateOf<Real>;
};

/// Returns the gains during the ramp after engaging (14), s from 0 to 1; the damping ratio g / sqrt(m k)
/// stays constant.
inline SpringParams ramped(const SpringParams& spring, Real s) noexcept {
  return {.k = s * s * spring.k, .g = s * spring.g, .k_r = s * s * spring.k_r, .g_r = s * spring.g_r};
}

}  // namespace godobject
