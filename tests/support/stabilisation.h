// Stabilisations of joints that ask for the violation where a stage starts: what AtPrediction of the core is measured against.
#pragma once

#include "core/joint/stabilisation.h"

namespace godobject {

/// (5) at acceleration level, g'' = -(a / h) g' - (b / h^2) g with g and g' where the stage starts, a = A / 100. The
/// velocity products of g'' are in L at the predicted pose:  L^ V+ = (1 - a) L V - (b / h) g.
template <int A, int B>
struct Baumgarte {
  static constexpr bool uses_base = true;
  static constexpr Real a = Real(A) / 100, b = Real(B) / 100;

  template <class M>
  static Twist beta(const M&, const Twist&, Real h, const M& base, const Twist& V_base) noexcept {
    const Twist V = across(base, V_base);
    return {.w = (1 - a) * V.w - base.e_w * (b / h), .v = (1 - a) * V.v - base.e_v * (b / h)};
  }
};

/// (5) as the paper has it, g'' + (2/h) g' + g/h^2 = 0, with g and g' of the new state: the error halves each step.
using BaumgarteImplicit = Baumgarte<75, 25>;
/// The same with g and g' of the old state, positions advanced by the new velocity: diverges, always. For studies.
using BaumgarteDiverging = Baumgarte<200, 100>;
/// Velocity level where the stage starts: L V+ = -g / h.
using AtBase = Baumgarte<100, 100>;

}  // namespace godobject
