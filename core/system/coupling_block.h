// Blocks of a system of bodies: 6 x 6 matrices between the twists of two, and the factor of that of one.
#pragma once

#include <type_traits>

#include "core/math/spatial.h"

namespace godobject {

/// A 6 x 6 matrix between the twists of two bodies.
struct CouplingBlock {
  Block ww, wv, vw, vv;
};

inline CouplingBlock no_coupling() noexcept {
  const Column none(Pack(0));
  const Block zero{{none, none, none}};
  return {.ww = zero, .wv = zero, .vw = zero, .vv = zero};
}
inline CouplingBlock transposed(const CouplingBlock& A) noexcept {
  return {.ww = transposed(A.ww), .wv = transposed(A.vw), .vw = transposed(A.wv), .vv = transposed(A.vv)};
}
inline CouplingBlock& operator+=(CouplingBlock& A, const CouplingBlock& B) noexcept {
  A.ww += B.ww;
  A.wv += B.wv;
  A.vw += B.vw;
  A.vv += B.vv;
  return A;
}
/// From the child to its parent, d away: -X^T A of the impedance A between them.
inline CouplingBlock coupling(const TwistBlock& A, const Column& d) noexcept {
  const Block A_vw = transposed(A.wv);
  return {.ww = (A.ww + cross(d, A_vw)) * Real(-1),
          .wv = (A.wv + cross(d, A.vv)) * Real(-1),
          .vw = A_vw * Real(-1),
          .vv = A.vv * Real(-1)};
}

/// X^T A X added to the parent, where its coupling to the child is A_pc = -X^T A.
inline void add_to_parent(const CouplingBlock& A_pc, const Column& d, TwistBlock& parent) noexcept {
  parent.ww -= A_pc.ww - cross(A_pc.wv, d);
  parent.wv -= A_pc.wv;
  parent.vv -= A_pc.vv;
}

/// A B^T.
inline Block times_transpose(const Block& A, const Block& B) noexcept {
  const auto column = [&](auto c) noexcept {
    constexpr int j = decltype(c)::value;
    return A.col[0] * B.col[0].all<j>() + A.col[1] * B.col[1].all<j>() + A.col[2] * B.col[2].all<j>();
  };
  return {{column(std::integral_constant<int, 0>{}), column(std::integral_constant<int, 1>{}),
           column(std::integral_constant<int, 2>{})}};
}

/// A = L D L^T of a body. L has ones on its diagonal, which are left out; its blocks and their transposes.
struct PivotFactor {
  Block ww, vw, vv, ww_T, vw_T, vv_T;
  std::array<Pack, 6> D_inverse;
  Column D_inverse_w, D_inverse_v;
};

/// Lanes after j.
template <int j>
Pack below(const Pack& a) noexcept {
  return a * Pack(j < 0 ? 1 : 0, j < 1 ? 1 : 0, j < 2 ? 1 : 0, 0);
}
/// Number j of four, in the first three lanes of a column.
inline Column diagonal(const Pack& x, const Pack& y, const Pack& z) noexcept {
  return Column(shuffled<0, 1, 4, 4>(shuffled<0, 4, 0, 4>(x, y), z));
}

inline PivotFactor factor(const TwistBlock& A) noexcept {
  PivotFactor f;
  std::array<Column, 3> w = A.ww.col, v = transposed(A.wv).col, u = A.vv.col;
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
  const Pack r_3 = f.D_inverse[3] = Pack(1) / u[0].all<0>();
  f.vv.col[0] = Column(below<0>(u[0].p * r_3));
  u[1] -= u[0] * f.vv.col[0].all<1>();
  u[2] -= u[0] * f.vv.col[0].all<2>();
  const Pack r_4 = f.D_inverse[4] = Pack(1) / u[1].all<1>();
  f.vv.col[1] = Column(below<1>(u[1].p * r_4));
  u[2] -= u[1] * f.vv.col[1].all<2>();
  f.D_inverse[5] = Pack(1) / u[2].all<2>();
  f.vv.col[2] = Column(Pack(0));
  f.ww_T = transposed(f.ww);
  f.vw_T = transposed(f.vw);
  f.vv_T = transposed(f.vv);
  f.D_inverse_w = diagonal(f.D_inverse[0], f.D_inverse[1], f.D_inverse[2]);
  f.D_inverse_v = diagonal(f.D_inverse[3], f.D_inverse[4], f.D_inverse[5]);
  return f;
}
/// L^-1 b.
inline AnchorTwist lowered(const PivotFactor& f, AnchorTwist b) noexcept {
  b.w -= f.ww.col[0] * b.w.all<0>();
  b.w -= f.ww.col[1] * b.w.all<1>();
  b.v -= f.vw * b.w;
  b.v -= f.vv.col[0] * b.v.all<0>();
  b.v -= f.vv.col[1] * b.v.all<1>();
  return b;
}
/// D^-1 b.
inline AnchorTwist scaled(const AnchorTwist& b, const PivotFactor& f) noexcept {
  return {.w = Column(b.w.p * f.D_inverse_w.p), .v = Column(b.v.p * f.D_inverse_v.p)};
}
/// L^-T b.
inline AnchorTwist raised(const PivotFactor& f, AnchorTwist V) noexcept {
  V.v -= f.vv_T.col[2] * V.v.all<2>();
  V.v -= f.vv_T.col[1] * V.v.all<1>();
  V.w -= f.vw_T * V.v;
  V.w -= f.ww_T.col[2] * V.w.all<2>();
  V.w -= f.ww_T.col[1] * V.w.all<1>();
  return V;
}
/// A L^-T, by substitution: what is small beside the rest keeps its digits.
inline void substitute(const PivotFactor& f, CouplingBlock& A) noexcept {
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
  from_w(std::integral_constant<int, 0>{});
  from_w(std::integral_constant<int, 1>{});
  from_w(std::integral_constant<int, 2>{});
  for (std::size_t m = 0; m < 2; ++m) {
    for (std::size_t c = m + 1; c < 3; ++c) {
      const Pack l = f.vv.col[m].p[c];
      A.wv.col[c] -= A.wv.col[m] * l;
      A.vv.col[c] -= A.vv.col[m] * l;
    }
  }
}
/// A D^-1.
inline CouplingBlock scaled(CouplingBlock A, const PivotFactor& f) noexcept {
  for (std::size_t c = 0; c < 3; ++c) {
    for (Block* of_w : {&A.ww, &A.vw}) of_w->col[c] = of_w->col[c] * f.D_inverse[c];
    for (Block* of_v : {&A.wv, &A.vv}) of_v->col[c] = of_v->col[c] * f.D_inverse[c + 3];
  }
  return A;
}
/// C -= A B^T.
inline void subtract_product(const CouplingBlock& A, const CouplingBlock& B, CouplingBlock& C) noexcept {
  C.ww -= times_transpose(A.ww, B.ww) + times_transpose(A.wv, B.wv);
  C.wv -= times_transpose(A.ww, B.vw) + times_transpose(A.wv, B.vv);
  C.vw -= times_transpose(A.vw, B.ww) + times_transpose(A.vv, B.wv);
  C.vv -= times_transpose(A.vw, B.vw) + times_transpose(A.vv, B.vv);
}
inline void subtract_product(const CouplingBlock& A, const CouplingBlock& B, TwistBlock& C) noexcept {
  C.ww -= times_transpose(A.ww, B.ww) + times_transpose(A.wv, B.wv);
  C.wv -= times_transpose(A.ww, B.vw) + times_transpose(A.wv, B.vv);
  C.vv -= times_transpose(A.vw, B.vw) + times_transpose(A.vv, B.vv);
}
inline AnchorTwist operator*(const CouplingBlock& A, const AnchorTwist& V) noexcept {
  return {.w = A.ww * V.w + A.wv * V.v, .v = A.vw * V.w + A.vv * V.v};
}
inline AnchorTwist times_transposed(const CouplingBlock& A, const AnchorTwist& F) noexcept {
  return {.w = times_transposed(A.ww, F.w) + times_transposed(A.vw, F.v),
          .v = times_transposed(A.wv, F.w) + times_transposed(A.vv, F.v)};
}

}  // namespace godobject
