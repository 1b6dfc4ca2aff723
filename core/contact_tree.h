// Bodies that touch, as a tree: of all contacts between bodies those that make a tree and are stiffest. A system with
// these alone is solved by elimination, exactly and in time linear in the number of bodies, however stiff they are.
//
// Each pair of bodies has an impedance A_g for its relative twist, taken where the child's centre of mass is. With
// A_c of the child and all that hangs on it, X the shift from the parent,
//
//   (27)  V_c = S^-1 b_c + Y X V_p,  S = A_c + A_g,  Y = S^-1 A_g
//         A_p += X^T A_g (1 - Y) X,  b_p += X^T Y^T b_c
#pragma once

#include <algorithm>
#include <array>
#include <utility>

#include "core/contact_pack.h"

namespace godobject {

inline AnchorTwist operator*(const TwistBlock& A, const AnchorTwist& V) noexcept {
  return {.w = A.ww * V.w + A.wv * V.v, .v = times_transposed(A.wv, V.w) + A.vv * V.v};
}
inline TwistBlock operator*(const TwistBlock& A, Real s) noexcept {
  return {.ww = A.ww * s, .wv = A.wv * s, .vv = A.vv * s};
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
inline void hang(const TwistBlock& A, const Column& d, TwistBlock& parent) noexcept {
  // X = (1, 0; -[d]x, 1)
  const Block vw = transposed(A.wv) - cross(A.vv, d);
  parent.ww += A.ww - cross(A.wv, d) + cross(d, vw);
  parent.wv += A.wv + cross(d, A.vv);
  parent.vv += A.vv;
}

/// Bodies that touch, and what their contacts are together: an impedance and an impulse at rest for the twist of the
/// child against the parent, where the child's centre of mass is.
struct TouchingPair {
  std::uint32_t child = 0, parent = 0;
  std::uint32_t first_pack = 0, end_pack = 0;
  bool in_tree = false;
  Real stiffness = 0;    // of the contacts where the bodies are predicted to be
  bool touches = false;  // some contact bears a force
  Column d;              // from the parent's centre of mass to the child's
  TwistBlock A;
  Real tamed = 1;  // part of A that the tree takes
  AnchorTwist F;   // impulse of its contacts at rest
};

/// A body among those that touch. Worthless between steps.
struct TouchingBody {
  std::uint32_t pair = 0, parent = 0;          // in the tree; parent == itself: a root
  std::uint32_t first_pack = 0, end_pack = 0;  // contacts with the world
  TwistBlock on_world;                         // of its contacts with the world
  TwistBlock A;                                // of these and its stage
  AnchorTwist F;                               // impulse of these at rest
  TwistBlock hung;                             // the same for the tree, tamed; then with all that hangs on it
  TwistBlock S_inverse;                        // (27)
  Block Y_ww, Y_wv, Y_vw, Y_vv;
  bool hangs = false;  // on its parent, by a pair that bears a force
};

inline constexpr std::uint32_t no_edge = ~std::uint32_t(0);

/// The bodies between which this one's tree has been joined so far.
template <std::size_t N>
std::uint32_t component_of(std::array<std::uint32_t, N>& component, std::uint32_t i) noexcept {
  while (component[i] != i) i = component[i] = component[component[i]];
  return i;
}

/// Bodies that are near each other, and to none but these: a system of its own. Ranges of ContactTree's order.
struct Island {
  std::uint32_t first_body = 0, end_body = 0, first_pair = 0, end_pair = 0;
};

/// For every island a tree of its stiffest pairs.
template <std::size_t N, std::size_t max_pairs>
struct ContactTree {
  std::array<TouchingBody, N> bodies;
  std::array<TouchingPair, max_pairs> pairs;
  std::size_t num_pairs = 0;
  std::array<std::uint32_t, N> order;               // of the bodies that touch anything, parents first
  std::array<std::uint32_t, max_pairs> pair_order;  // island by island
  std::array<Island, N> islands;
  std::size_t num_islands = 0;
  std::array<std::uint32_t, max_pairs> by_stiffness;
  std::array<std::uint32_t, N> component, first_edge, island_of;  // the last by root of the component
  std::array<std::uint32_t, 2 * N> edges, next_edge;              // of the tree, by body

  /// f(body's number, body), f(pair) of all of an island.
  template <class F>
  void each_body(const Island& island, F f) noexcept {
    for (std::uint32_t k = island.first_body; k < island.end_body; ++k) f(order[k], bodies[order[k]]);
  }
  template <class F>
  void each_body(const Island& island, F f) const noexcept {
    for (std::uint32_t k = island.first_body; k < island.end_body; ++k) f(order[k], bodies[order[k]]);
  }
  template <class F>
  void each_pair(const Island& island, F f) noexcept {
    for (std::uint32_t k = island.first_pair; k < island.end_pair; ++k) f(pairs[pair_order[k]]);
  }
  template <class F>
  void each_pair(const Island& island, F f) const noexcept {
    for (std::uint32_t k = island.first_pair; k < island.end_pair; ++k) f(pairs[pair_order[k]]);
  }
  std::uint32_t island_of_pair(std::size_t k) noexcept {
    return island_of[component_of(component, pairs[k].child)];
  }
};

/// Joins the bodies by a tree of pairs, stiffest first. touches[i]: body i touches anything.
template <std::size_t N, std::size_t max_pairs>
void join_bodies(std::size_t num_bodies, ContactTree<N, max_pairs>& w) noexcept {
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    w.component[i] = i;
    w.first_edge[i] = no_edge;
  }
  for (std::uint32_t k = 0; k < w.num_pairs; ++k) {
    w.pairs[k].in_tree = false;
    w.by_stiffness[k] = k;
  }
  std::sort(w.by_stiffness.begin(), w.by_stiffness.begin() + w.num_pairs,
            [&](std::uint32_t k, std::uint32_t l) noexcept {
              return w.pairs[k].stiffness != w.pairs[l].stiffness
                         ? w.pairs[k].stiffness > w.pairs[l].stiffness
                         : k < l;
            });
  std::uint32_t num_edges = 0;
  for (std::size_t k = 0; k < w.num_pairs; ++k) {
    const TouchingPair& pair = w.pairs[w.by_stiffness[k]];
    const std::uint32_t a = component_of(w.component, pair.child), b = component_of(w.component, pair.parent);
    if (a == b) continue;
    w.component[a] = b;
    for (const std::uint32_t i : {pair.child, pair.parent}) {
      w.edges[num_edges] = w.by_stiffness[k];
      w.next_edge[num_edges] = w.first_edge[i];
      w.first_edge[i] = num_edges++;
    }
  }
}

/// The bodies of the tree with this root, parents first, from `next` on. Returns their end.
template <std::size_t N, std::size_t max_pairs>
std::uint32_t order_bodies(std::uint32_t root, std::uint32_t next, ContactTree<N, max_pairs>& w) noexcept {
  std::uint32_t end = next;
  w.bodies[root].parent = root;
  w.order[end++] = root;
  for (; next < end; ++next) {
    const std::uint32_t i = w.order[next];
    for (std::uint32_t e = w.first_edge[i]; e != no_edge; e = w.next_edge[e]) {
      TouchingPair& pair = w.pairs[w.edges[e]];
      const std::uint32_t j = pair.child == i ? pair.parent : pair.child;
      if (j == w.bodies[i].parent) continue;
      pair.child = j;
      pair.parent = i;
      pair.in_tree = true;
      w.bodies[j].pair = w.edges[e];
      w.bodies[j].parent = i;
      w.order[end++] = j;
    }
  }
  return end;
}

/// The islands, each with its tree and its pairs. touches[i]: body i touches anything.
template <std::size_t N, std::size_t max_pairs>
void make_islands(const std::array<bool, N>& touches, std::size_t num_bodies,
                  ContactTree<N, max_pairs>& w) noexcept {
  join_bodies(num_bodies, w);
  w.num_islands = 0;
  std::uint32_t end = 0;
  for (std::uint32_t root = 0; root < num_bodies; ++root) {
    if (!touches[root] || component_of(w.component, root) != root) continue;
    Island& island = w.islands[w.num_islands];
    island = {.first_body = end, .end_body = order_bodies(root, end, w)};
    end = island.end_body;
    w.island_of[root] = static_cast<std::uint32_t>(w.num_islands++);
  }
  for (std::size_t k = 0; k < w.num_pairs; ++k) ++w.islands[w.island_of_pair(k)].end_pair;
  std::uint32_t first = 0;
  for (std::size_t n = 0; n < w.num_islands; ++n) {
    Island& island = w.islands[n];
    island.first_pair = first;
    first += std::exchange(island.end_pair, first);
  }
  for (std::uint32_t k = 0; k < w.num_pairs; ++k) w.pair_order[w.islands[w.island_of_pair(k)].end_pair++] = k;
}

/// Beside an impedance this much larger than its mass, elimination forgets a body: the tree takes less of it, which
/// costs iterations and no accuracy.
inline constexpr Real max_contrast = 1e4;
inline Real tamed(const TwistBlock& A, Real mass) noexcept {
  const Real trace = A.vv.col[0].x() + A.vv.col[1].y() + A.vv.col[2].z();
  return std::min(Real(1), max_contrast * mass / std::max(trace, std::numeric_limits<Real>::min()));
}

/// (27) from the leaves up. hung: A of the bodies, tamed.
template <std::size_t N, std::size_t max_pairs>
void eliminate(const Island& island, ContactTree<N, max_pairs>& w) noexcept {
  for (std::uint32_t k = island.end_body; k-- > island.first_body;) {
    const std::uint32_t i = w.order[k];
    TouchingBody& c = w.bodies[i];
    c.hangs = c.parent != i && w.pairs[c.pair].touches;
    if (!c.hangs) {
      c.S_inverse = inverse(c.hung);
      continue;
    }
    const TouchingPair& pair = w.pairs[c.pair];
    const TwistBlock A = pair.A * pair.tamed;
    c.S_inverse = inverse({.ww = c.hung.ww + A.ww, .wv = c.hung.wv + A.wv, .vv = c.hung.vv + A.vv});
    const TwistBlock& S = c.S_inverse;
    const Block A_vw = transposed(A.wv), S_vw = transposed(S.wv);
    c.Y_ww = S.ww * A.ww + S.wv * A_vw;
    c.Y_wv = S.ww * A.wv + S.wv * A.vv;
    c.Y_vw = S_vw * A.ww + S.vv * A_vw;
    c.Y_vv = S_vw * A.wv + S.vv * A.vv;
    // A (1 - Y) as A_c S^-1 A: nothing cancels where A is much stiffer than the child is heavy
    TwistBlock rest;
    const TwistBlock& H = c.hung;
    rest.ww = H.ww * c.Y_ww + H.wv * c.Y_vw;
    rest.wv = H.ww * c.Y_wv + H.wv * c.Y_vv;
    rest.vv = transposed(H.wv) * c.Y_wv + H.vv * c.Y_vv;
    hang(rest, pair.d, w.bodies[c.parent].hung);
  }
}

/// V = A^-1 b of the tree. b is used up.
template <std::size_t N, std::size_t max_pairs>
void solve(const Island& island, const ContactTree<N, max_pairs>& w, std::array<AnchorTwist, N>& b,
           std::array<AnchorTwist, N>& V) noexcept {
  for (std::uint32_t k = island.end_body; k-- > island.first_body;) {
    const std::uint32_t i = w.order[k];
    const TouchingBody& c = w.bodies[i];
    if (!c.hangs) continue;
    const AnchorTwist& b_c = b[i];
    const AnchorTwist F = {.w = times_transposed(c.Y_ww, b_c.w) + times_transposed(c.Y_vw, b_c.v),
                           .v = times_transposed(c.Y_wv, b_c.w) + times_transposed(c.Y_vv, b_c.v)};
    b[c.parent] = b[c.parent] + moved_wrench(F, w.pairs[c.pair].d);
  }
  for (std::uint32_t k = island.first_body; k < island.end_body; ++k) {
    const std::uint32_t i = w.order[k];
    const TouchingBody& c = w.bodies[i];
    V[i] = c.S_inverse * b[i];
    if (!c.hangs) continue;
    const AnchorTwist V_P = shifted(V[c.parent], w.pairs[c.pair].d);
    V[i] = V[i] + AnchorTwist{.w = c.Y_ww * V_P.w + c.Y_wv * V_P.v, .v = c.Y_vw * V_P.w + c.Y_vv * V_P.v};
  }
}

/// A V of all pairs, in the tree or not.
template <std::size_t N, std::size_t max_pairs>
void multiply(const Island& island, const ContactTree<N, max_pairs>& w, const std::array<AnchorTwist, N>& V,
              std::array<AnchorTwist, N>& AV) noexcept {
  w.each_body(island, [&](std::uint32_t i, const TouchingBody& body) noexcept { AV[i] = body.A * V[i]; });
  w.each_pair(island, [&](const TouchingPair& pair) noexcept {
    if (!pair.touches) return;
    const AnchorTwist F = pair.A * (V[pair.child] - shifted(V[pair.parent], pair.d));
    AV[pair.child] = AV[pair.child] + F;
    AV[pair.parent] = AV[pair.parent] - moved_wrench(F, pair.d);
  });
}

}  // namespace godobject
