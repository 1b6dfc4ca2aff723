// Stops: springs at the ends of a joint's coordinates, with a smooth onset.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "core/joint/tree_solve.h"

namespace godobject {

/// Ends of one coordinate, rad or m. Rotations may exceed +-pi, because turns are counted.
struct StopParams {
  Real lower = -std::numeric_limits<Real>::infinity();
  Real upper = std::numeric_limits<Real>::infinity();
  Real k = 0;      // N m/rad or N/m, beyond `width`
  Real g = 0;      // N m s/rad or N s/m, beyond `width`, acting on the way in only
  Real width = 0;  // rad or m, > 0: range over which k and g rise from zero
};

/// Whole turns by which a body's target leads it (16).
struct TurnsAhead {
  /// Turns about a rotation of the joint of a body.
  struct About {
    std::uint16_t body = 0, rotation = 0;
    std::int16_t turns = 0;  // 0: unused
  };
  std::array<About, max_wound_axes> list{};

  bool any() const noexcept {
    bool any = false;
    for (const About& about : list) any |= about.turns != 0;
    return any;
  }
};

/// Stops part of a joint: one for each of its coordinates, rotations first.
struct JointStops {
  struct Params {
    std::array<StopParams, 2> stops;
  };
  struct State {
    JointCoordinates q = JointCoordinates::Zero();  // coordinates at the end of the last step, turns counted
    TurnsAhead ahead;
  };
};

/// Returns the initial coordinate of a joint whose rotation is measured as `angle`, rad. Unchanged between
/// the stops, or at most their width deep in one. Otherwise moved by whole turns to be nearest to the middle
/// of the stops. A missing end counts as half a turn beyond the other one.
inline Real start_coordinate(const StopParams& par, Real angle) noexcept {
  constexpr Real open = std::numeric_limits<Real>::infinity();
  if (angle >= par.lower - par.width && angle <= par.upper + par.width) return angle;
  const Real lower = par.lower > -open ? par.lower : par.upper - pi;
  const Real upper = par.upper < open ? par.upper : par.lower + pi;
  return unwrapped(angle, Real(0.5) * (lower + upper));
}

/// Returns the terms of a stop (19), at depth d beyond an end, with s = min(d, width):
///
///   T = -(k s (d - s/2) + g s q') / width
///
/// Linearised at the coordinate q^ and rate q^' predicted for the end of the stage; the stage solves for the
/// rate beyond q^'. The spring is convex and at most as compressed as predicted. It never pulls and, like the
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

/// Returns the branch of the stop's law (19) at q: 0 between the ends, +-1 beyond an end, +-2 deeper than
/// `width`.
inline int stop_branch(const StopParams& par, Real q) noexcept {
  if (q < par.lower) return par.lower - q > par.width ? -2 : -1;
  if (q > par.upper) return q - par.upper > par.width ? 2 : 1;
  return 0;
}
/// True if both coordinates of a joint are on the same branches at q and at q_0.
inline bool on_same_branches(const std::array<StopParams, 2>& stops, const JointCoordinates& q,
                             const JointCoordinates& q_0) noexcept {
  return stop_branch(stops[0], q[0]) == stop_branch(stops[0], q_0[0]) &&
         stop_branch(stops[1], q[1]) == stop_branch(stops[1], q_0[1]);
}

}  // namespace godobject
