// Vectors of three and 3 x 3 blocks for the elimination along the tree. Padded to four numbers, so that a
// column is one operation (docs/decisions/016). The fourth number is copied but never read.
#pragma once

#include <type_traits>

#include "core/math/simd4.h"

namespace godobject {

/// Column (x, y, z, any).
struct Column {
  Pack p = 0;

  Column() = default;
  explicit Column(const Pack& a) noexcept : p(a) {}
  explicit Column(const Vec3& a) noexcept : p(a.x(), a.y(), a.z(), a.z()) {}
  Real x() const noexcept { return p[0]; }
  Real y() const noexcept { return p[1]; }
  Real z() const noexcept { return p[2]; }
  /// Returns number j in all four places.
  template <int j>
  Pack all() const noexcept {
    return shuffled<j, j, j, j>(p, p);
  }
  Vec3 vec() const noexcept { return {x(), y(), z()}; }

  Column& operator+=(const Column& b) noexcept { return p += b.p, *this; }
  Column& operator-=(const Column& b) noexcept { return p -= b.p, *this; }
  friend Column operator+(const Column& a, const Column& b) noexcept { return Column(a.p + b.p); }
  friend Column operator-(const Column& a, const Column& b) noexcept { return Column(a.p - b.p); }
  friend Column operator-(const Column& a) noexcept { return Column(-a.p); }
  friend Column operator*(const Column& a, Real s) noexcept { return Column(a.p * s); }
  friend Column operator*(const Column& a, const Pack& s) noexcept { return Column(a.p * s); }
};

inline Real dot(const Column& a, const Column& b) noexcept {
  const Pack m = a.p * b.p;
  return (m[0] + m[1]) + m[2];
}

/// Returns (y, z, x, any).
inline Pack rotated(const Pack& a) noexcept { return shuffled<1, 2, 0, 3>(a, a); }

inline Column cross(const Column& a, const Column& b) noexcept {
  return Column(rotated(a.p * rotated(b.p) - rotated(a.p) * b.p));
}

/// Matrix of three columns.
struct Block {
  std::array<Column, 3> col;

  static Block identity() noexcept {
    return {{Column(Vec3::UnitX()), Column(Vec3::UnitY()), Column(Vec3::UnitZ())}};
  }
  static Block zero() noexcept { return {{Column(Pack(0)), Column(Pack(0)), Column(Pack(0))}}; }

  Block& operator+=(const Block& b) noexcept {
    for (std::size_t c = 0; c < 3; ++c) col[c] += b.col[c];
    return *this;
  }
  Block& operator-=(const Block& b) noexcept {
    for (std::size_t c = 0; c < 3; ++c) col[c] -= b.col[c];
    return *this;
  }
  friend Block operator+(Block a, const Block& b) noexcept { return a += b; }
  friend Block operator-(Block a, const Block& b) noexcept { return a -= b; }
  friend Block operator*(const Block& A, Real s) noexcept {
    return {{A.col[0] * s, A.col[1] * s, A.col[2] * s}};
  }
  friend Column operator*(const Block& A, const Column& b) noexcept {
    return A.col[0] * b.all<0>() + A.col[1] * b.all<1>() + A.col[2] * b.all<2>();
  }
  friend Block operator*(const Block& A, const Block& B) noexcept {
    return {{A * B.col[0], A * B.col[1], A * B.col[2]}};
  }
};

/// Returns the block whose rows are the given columns.
inline Block transposed(const Column& a, const Column& b, const Column& c) noexcept {
  const Pack ab_02 = shuffled<0, 4, 2, 6>(a.p, b.p), ab_13 = shuffled<1, 5, 3, 7>(a.p, b.p);
  const Pack c_02 = shuffled<0, 4, 2, 6>(c.p, c.p), c_13 = shuffled<1, 5, 3, 7>(c.p, c.p);
  return {{Column(shuffled<0, 1, 4, 5>(ab_02, c_02)), Column(shuffled<0, 1, 4, 5>(ab_13, c_13)),
           Column(shuffled<2, 3, 6, 7>(ab_02, c_02))}};
}

inline Block transposed(const Block& A) noexcept { return transposed(A.col[0], A.col[1], A.col[2]); }

/// Returns a b^T.
inline Block outer(const Column& a, const Column& b) noexcept {
  return {{a * b.all<0>(), a * b.all<1>(), a * b.all<2>()}};
}

/// Returns A^T b.
inline Column times_transposed(const Block& A, const Column& b) noexcept {
  const Block m = transposed(Column(A.col[0].p * b.p), Column(A.col[1].p * b.p), Column(A.col[2].p * b.p));
  return m.col[0] + m.col[1] + m.col[2];
}

/// Returns A B^T.
inline Block times_transpose(const Block& A, const Block& B) noexcept {
  const auto column = [&](auto c) noexcept {
    constexpr int j = decltype(c)::value;
    return A.col[0] * B.col[0].all<j>() + A.col[1] * B.col[1].all<j>() + A.col[2] * B.col[2].all<j>();
  };
  return {{column(std::integral_constant<int, 0>{}), column(std::integral_constant<int, 1>{}),
           column(std::integral_constant<int, 2>{})}};
}

/// Returns [d]x A.
inline Block cross(const Column& d, const Block& A) noexcept {
  return {{cross(d, A.col[0]), cross(d, A.col[1]), cross(d, A.col[2])}};
}
/// Returns A [d]x.
inline Block cross(const Block& A, const Column& d) noexcept {
  const Pack x = d.all<0>(), y = d.all<1>(), z = d.all<2>();
  return {{A.col[1] * z - A.col[2] * y, A.col[2] * x - A.col[0] * z, A.col[0] * y - A.col[1] * x}};
}

/// Returns A^-1 by cofactors. A: regular; one division.
inline Block inverse(const Block& A) noexcept {
  const Column c0 = cross(A.col[1], A.col[2]), c1 = cross(A.col[2], A.col[0]), c2 = cross(A.col[0], A.col[1]);
  const Real r = 1 / dot(A.col[0], c0);
  return transposed(c0 * r, c1 * r, c2 * r);
}

/// Converts vectors of bodies in lanes to one column per body.
inline std::array<Column, 1> columns(const Vec3& a) noexcept { return {Column(a)}; }
inline std::array<Column, 4> columns(const Vector3<Pack>& a) noexcept {
  const Pack xy_02 = shuffled<0, 4, 2, 6>(a[0], a[1]), xy_13 = shuffled<1, 5, 3, 7>(a[0], a[1]);
  const Pack z_02 = shuffled<0, 4, 2, 6>(a[2], a[2]), z_13 = shuffled<1, 5, 3, 7>(a[2], a[2]);
  return {Column(shuffled<0, 1, 4, 5>(xy_02, z_02)), Column(shuffled<0, 1, 4, 5>(xy_13, z_13)),
          Column(shuffled<2, 3, 6, 7>(xy_02, z_02)), Column(shuffled<2, 3, 6, 7>(xy_13, z_13))};
}

/// Converts one column per body to vectors in lanes.
inline Vector3<Pack> in_lanes(const Column& a, const Column& b, const Column& c, const Column& d) noexcept {
  const Pack ab_02 = shuffled<0, 4, 2, 6>(a.p, b.p), ab_1 = shuffled<1, 5, 3, 7>(a.p, b.p);
  const Pack cd_02 = shuffled<0, 4, 2, 6>(c.p, d.p), cd_1 = shuffled<1, 5, 3, 7>(c.p, d.p);
  return {shuffled<0, 1, 4, 5>(ab_02, cd_02), shuffled<0, 1, 4, 5>(ab_1, cd_1),
          shuffled<2, 3, 6, 7>(ab_02, cd_02)};
}

}  // namespace godobject
