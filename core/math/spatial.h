// Twists and wrenches of bodies about their centres of mass, and symmetric 6 x 6 matrices between them.
#pragma once

#include "core/contact/stage.h"

namespace godobject {

inline AnchorTwist operator*(const TwistBlock& A, const AnchorTwist& V) noexcept {
  return {.w = A.ww * V.w + A.wv * V.v, .v = times_transposed(A.wv, V.w) + A.vv * V.v};
}
inline TwistBlock operator*(const TwistBlock& A, Real s) noexcept {
  return {.ww = A.ww * s, .wv = A.wv * s, .vv = A.vv * s};
}
inline TwistBlock& operator+=(TwistBlock& A, const TwistBlock& B) noexcept {
  A.ww += B.ww;
  A.wv += B.wv;
  A.vv += B.vv;
  return A;
}
inline AnchorTwist operator+(const AnchorTwist& a, const AnchorTwist& b) noexcept {
  return {.w = a.w + b.w, .v = a.v + b.v};
}
inline AnchorTwist operator-(const AnchorTwist& a, const AnchorTwist& b) noexcept {
  return {.w = a.w - b.w, .v = a.v - b.v};
}
inline AnchorTwist operator*(const AnchorTwist& a, Real s) noexcept { return {.w = a.w * s, .v = a.v * s}; }
inline Real dot(const AnchorTwist& a, const AnchorTwist& b) noexcept { return dot(a.w, b.w) + dot(a.v, b.v); }

/// A^-1, A positive definite.
inline TwistBlock inverse(const TwistBlock& A) noexcept {
  const Block D = inverse(A.vv), B = A.wv * D, C = inverse(A.ww - B * transposed(A.wv));
  const Block CB = C * B;
  TwistBlock inverse;
  inverse.ww = C;
  inverse.wv = CB * Real(-1);
  inverse.vv = D + transposed(B) * CB;
  return inverse;
}

/// A wrench at d, about the origin of d.
inline AnchorTwist moved_wrench(const AnchorTwist& F, const Column& d) noexcept {
  return {.w = F.w + cross(d, F.v), .v = F.v};
}

/// A^ = X^T A X added to the parent: A taken at d from the parent's centre of mass.
inline void add_to_parent(const TwistBlock& A, const Column& d, TwistBlock& parent) noexcept {
  // X = (1, 0; -[d]x, 1)
  const Block vw = transposed(A.wv) - cross(A.vv, d);
  parent.ww += A.ww - cross(A.wv, d) + cross(d, vw);
  parent.wv += A.wv + cross(d, A.vv);
  parent.vv += A.vv;
}

}  // namespace godobject
