// How a stage takes back what a joint is violated by: a choice of the scene's Joints part, at compile time.
#pragma once

#include "core/joint/joint.h"
#include "core/tuning.h"

namespace godobject {

/// A joint at an instant.
struct JointAt {
  JointFrames X;
  Twist V;  // of the child's anchor against the parent, world axes
};

/// V without its part along the axes of the joint.
template <int turns, int slides>
Twist across(const JointMotion<turns, slides>& m, Twist V) noexcept {
  if constexpr (turns == 3) V.w.setZero();
  for (const Vec3& s : m.turn) V.w -= s * s.dot(V.w);
  for (const Vec3& s : m.slide) V.v -= s * s.dot(V.v);
  return V;
}

/// What is left of a violation after taking back a length of at most `most`.
inline Vec3 left(const Vec3& g, Real most) noexcept {
  const Real length = std::sqrt(g.squaredNorm());
  return length > most ? Vec3(g * (1 - most / length)) : Vec3(Vec3::Zero());
}

/// (18)  L V+ = L V^ - g / h, all of it at the pose the stage is predicted to end at: dead-beat, and second order.
/// A joint that is far apart comes together over some stages, since a stage that turns a body far is linear in vain.
struct AtPrediction {
  static constexpr bool uses_base =
      false;  // others ask where the stage starts: tests/support/stabilisation.h

  /// lever_sq: zero for an anchor in the centre of mass, which turns nothing.
  template <class M>
  static Twist beta(const M& predicted, const Twist& V_hat, Real lever_sq, Real h) noexcept {
    Twist e = {.w = predicted.e_w, .v = predicted.e_v};
    const bool far_turned = M::num_turns < 3 && e.w.squaredNorm() > max_turned_back * max_turned_back;
    const bool far_apart = lever_sq > 0 && e.v.squaredNorm() > max_moved_back * max_moved_back * lever_sq;
    if (far_turned || far_apart) {
      // the violation where the stage starts is e - h V
      const Twist V = across(predicted, V_hat);
      if (far_turned) e.w -= left(e.w - h * V.w, max_turned_back);
      if (far_apart) e.v -= left(e.v - h * V.v, max_moved_back * std::sqrt(lever_sq));
    }
    return {.w = V_hat.w - e.w * (1 / h), .v = V_hat.v - e.v * (1 / h)};
  }
};

}  // namespace godobject
