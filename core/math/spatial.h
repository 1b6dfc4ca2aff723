// Spatial algebra (Featherstone 2008): twists and wrenches as vectors of six, and 6 x 6 matrices between them
// in 3 x 3 blocks. World axes; rotations and torques (w) before translations and forces (v).
//
// X shifts a rigid motion from one point to another, d away: X = (1, 0; -[d]x, 1). The twist at the other
// point is X V; a wrench there is X^T F here.
#pragma once

#include "core/math/block.h"

namespace godobject {

/// Twist (angular velocity, velocity), or wrench or impulse (torque, force).
struct SpatialVector {
  Column w, v;

  static SpatialVector zero() noexcept { return {.w = Column(Pack(0)), .v = Column(Pack(0))}; }

  SpatialVector& operator+=(const SpatialVector& b) noexcept { return w += b.w, v += b.v, *this; }
  SpatialVector& operator-=(const SpatialVector& b) noexcept { return w -= b.w, v -= b.v, *this; }
  friend SpatialVector operator+(SpatialVector a, const SpatialVector& b) noexcept { return a += b; }
  friend SpatialVector operator-(SpatialVector a, const SpatialVector& b) noexcept { return a -= b; }
  friend SpatialVector operator*(const SpatialVector& a, Real s) noexcept {
    return {.w = a.w * s, .v = a.v * s};
  }
};

inline Real dot(const SpatialVector& a, const SpatialVector& b) noexcept {
  return dot(a.w, b.w) + dot(a.v, b.v);
}

/// Sum of scalar products.
class SpatialSum {
 public:
  void add(const SpatialVector& a, const SpatialVector& b) noexcept { sum_ += a.w.p * b.w.p + a.v.p * b.v.p; }
  void add(const Column& a, const Column& b) noexcept { sum_ += a.p * b.p; }
  operator Real() const noexcept { return (sum_[0] + sum_[1]) + sum_[2]; }

 private:
  Pack sum_ = 0;
};

/// Returns X V: the twist of the same rigid motion d away.
inline SpatialVector shifted(const SpatialVector& V, const Column& d) noexcept {
  return {.w = V.w, .v = V.v + cross(V.w, d)};
}
/// Returns X^T F: a wrench at d, about the origin of d.
inline SpatialVector moved_wrench(const SpatialVector& F, const Column& d) noexcept {
  return {.w = F.w + cross(d, F.v), .v = F.v};
}

/// General 6 x 6 matrix.
struct SpatialMatrix {
  Block ww, wv, vw, vv;

  static SpatialMatrix zero() noexcept {
    return {.ww = Block::zero(), .wv = Block::zero(), .vw = Block::zero(), .vv = Block::zero()};
  }
};

inline SpatialMatrix transposed(const SpatialMatrix& A) noexcept {
  return {.ww = transposed(A.ww), .wv = transposed(A.vw), .vw = transposed(A.wv), .vv = transposed(A.vv)};
}
inline SpatialMatrix& operator+=(SpatialMatrix& A, const SpatialMatrix& B) noexcept {
  A.ww += B.ww;
  A.wv += B.wv;
  A.vw += B.vw;
  A.vv += B.vv;
  return A;
}
inline SpatialVector operator*(const SpatialMatrix& A, const SpatialVector& V) noexcept {
  return {.w = A.ww * V.w + A.wv * V.v, .v = A.vw * V.w + A.vv * V.v};
}
/// Returns A^T F.
inline SpatialVector times_transposed(const SpatialMatrix& A, const SpatialVector& F) noexcept {
  return {.w = times_transposed(A.ww, F.w) + times_transposed(A.vw, F.v),
          .v = times_transposed(A.wv, F.w) + times_transposed(A.vv, F.v)};
}
/// Returns A X.
inline SpatialMatrix shifted(const SpatialMatrix& A, const Column& d) noexcept {
  return {.ww = A.ww - cross(A.wv, d), .wv = A.wv, .vw = A.vw - cross(A.vv, d), .vv = A.vv};
}
/// Adds X^T A X to the parent, d away.
inline void add_to_parent(const SpatialMatrix& A, const Column& d, SpatialMatrix& parent) noexcept {
  const Block vw = A.vw - cross(A.vv, d);
  parent.ww += A.ww - cross(A.wv, d) + cross(d, vw);
  parent.wv += A.wv + cross(d, A.vv);
  parent.vw += vw;
  parent.vv += A.vv;
}

/// Returns A^-1 F, by 3 x 3 blocks.
inline SpatialVector solved(const SpatialMatrix& A, const SpatialVector& F) noexcept {
  const Block A_vv_inverse = inverse(A.vv);
  const Block B = A.wv * A_vv_inverse;
  const Column w = inverse(A.ww - B * A.vw) * (F.w - B * F.v);
  return {.w = w, .v = A_vv_inverse * (F.v - A.vw * w)};
}

/// Symmetric 6 x 6 matrix; its vw is the transposed wv.
struct SymmetricSpatialMatrix {
  Block ww, wv, vv;
};

inline SymmetricSpatialMatrix& operator+=(SymmetricSpatialMatrix& A,
                                          const SymmetricSpatialMatrix& B) noexcept {
  A.ww += B.ww;
  A.wv += B.wv;
  A.vv += B.vv;
  return A;
}
inline SymmetricSpatialMatrix operator*(const SymmetricSpatialMatrix& A, Real s) noexcept {
  return {.ww = A.ww * s, .wv = A.wv * s, .vv = A.vv * s};
}
inline SpatialVector operator*(const SymmetricSpatialMatrix& A, const SpatialVector& V) noexcept {
  return {.w = A.ww * V.w + A.wv * V.v, .v = times_transposed(A.wv, V.w) + A.vv * V.v};
}
/// Adds B + B^T to A.
inline void add_both(const SpatialMatrix& B, SymmetricSpatialMatrix& A) noexcept {
  A.ww += B.ww + transposed(B.ww);
  A.wv += B.wv + transposed(B.vw);
  A.vv += B.vv + transposed(B.vv);
}
/// Adds X^T A X to the parent, d away.
inline void add_to_parent(const SymmetricSpatialMatrix& A, const Column& d,
                          SymmetricSpatialMatrix& parent) noexcept {
  const Block vw = transposed(A.wv) - cross(A.vv, d);
  parent.ww += A.ww - cross(A.wv, d) + cross(d, vw);
  parent.wv += A.wv + cross(d, A.vv);
  parent.vv += A.vv;
}
/// Returns -X^T A, the coupling of a body to its parent, d away, by an effective mass A of their relative
/// twist.
inline SpatialMatrix coupling(const SymmetricSpatialMatrix& A, const Column& d) noexcept {
  const Block A_vw = transposed(A.wv);
  return {.ww = (A.ww + cross(d, A_vw)) * Real(-1),
          .wv = (A.wv + cross(d, A.vv)) * Real(-1),
          .vw = A_vw * Real(-1),
          .vv = A.vv * Real(-1)};
}
/// Adds X^T A X to the parent, given the coupling A_pc = -X^T A to the child.
inline void add_coupled_to_parent(const SpatialMatrix& A_pc, const Column& d,
                                  SymmetricSpatialMatrix& parent) noexcept {
  parent.ww -= A_pc.ww - cross(A_pc.wv, d);
  parent.wv -= A_pc.wv;
  parent.vv -= A_pc.vv;
}

}  // namespace godobject
