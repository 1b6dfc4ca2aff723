// L D L^T of the diagonal block of one unknown, 6 x 6 or 3 x 3, and its operations on neighbouring blocks.
//
// By substitution, without an inverse, so that small entries beside large ones keep their digits. Unknowns of
// three numbers are stored in v, without w.
#pragma once

#include "core/math/spatial.h"

namespace godobject {

/// A = L D L^T: blocks of L and their transposes. The unit diagonal of L is not stored.
struct Pivot {
  Block ww, vw, vv, ww_T, vw_T, vv_T;
  std::array<Pack, 6> D_inverse;
  Column D_inverse_w, D_inverse_v;
};

/// Returns the lanes after j, zero elsewhere.
template <int j>
Pack below(const Pack& a) noexcept {
  return a * Pack(j < 0 ? 1 : 0, j < 1 ? 1 : 0, j < 2 ? 1 : 0, 0);
}
/// Returns a diagonal from its numbers, each in all lanes.
inline Column diagonal(const Pack& x, const Pack& y, const Pack& z) noexcept {
  return Column(shuffled<0, 1, 4, 4>(shuffled<0, 4, 0, 4>(x, y), z));
}

/// Factors the last three numbers of a pivot. u: Schur complement of A_vv.
inline void factor_v(std::array<Column, 3>& u, Pivot& f) noexcept {
  const Pack r_3 = f.D_inverse[3] = Pack(1) / u[0].all<0>();
  f.vv.col[0] = Column(below<0>(u[0].p * r_3));
  u[1] -= u[0] * f.vv.col[0].all<1>();
  u[2] -= u[0] * f.vv.col[0].all<2>();
  const Pack r_4 = f.D_inverse[4] = Pack(1) / u[1].all<1>();
  f.vv.col[1] = Column(below<1>(u[1].p * r_4));
  u[2] -= u[1] * f.vv.col[1].all<2>();
  f.D_inverse[5] = Pack(1) / u[2].all<2>();
  f.vv.col[2] = Column(Pack(0));
  f.vv_T = transposed(f.vv);
  f.D_inverse_v = diagonal(f.D_inverse[3], f.D_inverse[4], f.D_inverse[5]);
}

/// Factors a diagonal block. rows: in threes, 2 for (w, v), 1 for v alone.
template <int rows>
void factor(const SymmetricSpatialMatrix& A, Pivot& f) noexcept {
  std::array<Column, 3> u = A.vv.col;
  if constexpr (rows == 2) {
    std::array<Column, 3> w = A.ww.col, v = transposed(A.wv).col;
    // a column of six, rows w and v; then those of v alone
    const auto eliminate = [&]<int p>(std::integral_constant<int, p>) noexcept {
      const Pack r = f.D_inverse[p] = Pack(1) / w[p].template all<p>();
      const Column l_w = f.ww.col[p] = Column(below<p>(w[p].p * r)), l_v = f.vw.col[p] = v[p] * r;
      const auto from_column = [&]<int c>(std::integral_constant<int, c>) noexcept {
        if constexpr (c > p) {
          const Pack l = l_w.template all<c>();
          w[c] -= w[p] * l;
          v[c] -= v[p] * l;
        }
        u[c] -= v[p] * l_v.template all<c>();
      };
      from_column(std::integral_constant<int, 0>{});
      from_column(std::integral_constant<int, 1>{});
      from_column(std::integral_constant<int, 2>{});
    };
    eliminate(std::integral_constant<int, 0>{});
    eliminate(std::integral_constant<int, 1>{});
    eliminate(std::integral_constant<int, 2>{});
    f.ww_T = transposed(f.ww);
    f.vw_T = transposed(f.vw);
    f.D_inverse_w = diagonal(f.D_inverse[0], f.D_inverse[1], f.D_inverse[2]);
  }
  factor_v(u, f);
}

/// Returns L^-1 b.
template <int rows>
SpatialVector solve_lower(const Pivot& f, SpatialVector b) noexcept {
  if constexpr (rows == 2) {
    b.w -= f.ww.col[0] * b.w.all<0>();
    b.w -= f.ww.col[1] * b.w.all<1>();
    b.v -= f.vw * b.w;
  }
  b.v -= f.vv.col[0] * b.v.all<0>();
  b.v -= f.vv.col[1] * b.v.all<1>();
  return b;
}
/// Returns D^-1 b.
template <int rows>
SpatialVector scaled(const SpatialVector& b, const Pivot& f) noexcept {
  SpatialVector scaled{.w = Column(Pack(0)), .v = Column(b.v.p * f.D_inverse_v.p)};
  if constexpr (rows == 2) scaled.w = Column(b.w.p * f.D_inverse_w.p);
  return scaled;
}
/// Returns L^-T b.
template <int rows>
SpatialVector solve_upper(const Pivot& f, SpatialVector V) noexcept {
  V.v -= f.vv_T.col[2] * V.v.all<2>();
  V.v -= f.vv_T.col[1] * V.v.all<1>();
  if constexpr (rows == 2) {
    V.w -= f.vw_T * V.v;
    V.w -= f.ww_T.col[2] * V.w.all<2>();
    V.w -= f.ww_T.col[1] * V.w.all<1>();
  }
  return V;
}

/// Computes A L^-T. columns: those of the pivot in threes, also in the functions below.
template <int columns>
void substitute(const Pivot& f, SpatialMatrix& A) noexcept {
  const auto from_w = [&]<int m>(std::integral_constant<int, m>) noexcept {
    for (std::size_t c = m + 1; c < 3; ++c) {
      const Pack l = f.ww.col[m].p[c];
      A.ww.col[c] -= A.ww.col[m] * l;
      A.vw.col[c] -= A.vw.col[m] * l;
    }
    for (std::size_t c = 0; c < 3; ++c) {
      const Pack l = f.vw.col[m].p[c];
      A.wv.col[c] -= A.ww.col[m] * l;
      A.vv.col[c] -= A.vw.col[m] * l;
    }
  };
  if constexpr (columns == 2) {
    from_w(std::integral_constant<int, 0>{});
    from_w(std::integral_constant<int, 1>{});
    from_w(std::integral_constant<int, 2>{});
  }
  for (std::size_t m = 0; m < 2; ++m) {
    for (std::size_t c = m + 1; c < 3; ++c) {
      const Pack l = f.vv.col[m].p[c];
      A.wv.col[c] -= A.wv.col[m] * l;
      A.vv.col[c] -= A.vv.col[m] * l;
    }
  }
}
/// Returns A D^-1.
template <int columns>
SpatialMatrix scaled(const SpatialMatrix& A, const Pivot& f) noexcept {
  SpatialMatrix scaled;
  for (std::size_t c = 0; c < 3; ++c) {
    if constexpr (columns == 2) {
      scaled.ww.col[c] = A.ww.col[c] * f.D_inverse[c];
      scaled.vw.col[c] = A.vw.col[c] * f.D_inverse[c];
    }
    scaled.wv.col[c] = A.wv.col[c] * f.D_inverse[c + 3];
    scaled.vv.col[c] = A.vv.col[c] * f.D_inverse[c + 3];
  }
  return scaled;
}

/// Returns A B^T of two rows of blocks, (w, v) or v alone. Inlined, because a call passes blocks through
/// memory.
template <int columns>
[[gnu::always_inline]] inline Block times_transpose(const Block& A_w, const Block& A_v, const Block& B_w,
                                                    const Block& B_v) noexcept {
  if constexpr (columns == 1) return times_transpose(A_v, B_v);
  else return times_transpose(A_w, B_w) + times_transpose(A_v, B_v);
}
/// Computes C -= A B^T.
template <int columns>
void subtract_product(const SpatialMatrix& A, const SpatialMatrix& B, SpatialMatrix& C) noexcept {
  C.ww -= times_transpose<columns>(A.ww, A.wv, B.ww, B.wv);
  C.wv -= times_transpose<columns>(A.ww, A.wv, B.vw, B.vv);
  C.vw -= times_transpose<columns>(A.vw, A.vv, B.ww, B.wv);
  C.vv -= times_transpose<columns>(A.vw, A.vv, B.vw, B.vv);
}
template <int columns>
void subtract_product(const SpatialMatrix& A, const SpatialMatrix& B, SymmetricSpatialMatrix& C) noexcept {
  C.ww -= times_transpose<columns>(A.ww, A.wv, B.ww, B.wv);
  C.wv -= times_transpose<columns>(A.ww, A.wv, B.vw, B.vv);
  C.vv -= times_transpose<columns>(A.vw, A.vv, B.vw, B.vv);
}

/// Computes b -= A V.
template <int columns>
void subtract_product(const SpatialMatrix& A, const SpatialVector& V, SpatialVector& b) noexcept {
  b.w -= columns == 2 ? A.ww * V.w + A.wv * V.v : A.wv * V.v;
  b.v -= columns == 2 ? A.vw * V.w + A.vv * V.v : A.vv * V.v;
}
/// Computes sum += A^T V.
template <int columns>
void add_product_transposed(const SpatialMatrix& A, const SpatialVector& V, SpatialVector& sum) noexcept {
  if constexpr (columns == 2) {
    sum.w += times_transposed(A.vw, V.v);
    sum.w += times_transposed(A.ww, V.w);
  }
  sum.v += times_transposed(A.vv, V.v);
  sum.v += times_transposed(A.wv, V.w);
}

}  // namespace godobject
