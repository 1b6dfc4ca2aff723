// Stops: springs at the ends of a joint's coordinates, entered smoothly.
#pragma once

#include <limits>

#include "core/joint/tree_solve.h"

namespace godobject {

/// Ends of one coordinate (rad or m): within [-pi, pi] for a turn.
struct StopParams {
  Real lower = -std::numeric_limits<Real>::infinity();
  Real upper = std::numeric_limits<Real>::infinity();
  Real k = 0;      // N m/rad or N/m, beyond `width`
  Real g = 0;      // N m s/rad or N s/m, there too and only on the way in
  Real width = 0;  // over which k and g rise from zero, rad or m, > 0
};

/// The stops part of a joint: one for each of its coordinates, turns first.
struct JointStops {
  struct Params {
    std::array<StopParams, 2> stops;
  };
};

/// (19)  at depth d beyond an end, with s = min(d, width):  T = -(k s (d - s/2) + g s q') / width
///
/// Linearised at the coordinate q^ and rate q^' predicted for the end of the stage; the stage solves for the rate
/// beyond q^'. The spring is convex and stands at most where it is predicted: it never pulls and, like the
/// coupling, never adds energy.
inline AxisTerms stop_terms(const StopParams& par, Real q, Real rate, Real h) noexcept {
  const Real below = std::max(par.lower - q, Real(0)), above = std::max(q - par.upper, Real(0));
  const Real d = below + above;  // one of them is zero
  const Real s = std::min(d, par.width);
  const Real side = below > 0 ? Real(-1) : Real(1);
  const Real share = par.width > 0 ? s / par.width : 0;
  const Real k = share * par.k;
  const Real g = side * rate > 0 ? share * par.g : 0;
  return {.D = h * (g + h * k), .tau = -h * (side * k * (d - Real(0.5) * s) + g * rate)};
}

}  // namespace godobject
