// The damped spring of zero length between a body and its target, equation (2).
#pragma once

#include "core/rotation_error.h"

namespace godobject {

/// F = g e_t' + k e_t,  T = g_r (w_D - w_B) + k_r alpha u.
struct SpringParams {
  Real k = 0;    // N/m, >= 0
  Real g = 0;    // N s/m, >= 0
  Real k_r = 0;  // N m/rad, >= 0
  Real g_r = 0;  // N m s/rad, >= 0
};

/// The coupling part of a scene. Bodies of the scene without a coupling have all gains zero.
struct DampedSpring {
  using Params = SpringParams;
  struct State {
    Vec3 phi_B = Vec3::Zero();  // attitude error of the last step: keeps its side near the half turn
  };
};

/// (14)  gains during the ramp-up after engaging, s from 0 to 1: the damping ratio g / sqrt(m k) stays.
inline SpringParams ramped(const SpringParams& spring, Real s) noexcept {
  return {.k = s * s * spring.k, .g = s * spring.g, .k_r = s * s * spring.k_r, .g_r = s * spring.g_r};
}

}  // namespace godobject
