// Correction of joint violations by a stage: a compile-time choice of the scene's Joints part.
#pragma once

#include "core/joint/joint.h"
#include "core/tuning.h"

namespace godobject {

/// Joint at an instant.
struct JointAt {
  JointFrames X;
  Twist V;  // twist of the child's anchor relative to the parent, world axes
};

/// Returns V without its components along the axes of the joint.
template <int turns, int slides>
Twist across(const JointMotion<turns, slides>& m, Twist V) noexcept {
  if constexpr (turns == 3) V.w.setZero();
  for (const Vec3& s : m.turn) V.w -= s * s.dot(V.w);
  for (const Vec3& s : m.slide) V.v -= s * s.dot(V.v);
  return V;
}

/// Returns the residual of a violation after a correction of at most `most`.
inline Vec3 left(const Vec3& g, Real most) noexcept {
  const Real length = std::sqrt(g.squaredNorm());
  return length > most ? Vec3(g * (1 - most / length)) : Vec3(Vec3::Zero());
}

/// Stabilisation (18):  L V+ = L V^ - g / h, evaluated at the predicted pose at the end of the stage.
/// Dead-beat and of second order. Violations above max_turned_back and max_moved_back are corrected over
/// several stages, because the linearisation does not hold for large rotations.
struct AtPrediction {
  static constexpr bool uses_base =
      false;  // alternatives evaluated at the start of the stage: tests/support/stabilisation.h

  /// lever_sq: squared lever, m^2; zero for an anchor in the centre of mass, which rotates nothing.
  template <class M>
  static Twist beta(const M& predicted, const Twist& V_hat, Real lever_sq, Real h) noexcept {
    Twist e = {.w = predicted.e_w, .v = predicted.e_v};
    const bool far_turned = M::num_turns < 3 && e.w.squaredNorm() > max_turned_back * max_turned_back;
    const bool far_apart = lever_sq > 0 && e.v.squaredNorm() > max_moved_back * max_moved_back * lever_sq;
    if (far_turned || far_apart) {
      // the violation at the start of the stage is e - h V
      const Twist V = across(predicted, V_hat);
      if (far_turned) e.w -= left(e.w - h * V.w, max_turned_back);
      if (far_apart) e.v -= left(e.v - h * V.v, max_moved_back * std::sqrt(lever_sq));
    }
    return {.w = V_hat.w - e.w * (1 / h), .v = V_hat.v - e.v * (1 / h)};
  }
};

}  // namespace godobject
