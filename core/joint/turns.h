// Counted turns of joints: angles are measured within half a turn, coordinates are continuous.
#pragma once

#include "core/joint/joint.h"

namespace godobject {

/// Returns q with rotations nearest to those of `near`, translations unchanged. Three rotations have no
/// coordinates.
inline JointCoordinates unwrapped(JointCoordinates q, const JointCoordinates& near, int turns) noexcept {
  for (int c = 0; turns < 3 && c < turns; ++c) q[c] = unwrapped(q[c], near[c]);
  return q;
}

/// Returns the coordinates of a joint at frames X whose child rotates against its parent with w, rad/s.
/// q: the coordinates a time t, s, before. Rotations are those nearest to q + t q'.
template <class Kind>
JointCoordinates counted(const JointFrames& X, const Vec3& w, JointCoordinates q, Real t) noexcept {
  const auto m = Kind::motion(X);
  constexpr int turns = decltype(m)::num_turns;
  for (int c = 0; c < turns; ++c) q[c] += t * m.turn[static_cast<std::size_t>(c)].dot(w);
  return unwrapped(Kind::coordinates(X), q, turns);
}

}  // namespace godobject
