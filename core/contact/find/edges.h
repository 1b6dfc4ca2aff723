// Contacts of crossing edges of boxes, which spheres at the corners do not detect.
//
// Two boxes without a corner inside the other touch where an edge of one crosses an edge of the other. With
// a_i along the first and b_j along the second,
//
//   (32)  n = a_i x b_j / |a_i x b_j|
//
// These are nine of the axes that may separate two boxes; the normals of their faces are the other six. Edges
// cross if their nearest points are between their ends. They touch if their depth along n is at most that of
// the faces; otherwise the boxes separate through a face. Bound for a pair of boxes: nine axes, four pairs of
// edges along each.
#pragma once

#include <bit>

#include "core/contact/find/world_geometry.h"
#include "core/math/componentwise.h"
#include "core/tuning.h"

namespace godobject {

/// Crossing edges of two boxes, in the world.
struct EdgeCrossing {
  std::uint32_t edges = 0;  // numbers of the edges of a and of b
  Real d = 0;               // depth, m
  Vec3 p_W, n_W;            // contact point on the edge of a; normal, away from b
};

/// Returns the lanes rotated by one: lane j has the value of axis (j + 1) mod 3.
inline Pack next(const Pack& a) noexcept { return shuffled<1, 2, 0, 0>(a, a); }
/// Returns lane j of a pack, or element j of a row.
inline Real component(const Pack& a, int j) noexcept { return a[static_cast<std::size_t>(j)]; }
inline const Pack& row_of(const std::array<Pack, 3>& rows, int row) noexcept {
  return rows[static_cast<std::size_t>(row)];
}

/// Box b in the frame of box a. Lane j: axis j of b; the fourth is undefined.
struct BoxOnBox {
  Vec3 h_a;                  // half extents of a
  Pack h_B;                  // half extents of b
  Pack p_A, p_B;             // vector from a to b, in the frames of a and of b
  std::array<Pack, 3> R, E;  // rows of R_AB, and their absolute values

  BoxOnBox(const PlacedShape& a, const PlacedShape& b) noexcept
      : h_a(a.half_extents()), h_B(Column(b.half_extents()).p) {
    const std::array<Pack, 3> a_W = rows(a.R_WS()), b_W = rows(b.R_WS());
    const Vec3 p_W = b.p_W() - a.p_W();
    p_A = a_W[0] * p_W[0] + a_W[1] * p_W[1] + a_W[2] * p_W[2];
    p_B = b_W[0] * p_W[0] + b_W[1] * p_W[1] + b_W[2] * p_W[2];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto axis = a.R_WS().col(static_cast<int>(k));
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

/// Normal of the face of either box along which the depth is least, in the frame of a. Depth < 0: the boxes
/// are apart.
struct LeastFace {
  Real depth = 0;
  Vec3 n_A;
};
inline LeastFace least_face(const BoxOnBox& w) noexcept {
  const Column h_A(w.h_a), h_B(w.h_B);
  const Pack of_b = w.h_B + w.E[0] * w.h_a[0] + w.E[1] * w.h_a[1] + w.E[2] * w.h_a[2] - abs(w.p_B);
  const Block E_T{{Column(w.E[0]), Column(w.E[1]), Column(w.E[2])}};
  const Pack of_a = h_A.p + times_transposed(E_T, h_B).p - abs(w.p_A);
  const Pack least = min(of_a, of_b);
  const int k = least[0] < least[1] ? (least[0] < least[2] ? 0 : 2) : (least[1] < least[2] ? 1 : 2);
  const bool is_on_a = component(of_a, k) < component(of_b, k);
  return {.depth = component(least, k),
          .n_A = is_on_a ? Vec3(Vec3::Unit(k))
                         : Vec3(component(w.R[0], k), component(w.R[1], k), component(w.R[2], k))};
}

/// Edges of a box parallel to one of its axes that n points to: two of the four. They differ in one of the
/// box's other two axes, 1 or 2, and share the coordinate along the other. Lane j: edges that cross axis j of
/// b.
struct EdgesToSide {
  PackMask first;            // true if the edges differ in axis 1; otherwise in axis 2
  Pack h;                    // half extent along the axis in which the edges differ
  Pack coordinate_on_other;  // coordinate of both edges along the other axis
  Pack less;                 // depth of the edge on the positive side minus that of the other

  EdgesToSide(const Pack& n_1, const Pack& h_1, const Pack& n_2, const Pack& h_2) noexcept {
    const Pack out_1 = h_1 * n_1, out_2 = h_2 * n_2;
    first = abs(out_1) < abs(out_2);
    h = select(first, h_1, h_2);
    coordinate_on_other = select(first, select(n_2 < 0, -h_2, h_2), select(n_1 < 0, -h_1, h_1));
    less = 2 * select(first, out_1, out_2);
  }
  /// Returns by how much the edge on the given side is less deep than the deeper of the two.
  Pack lost(bool positive) const noexcept { return max(positive ? -less : less, Pack(0)); }
  /// Returns the number of the edge, 0 to 3: two bits, its sides.
  std::uint32_t number(std::size_t j, bool positive) const noexcept {
    const bool outer = coordinate_on_other[j] > 0, is_first = (bits(first) >> j & 1) != 0;
    return ((is_first ? positive : outer) ? 1u : 0u) | ((is_first ? outer : positive) ? 2u : 0u);
  }
};

/// Cross products (32): a_i x b_j = -R_lj a_k + R_kj a_l for all j. k, l: the next axes of a.
struct EdgeAxes {
  int i, k, l;
  const Pack &R_i, &R_k, &R_l;
  Pack sine;     // length of n before normalisation
  Pack between;  // distance of the centres of a and b along n, times the sine
  Pack d;        // depth of the boxes along n

  EdgeAxes(const BoxOnBox& w, int axis) noexcept
      : i(axis),
        k(i == 2 ? 0 : i + 1),
        l(3 - i - k),
        R_i(row_of(w.R, i)),
        R_k(row_of(w.R, k)),
        R_l(row_of(w.R, l)),
        sine(max(sqrt(R_k * R_k + R_l * R_l), Pack(min_edge_sine))),
        between(R_k * component(w.p_A, l) - R_l * component(w.p_A, k)) {
    const Pack h_B1 = next(w.h_B), h_B2 = next(h_B1);
    const Pack& E_i = row_of(w.E, i);
    d = (row_of(w.E, l) * w.h_a[k] + row_of(w.E, k) * w.h_a[l] + next(E_i) * h_B2 + next(next(E_i)) * h_B1 -
         abs(between)) /
        sine;
  }
  /// Returns a word whose bit j is set if the edges are not parallel.
  std::uint32_t cross() const noexcept { return bits(Pack(min_edge_sine) < sine) & 7; }
};

/// True if the boxes are deeper than `depth` along all axes that may separate them.
inline bool deeper_along_edges(const BoxOnBox& w, Real depth) noexcept {
  for (int i = 0; i < 3; ++i)
    if (const EdgeAxes n(w, i); (n.cross() & bits(n.d <= Pack(depth))) != 0) return false;
  return true;
}

/// Calls f(crossing) for the edges along an axis of box a that cross edges of box b, deeper than -reach. Only
/// along normals (32) with a depth between -reach and `most`, or parallel to the face's.
template <class F>
void each_crossing_along(const BoxOnBox& w, int axis, Real reach, Real most, const Vec3& face_A,
                         F f) noexcept {
  const EdgeAxes n(w, axis);
  const auto& [i, k, l, R_i, R_k, R_l, sine, between, d] = n;
  // cosine between n and the normal of the face, times the sine
  const Pack along_face = abs(R_k * face_A[l] - R_l * face_A[k]);
  const std::uint32_t near =
      n.cross() & bits(Pack(-reach) < d) & (bits(d <= Pack(most)) | bits(same_normal * sine < along_face));
  if (near == 0) return;

  const Pack s = select(between < 0, Pack(1), Pack(-1)) / sine;
  const Pack n_k = -s * R_l, n_l = s * R_k;  // from b to a
  const Pack n_B1 = next(R_k) * n_k + next(R_l) * n_l, n_B2 = next(next(R_k)) * n_k + next(next(R_l)) * n_l;
  const EdgesToSide a(-n_k, w.h_a[k], -n_l, w.h_a[l]), b(n_B1, next(w.h_B), n_B2, next(next(w.h_B)));
  const Pack a_b = select(a.first, R_k, R_l), a_b_other = select(a.first, R_l, R_k);
  const Pack b_a = select(b.first, next(R_i), next(next(R_i))),
             b_a_other = select(b.first, next(next(R_i)), next(R_i));
  // nearest points of two edges, as distances from the middles of the edges, times the squared sine
  const Pack sine_sq = 1 - R_i * R_i, end = sine_sq * (1 - edge_end);
  const Pack on_a = component(w.p_A, i) + b.coordinate_on_other * b_a_other,
             on_b = w.p_B - a.coordinate_on_other * a_b_other;
  // for the edge on the negative and on the positive side, first of a, then of b
  const std::array<Pack, 2> to_a{on_b + a.h * a_b, on_b - a.h * a_b}, lost_a{a.lost(false), a.lost(true)};
  const std::array<Pack, 2> to_b{on_a - b.h * b_a, on_a + b.h * b_a}, lost_b{b.lost(false), b.lost(true)};
  const Pack end_a = end * w.h_a[i], end_b = end * w.h_B;
  std::array<Pack, 4> t_a, depth;
  std::array<std::uint32_t, 4> cross;
  for (std::size_t c = 0; c < 4; ++c) {
    const Pack &from_a = to_a[c & 1], &from_b = to_b[c >> 1];
    t_a[c] = from_b - from_a * R_i;
    const Pack t_b = from_b * R_i - from_a;
    depth[c] = d - lost_a[c & 1] - lost_b[c >> 1];
    cross[c] = bits((Pack(-reach) < depth[c]) & (abs(t_a[c]) < end_a) & (abs(t_b) < end_b)) & near;
  }
  for (std::uint32_t left = cross[0] | cross[1] | cross[2] | cross[3]; left != 0; left &= left - 1) {
    const auto j = static_cast<std::size_t>(std::countr_zero(left));
    const bool a_first = (bits(a.first) >> j & 1) != 0;
    Vec3 n_A, p_A;
    n_A[i] = 0;
    n_A[k] = n_k[j];
    n_A[l] = n_l[j];
    for (std::size_t c = 0; c < 4; ++c) {
      if ((cross[c] >> j & 1) == 0) continue;
      const bool above_a = (c & 1) != 0, above_b = (c & 2) != 0;
      p_A[i] = t_a[c][j] / sine_sq[j];
      p_A[a_first ? k : l] = above_a ? a.h[j] : -a.h[j];
      p_A[a_first ? l : k] = a.coordinate_on_other[j];
      f(static_cast<std::uint32_t>(i) << 6 | static_cast<std::uint32_t>(j) << 4 | b.number(j, above_b) << 2 |
            a.number(j, above_a),
        depth[c][j], p_A, n_A);
    }
  }
}

/// Overlap of two boxes; in_touch: no deeper than the reach of their edges.
enum class BoxesAre { in_touch, deep, sunk };

inline Real reach_of_edges(const PlacedShape& a, const PlacedShape& b) noexcept {
  return edge_reach * std::min(min_component(a.half_extents()), min_component(b.half_extents()));
}

/// Calls f(crossing) for the edges of box a that touch or are near edges of box b. Calls it for none if the
/// boxes are sunk and may_be_sunk is true.
template <class F>
BoxesAre each_crossing(const PlacedShape& a, const PlacedShape& b, bool may_be_sunk, F f) noexcept {
  const BoxOnBox w(a, b);
  const Real reach = reach_of_edges(a, b), too_deep = sunk_depth / edge_reach * reach;
  const LeastFace face = least_face(w);
  if (face.depth <= -reach) return BoxesAre::in_touch;
  if (may_be_sunk && face.depth > too_deep && deeper_along_edges(w, too_deep)) return BoxesAre::sunk;
  const Real most = (1 + deeper_edges) * std::max(face.depth, Real(0)) + deeper_edges * reach;
  for (int i = 0; i < 3; ++i)
    each_crossing_along(
        w, i, reach, most, face.n_A,
        [&](std::uint32_t edges, Real d, const Vec3& p_A, const Vec3& n_A) noexcept {
          f(EdgeCrossing{.edges = edges, .d = d, .p_W = a.p_W() + a.R_WS() * p_A, .n_W = a.R_WS() * n_A});
        });
  return face.depth > reach ? BoxesAre::deep : BoxesAre::in_touch;
}

}  // namespace godobject
