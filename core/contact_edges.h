// Edges of boxes that cross each other: what spheres at the corners do not see.
//
// Two boxes of which no corner is in the other touch where an edge of the one crosses an edge of the other. With a_i along
// the one and b_j along the other,
//
//   (32)  n = a_i x b_j / |a_i x b_j|
//
// of the axes that may separate two boxes these are nine, the normals of their faces the other six. Edges cross when the
// points of them that are nearest to each other are between their ends; they touch when their depth along n is no more
// than that of the faces: otherwise the boxes leave each other through a face. Bound for a pair of boxes: nine axes, four
// pairs of edges along each.
#pragma once

#include <bit>

#include "core/contact_place.h"

namespace godobject {

/// Edges nearer to each other than this part of the thinnest half extent may come to bear a force within the stage.
inline constexpr Real edge_reach = 0.02;
/// Edges that cross nearer to an end than this part of their half length are left to the sphere there.
inline constexpr Real edge_end = 0.01;
/// Edges may be deeper than the faces by these parts, of the faces' depth and of the reach: where boxes lie on each other
/// both axes are nearly one.
inline constexpr Real deeper_than_faces = 0.1, deeper_than_reach = 0.1;
/// Edges with a smaller sine between them are parallel.
inline constexpr Real min_edge_sine = 0.01;

/// Edges of two boxes that cross, in the world.
struct EdgeCrossing {
  std::uint32_t edges = 0;  // which of a, which of b
  Real d = 0;               // depth, m
  Vec3 p_W, n_W;            // on the edge of a; off b
};

/// Number j of a pack; a row; a number of one.
inline Real lane(const Pack& a, int j) noexcept { return a[static_cast<std::size_t>(j)]; }
inline const Pack& row_of(const std::array<Pack, 3>& rows, int row) noexcept {
  return rows[static_cast<std::size_t>(row)];
}
inline Real lane(const std::array<Pack, 3>& rows, int row, int column) noexcept {
  return lane(row_of(rows, row), column);
}

/// Box b as box a sees it. Lane j: axis j of b; the fourth is worthless.
struct BoxOnBox {
  Vec3 h_a, h_b;             // half extents
  Pack p_A, p_B;             // from a to b: in the frame of a; of b
  std::array<Pack, 3> R, E;  // rows of R_AB, and their absolute values

  BoxOnBox(const ShapeParams& a, const Mat3& R_WA, const ShapeParams& b, const Mat3& R_WB) noexcept
      : h_a(a.half_extents), h_b(b.half_extents) {
    const std::array<Pack, 3> a_W = rows(R_WA), b_W = rows(R_WB);
    const Vec3 p_W = b.X_WS.p - a.X_WS.p;
    p_A = a_W[0] * p_W[0] + a_W[1] * p_W[1] + a_W[2] * p_W[2];
    p_B = b_W[0] * p_W[0] + b_W[1] * p_W[1] + b_W[2] * p_W[2];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = R_WA.col(static_cast<int>(k));
      R[k] = b_W[0] * axis[0] + b_W[1] * axis[1] + b_W[2] * axis[2];
      E[k] = abs(R[k]);
    }
  }

 private:
  static std::array<Pack, 3> rows(const Mat3& A) noexcept {
    return {Pack(A(0, 0), A(0, 1), A(0, 2), A(0, 2)), Pack(A(1, 0), A(1, 1), A(1, 2), A(1, 2)),
            Pack(A(2, 0), A(2, 1), A(2, 2), A(2, 2))};
  }
};

/// The least depth along the normal of a face of either, m; < 0: apart.
inline Real depth_of_faces(const BoxOnBox& w) noexcept {
  const Column h_A(w.h_a), h_B(w.h_b);
  const Pack of_b = h_B.p + w.E[0] * w.h_a[0] + w.E[1] * w.h_a[1] + w.E[2] * w.h_a[2] - abs(w.p_B);
  const Block E_T{{Column(w.E[0]), Column(w.E[1]), Column(w.E[2])}};
  const Pack of_a = h_A.p + times_transposed(E_T, h_B).p - abs(w.p_A);
  const Pack least = min(of_a, of_b);
  return std::min(std::min(least[0], least[1]), least[2]);
}

/// Of axes 0, 1, 2, 0, ...
constexpr int after(int axis) noexcept { return axis == 2 ? 0 : axis + 1; }

/// The edges of a box along one of its axes, `along`, on the side to which n leads more; two of the four.
struct EdgesToSide {
  int along, axis, other;  // n leads less out along `axis`
  Real at_other;           // where both are
  Real less;               // by how much the one on the positive side of `axis` is deeper than the other

  EdgesToSide(int i, const Vec3& n, const Vec3& h) noexcept : along(i) {
    const int k = after(i), l = after(k);
    axis = h[k] * std::abs(n[k]) < h[l] * std::abs(n[l]) ? k : l;
    other = k + l - axis;
    at_other = n[other] < 0 ? -h[other] : h[other];
    less = 2 * h[axis] * n[axis];
  }
  /// Which of the four: two bits, its sides.
  std::uint32_t number(bool positive) const noexcept {
    const bool outer = at_other > 0, first = axis == after(along);
    return ((first ? positive : outer) ? 1u : 0u) | ((first ? outer : positive) ? 2u : 0u);
  }
};

/// f(edges, depth, point of a in its frame) for the edges along axis i of box a and j of box b that cross, no nearer than
/// -reach. n_A, n_B: from b to a; d: depth along it, of the edges that are deepest. Lane 0 to 3: of a and b the edge on
/// the negative side, of a the positive, of b, of both.
template <class F>
void each_crossing_along(const BoxOnBox& w, int i, int j, const Vec3& n_A, const Vec3& n_B, Real d,
                         Real reach, F f) noexcept {
  const EdgesToSide a(i, -n_A, w.h_a), b(j, n_B, w.h_b);
  const Real h_a = w.h_a[a.axis], h_b = w.h_b[b.axis];
  const Pack a_at(-h_a, h_a, -h_a, h_a), b_at(-h_b, -h_b, h_b, h_b);
  const Real a_less = std::max(a.less, Real(0)), a_more = std::max(-a.less, Real(0));
  const Real b_less = std::max(b.less, Real(0)), b_more = std::max(-b.less, Real(0));
  const Pack depth = d - Pack(a_less, a_more, a_less, a_more) - Pack(b_less, b_less, b_more, b_more);
  // from the middle of the one edge to that of the other: along both
  const auto R = [&](int row, int column) noexcept { return lane(w.R, row, column); };
  const Pack on_a = b_at * R(i, b.axis) + (lane(w.p_A, i) + b.at_other * R(i, b.other));
  const Pack on_b = lane(w.p_B, j) - a.at_other * R(a.other, j) - a_at * R(a.axis, j);
  const Real cosine = R(i, j), sine_sq = 1 - cosine * cosine, end = sine_sq * (1 - edge_end);
  const Pack t_a = on_a - on_b * cosine, t_b = on_a * cosine - on_b;
  std::uint32_t cross =
      bits((Pack(-reach) < depth) & (abs(t_a) < end * w.h_a[i]) & (abs(t_b) < end * w.h_b[j]));
  for (; cross != 0; cross &= cross - 1) {
    const auto at = static_cast<std::size_t>(std::countr_zero(cross));
    Vec3 p;
    p[i] = t_a[at] / sine_sq;
    p[a.axis] = a_at[at];
    p[a.other] = a.at_other;
    f(b.number((at & 2) != 0) << 2 | a.number((at & 1) != 0), depth[at], p);
  }
}

/// Depths along the normals (32) of axis i of box a and those of b, in lanes.
struct EdgeDepths {
  Pack sine, between, d;  // between: a and b, times the sine
};
inline EdgeDepths edge_depths(const BoxOnBox& w, int i) noexcept {
  const int k = after(i), l = after(k);
  // a_i x b_j = -R_lj a_k + R_kj a_l
  const Pack &R_k = row_of(w.R, k), &R_l = row_of(w.R, l), &E_i = row_of(w.E, i);
  const Pack h_B1(w.h_b[1], w.h_b[2], w.h_b[0], w.h_b[0]), h_B2(w.h_b[2], w.h_b[0], w.h_b[1], w.h_b[1]);
  EdgeDepths along;
  along.sine = max(sqrt(R_k * R_k + R_l * R_l), Pack(min_edge_sine));
  along.between = R_k * lane(w.p_A, l) - R_l * lane(w.p_A, k);
  along.d = (row_of(w.E, l) * w.h_a[k] + row_of(w.E, k) * w.h_a[l] + shuffled<1, 2, 0, 0>(E_i, E_i) * h_B2 +
             shuffled<2, 0, 1, 1>(E_i, E_i) * h_B1 - abs(along.between)) /
            along.sine;
  return along;
}

/// f(crossing) for the edges of box a that touch edges of box b, or are near to.
template <class F>
void each_crossing(const ShapeParams& a, const Mat3& R_WA, const ShapeParams& b, const Mat3& R_WB,
                   F f) noexcept {
  const BoxOnBox w(a, R_WA, b, R_WB);
  const Real reach = edge_reach * std::min(w.h_a.minCoeff(), w.h_b.minCoeff());
  const Real faces = depth_of_faces(w);
  if (faces <= -reach) return;
  const Real most = (1 + deeper_than_faces) * std::max(faces, Real(0)) + deeper_than_reach * reach;
  for (int i = 0; i < 3; ++i) {
    const EdgeDepths along = edge_depths(w, i);
    std::uint32_t near =
        bits((Pack(min_edge_sine) < along.sine) & (Pack(-reach) < along.d) & (along.d <= Pack(most))) & 7;
    for (; near != 0; near &= near - 1) {
      const int j = std::countr_zero(near), k = after(i), l = after(k);
      const Real s = (lane(along.between, j) < 0 ? 1 : -1) / lane(along.sine, j);
      const Real n_k = -s * lane(w.R, l, j), n_l = s * lane(w.R, k, j);
      Vec3 n_A;
      n_A[i] = 0;
      n_A[k] = n_k;
      n_A[l] = n_l;
      const Column n_B(row_of(w.R, k) * n_k + row_of(w.R, l) * n_l);
      each_crossing_along(w, i, j, n_A, n_B.vec(), lane(along.d, j), reach,
                          [&](std::uint32_t edges, Real depth, const Vec3& p_A) noexcept {
                            f(EdgeCrossing{
                                .edges = static_cast<std::uint32_t>(i << 6 | j << 4) | edges,
                                .d = depth,
                                .p_W = a.X_WS.p + R_WA * p_A,
                                .n_W = R_WA * n_A,
                            });
                          });
    }
  }
}

}  // namespace godobject
