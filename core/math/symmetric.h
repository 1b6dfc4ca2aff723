// Symmetric 3 x 3 matrices: of four nodes at once, one per lane, and of one.
#pragma once

#include "core/math/block.h"

namespace godobject {

struct SymmetricPack {
  Vector3<Pack> diagonal, off;  // xx, yy, zz; yz, xz, xy

  friend SymmetricPack operator+(const SymmetricPack& a, const SymmetricPack& b) noexcept {
    return {.diagonal = a.diagonal + b.diagonal, .off = a.off + b.off};
  }
  Vector3<Pack> operator*(const Vector3<Pack>& d) const noexcept {
    return {diagonal[0] * d[0] + off[2] * d[1] + off[1] * d[2],
            off[2] * d[0] + diagonal[1] * d[1] + off[0] * d[2],
            off[1] * d[0] + off[0] * d[1] + diagonal[2] * d[2]};
  }
};

/// Returns A^-1 by cofactors. A: regular; one division.
inline SymmetricPack inverse(const SymmetricPack& A) noexcept {
  const auto& [d, o] = A;
  const Vector3<Pack> diagonal(d[1] * d[2] - o[0] * o[0], d[0] * d[2] - o[1] * o[1],
                               d[0] * d[1] - o[2] * o[2]),
      off(o[1] * o[2] - d[0] * o[0], o[0] * o[2] - d[1] * o[1], o[0] * o[1] - d[2] * o[2]);
  const Pack r = 1 / (d[0] * diagonal[0] + o[2] * off[2] + o[1] * off[1]);
  return {.diagonal = diagonal * r, .off = off * r};
}

struct SymmetricBlock {
  Column diagonal, off;

  static SymmetricBlock zero() noexcept { return {.diagonal = Column(Pack(0)), .off = Column(Pack(0))}; }
  /// Returns a times the identity.
  static SymmetricBlock multiple(Real a) noexcept {
    return {.diagonal = Column(Pack(a)), .off = Column(Pack(0))};
  }
  SymmetricBlock& operator+=(const SymmetricBlock& b) noexcept {
    diagonal += b.diagonal;
    off += b.off;
    return *this;
  }
  friend Column operator*(const SymmetricBlock& A, const Column& d) noexcept {
    const Pack xz = rotated(A.off.p), xy = rotated(xz), yzx = rotated(d.p);
    return Column(A.diagonal.p * d.p + xy * yzx + xz * rotated(yzx));
  }
};

/// Returns b n n^T.
inline SymmetricBlock outer_square(const Column& n, Real b) noexcept {
  const Pack bn = n.p * Pack(b);
  return {.diagonal = Column(bn * n.p), .off = Column(rotated(bn) * rotated(rotated(n.p)))};
}

/// Converts between the matrices of four lanes and four single ones.
inline std::array<SymmetricBlock, 4> blocks(const SymmetricPack& A) noexcept {
  const std::array<Column, 4> diagonal = columns(A.diagonal), off = columns(A.off);
  return {{{diagonal[0], off[0]}, {diagonal[1], off[1]}, {diagonal[2], off[2]}, {diagonal[3], off[3]}}};
}
inline SymmetricPack in_lanes(const SymmetricBlock& a, const SymmetricBlock& b, const SymmetricBlock& c,
                              const SymmetricBlock& d) noexcept {
  return {.diagonal = in_lanes(a.diagonal, b.diagonal, c.diagonal, d.diagonal),
          .off = in_lanes(a.off, b.off, c.off, d.off)};
}

}  // namespace godobject
