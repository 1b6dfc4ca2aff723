// Angles about a fixed axis: from their sine and cosine, and with whole turns.
#pragma once

#include <cmath>

#include "core/math/so3.h"

namespace godobject {

/// Returns the angle in [-pi, pi] with this sine and cosine, which may be scaled alike.
inline Real angle_of(Real sine, Real cosine) noexcept {
  const Real n = std::sqrt(sine * sine + cosine * cosine);
  const Real c = n > 0 ? cosine / n : 1, s = n > 0 ? sine / n : 0;
  // half the angle, from the larger of 1 + c and 1 - c
  const Real big = std::sqrt(Real(0.5) * (1 + std::abs(c)));
  const Real small = std::abs(s) / (2 * big);
  const Real w = c > 0 ? big : small, v = c > 0 ? small : big;
  return std::copysign(log_factor(w) * v, s);
}

/// Returns the number of whole turns nearest to an angle, rad; the even one of two that are equally near.
inline Real whole_turns(Real angle) noexcept {
  // above this, neighbouring numbers are 1 apart, so the sum rounds to an integer. A product instead of this
  // quotient might be fused with the sum, and half a turn would be no tie.
  constexpr Real integers = 0x1.8p52;
  return (angle / (2 * pi) + integers) - integers;
}

/// Returns the angle, rad, with the whole turns that bring it nearest to `near`: the same attitude.
inline Real unwrapped(Real angle, Real near) noexcept { return angle + 2 * pi * whole_turns(near - angle); }

}  // namespace godobject
