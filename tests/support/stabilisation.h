// Stabilisations of joints that use the violation at the start of the stage: comparison for AtPrediction of
// the core.
#pragma once

#include "core/joint/stabilisation.h"

namespace godobject {

/// Stabilisation (5) at acceleration level, g'' = -(a / h) g' - (b / h^2) g, a = A / 100, with g and g' at
/// the start of the stage. The velocity products of g'' are in L at the predicted pose:  L^ V+ = (1 - a) L V
/// - (b / h) g.
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

/// Stabilisation (5) of the paper, g'' + (2/h) g' + g/h^2 = 0, with g and g' of the new state: the error
/// halves in each step.
using BaumgarteImplicit = Baumgarte<75, 25>;
/// As BaumgarteImplicit with g and g' of the old state, positions advanced by the new velocity: always
/// diverges. For studies.
using BaumgarteDiverging = Baumgarte<200, 100>;
/// Velocity level at the start of the stage: L V+ = -g / h.
using AtBase = Baumgarte<100, 100>;

}  // namespace godobject
