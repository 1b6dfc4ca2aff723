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

/// Box b as box a sees it.
struct BoxOnBox {
  Vec3 h_a, h_b;  // half extents
  Vec3 p_AB;
  Mat3 R_AB;
  std::array<Pack, 3> R, E;  // rows of R_AB, and their absolute values; lane j: axis j of b
  Pack h_B;

  BoxOnBox(const ShapeParams& a, const Mat3& R_WA, const ShapeParams& b, const Mat3& R_WB) noexcept
      : h_a(a.half_extents),
        h_b(b.half_extents),
        p_AB(R_WA.transpose() * (b.X_WS.p - a.X_WS.p)),
        R_AB(R_WA.transpose() * R_WB),
        h_B(h_b[0], h_b[1], h_b[2], h_b[2]) {
    for (int k = 0; k < 3; ++k) {
      R[static_cast<std::size_t>(k)] = Pack(R_AB(k, 0), R_AB(k, 1), R_AB(k, 2), R_AB(k, 2));
      E[static_cast<std::size_t>(k)] = abs(R[static_cast<std::size_t>(k)]);
    }
  }
};

/// The least depth along the normal of a face of either, m; < 0: apart.
inline Real depth_of_faces(const BoxOnBox& w) noexcept {
  const Pack of_b = w.h_B + w.E[0] * w.h_a[0] + w.E[1] * w.h_a[1] + w.E[2] * w.h_a[2] -
                    abs(w.R[0] * w.p_AB[0] + w.R[1] * w.p_AB[1] + w.R[2] * w.p_AB[2]);
  const Vec3 of_a = w.h_a + w.R_AB.cwiseAbs() * w.h_b - w.p_AB.cwiseAbs();
  return std::min(std::min(std::min(of_b[0], of_b[1]), of_b[2]), of_a.minCoeff());
}

/// The edges of a box along one of its axes, `along`, on the side to which n leads more; two of the four.
struct EdgesToSide {
  int along, axis, other;  // n leads less out along `axis`
  Real at_other;           // where both are
  Real less;               // by how much the one on the positive side of `axis` is deeper than the other

  EdgesToSide(int i, const Vec3& n, const Vec3& h) noexcept : along(i) {
    const int k = (i + 1) % 3, l = (i + 2) % 3;
    axis = h[k] * std::abs(n[k]) < h[l] * std::abs(n[l]) ? k : l;
    other = k + l - axis;
    at_other = n[other] < 0 ? -h[other] : h[other];
    less = 2 * h[axis] * n[axis];
  }
  /// Which of the four: two bits, its sides.
  std::uint32_t number(bool positive) const noexcept {
    const bool outer = at_other > 0, first = axis == (along + 1) % 3;
    return ((first ? positive : outer) ? 1u : 0u) | ((first ? outer : positive) ? 2u : 0u);
  }
};

/// f(edges, depth, point of a in its frame) for the edges along axis i of box a and j of box b that cross, no nearer than
/// -reach. n_A: from b to a; d: depth along it, of the edges that are deepest. Lane 0 to 3: of a and b the edge on the
/// negative side, of a the positive, of b, of both.
template <class F>
void each_crossing_along(const BoxOnBox& w, int i, int j, const Vec3& n_A, Real d, Real reach, F f) noexcept {
  const Vec3 b_j = w.R_AB.col(j);
  const EdgesToSide a(i, -n_A, w.h_a), b(j, w.R_AB.transpose() * n_A, w.h_b);
  const Pack a_at(-w.h_a[a.axis], w.h_a[a.axis], -w.h_a[a.axis], w.h_a[a.axis]);
  const Pack b_at(-w.h_b[b.axis], -w.h_b[b.axis], w.h_b[b.axis], w.h_b[b.axis]);
  const Real a_less = std::max(a.less, Real(0)), a_more = std::max(-a.less, Real(0));
  const Real b_less = std::max(b.less, Real(0)), b_more = std::max(-b.less, Real(0));
  const Pack depth = d - Pack(a_less, a_more, a_less, a_more) - Pack(b_less, b_less, b_more, b_more);
  // from the middle of the one edge to that of the other: along both
  const Pack on_a = b_at * w.R_AB(i, b.axis) + (w.p_AB[i] + b.at_other * w.R_AB(i, b.other));
  const Pack on_b = w.p_AB.dot(b_j) - a.at_other * b_j[a.other] - a_at * b_j[a.axis];
  const Real cosine = b_j[i], sine_sq = 1 - cosine * cosine, end = sine_sq * (1 - edge_end);
  const Pack t_a = on_a - on_b * cosine, t_b = on_a * cosine - on_b;
  std::uint32_t cross =
      bits((Pack(-reach) < depth) & (abs(t_a) < end * w.h_a[i]) & (abs(t_b) < end * w.h_b[j]));
  for (; cross != 0; cross &= cross - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(cross));
    Vec3 p;
    p[i] = t_a[lane] / sine_sq;
    p[a.axis] = a_at[lane];
    p[a.other] = a.at_other;
    f(b.number((lane & 2) != 0) << 2 | a.number((lane & 1) != 0), depth[lane], p);
  }
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
  const Pack h_B1(w.h_b[1], w.h_b[2], w.h_b[0], w.h_b[0]), h_B2(w.h_b[2], w.h_b[0], w.h_b[1], w.h_b[1]);
  for (int i = 0; i < 3; ++i) {
    const int k = (i + 1) % 3, l = (i + 2) % 3;
    const auto row = [](int c) noexcept { return static_cast<std::size_t>(c); };
    // a_i x b_j = -R_lj a_k + R_kj a_l
    const Pack &R_k = w.R[row(k)], &R_l = w.R[row(l)], &E_i = w.E[row(i)];
    const Pack sine = max(sqrt(R_k * R_k + R_l * R_l), Pack(min_edge_sine));
    const Pack along = R_k * w.p_AB[l] - R_l * w.p_AB[k];
    const Pack d = (w.E[row(l)] * w.h_a[k] + w.E[row(k)] * w.h_a[l] + shuffled<1, 2, 0, 0>(E_i, E_i) * h_B2 +
                    shuffled<2, 0, 1, 1>(E_i, E_i) * h_B1 - abs(along)) /
                   sine;
    std::uint32_t near = bits((Pack(min_edge_sine) < sine) & (Pack(-reach) < d) & (d <= Pack(most))) & 7;
    for (; near != 0; near &= near - 1) {
      const int j = std::countr_zero(near);
      Vec3 n_A = Vec3::Unit(i).cross(w.R_AB.col(j)).normalized();
      const Real between = n_A.dot(w.p_AB);
      if (!(between < 0)) n_A = -n_A;
      const Real deepest =
          w.h_a.dot(n_A.cwiseAbs()) + w.h_b.dot((w.R_AB.transpose() * n_A).cwiseAbs()) - std::abs(between);
      each_crossing_along(w, i, j, n_A, deepest, reach,
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
