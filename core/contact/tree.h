// Bodies that touch, as a tree: of all contacts between bodies those that make a tree and are stiffest. A system with
// these alone is solved by elimination, exactly and in time linear in the number of bodies, however stiff they are.
//
// A joint between bodies is always an edge of the tree (30). Those of the world join bodies to one tree as well, and
// island, with a root for each.
#pragma once

#include <algorithm>
#include <array>
#include <utility>

#include "core/joint/edges.h"
#include "core/math/merge_sort.h"
#include "core/scene.h"

namespace godobject {

/// Bodies that touch, and what their contacts are together: an impedance and an impulse at rest for the twist of the
/// child against the parent, where the child's centre of mass is.
struct TouchingPair {
  std::uint32_t child = 0, parent = 0;
  std::uint32_t first_pack = 0, end_pack = 0;
  Real stiffness = 0;       // of the contacts where the bodies are predicted to be
  bool touches = false;     // some contact bears a force
  std::uint32_t block = 0;  // of a factor
  Column d;                 // from the parent's centre of mass to the child's
  TwistBlock A;
  Real stiffness_cap = 1;  // part of A that the tree takes
  AnchorTwist F;           // impulse of its contacts at rest
};

/// A body among those that touch. Scratch: undefined between steps.
struct TouchingBody {
  std::uint32_t pair = 0, parent = 0;          // in the tree: edge (pair, or joint) and body; itself: a root
  std::uint32_t first_pack = 0, end_pack = 0;  // contacts with the world
  TwistBlock on_world;                         // of its contacts with the world
  TwistBlock A;                                // of these and its stage
  AnchorTwist F;                               // impulse of these at rest
  TwistBlock subtree_A;  // the same for the tree, capped; then with all that hangs on it
  TwistBlock S_inverse;  // (27)
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

/// What pairs are sorted by.
struct PairStiffness {
  Real stiffness = 0;
  std::uint32_t pair = 0;
};

/// For every island a tree of its joints, if the bodies have any, and its stiffest pairs.
template <std::size_t N, std::size_t max_pairs, bool jointed_ = false>
struct ContactTree {
  static constexpr bool jointed = jointed_;
  std::array<TouchingBody, N> bodies;
  std::array<TouchingPair, max_pairs> pairs;
  std::size_t num_pairs = 0;
  std::array<std::uint32_t, N> order;               // of the bodies that touch anything, parents first
  std::array<std::uint32_t, max_pairs> pair_order;  // island by island
  std::array<Island, N> islands;
  std::size_t num_islands = 0;
  std::array<PairStiffness, max_pairs> by_stiffness, merged;
  std::array<std::uint32_t, N> component, first_edge, island_of;  // the last by root of the component
  std::array<std::uint32_t, 2 * N> edges, next_edge;              // of the tree, by body
  [[no_unique_address]] std::conditional_t<jointed, JointEdges<N>, Absent<11>> joints;

  /// Edges of the tree beyond the pairs: the joint of a body.
  static constexpr std::uint32_t first_joint = max_pairs;
  /// By which the body hangs in the tree; null: by a pair, or it is a free root.
  const JointEdge* joint_of(const TouchingBody& c) const noexcept {
    if constexpr (jointed) {
      if (c.pair >= first_joint && c.pair != no_edge) return &joints.edges[c.pair - first_joint];
    }
    return nullptr;
  }

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

/// Makes edge k one of the tree, of bodies i and j.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void add_edge(std::uint32_t k, std::uint32_t i, std::uint32_t j, std::uint32_t& num_edges,
              ContactTree<N, max_pairs, jointed>& w) noexcept {
  for (const std::uint32_t body : {i, j}) {
    w.edges[num_edges] = k;
    w.next_edge[num_edges] = w.first_edge[body];
    w.first_edge[body] = num_edges++;
  }
}

/// Joins the bodies by their joints.
template <std::size_t N, std::size_t max_pairs>
void join_by_joints(std::uint32_t num_bodies, std::uint32_t& num_edges,
                    ContactTree<N, max_pairs, true>& w) noexcept {
  std::uint32_t on_world = no_edge;
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    const JointEdge& joint = w.joints.edges[i];
    if (joint.on_world() && on_world == no_edge) on_world = i;
    if (joint.kind == JointKind::free || i == on_world) continue;
    const auto to = joint.on_world() ? on_world : static_cast<std::uint32_t>(joint.parent);
    w.component[component_of(w.component, i)] = component_of(w.component, to);
    if (joint.on_body()) add_edge(w.first_joint + i, i, to, num_edges, w);
  }
}

/// Joins the bodies by a tree: of joints, then of pairs, stiffest first.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void join_bodies(std::size_t num_bodies, ContactTree<N, max_pairs, jointed>& w) noexcept {
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    w.component[i] = i;
    w.first_edge[i] = no_edge;
  }
  for (std::uint32_t k = 0; k < w.num_pairs; ++k)
    w.by_stiffness[k] = {.stiffness = w.pairs[k].stiffness, .pair = k};
  merge_sort(
      w.by_stiffness.data(), w.merged.data(), w.num_pairs,
      [](const PairStiffness& a, const PairStiffness& b) noexcept { return a.stiffness > b.stiffness; });
  std::uint32_t num_edges = 0;
  if constexpr (jointed) join_by_joints(static_cast<std::uint32_t>(num_bodies), num_edges, w);
  for (std::size_t k = 0; k < w.num_pairs; ++k) {
    const std::uint32_t edge = w.by_stiffness[k].pair;
    const TouchingPair& pair = w.pairs[edge];
    const std::uint32_t a = component_of(w.component, pair.child), b = component_of(w.component, pair.parent);
    if (a == b) continue;
    w.component[a] = b;
    add_edge(edge, pair.child, pair.parent, num_edges, w);
  }
}

/// f(root): of the tree of this component; with joints to the world, the bodies that are on them.
template <std::size_t N, std::size_t max_pairs, bool jointed, class F>
void each_root(std::uint32_t component, std::uint32_t num_bodies, ContactTree<N, max_pairs, jointed>& w,
               F f) noexcept {
  if constexpr (jointed) {
    bool on_world = false;
    for (std::uint32_t i = 0; i < num_bodies; ++i) {
      if (!w.joints.edges[i].on_world() || component_of(w.component, i) != component) continue;
      w.bodies[i].pair = w.first_joint + i;
      on_world = true;
      f(i);
    }
    if (on_world) return;
    w.bodies[component].pair = no_edge;
  }
  f(component);
}

/// The body at the other end of an edge of the tree.
template <std::size_t N, std::size_t max_pairs, bool jointed>
std::uint32_t other_end(std::uint32_t edge, std::uint32_t i,
                        const ContactTree<N, max_pairs, jointed>& w) noexcept {
  if constexpr (jointed) {
    if (edge >= w.first_joint) {
      const std::uint32_t child = edge - w.first_joint;
      return child == i ? static_cast<std::uint32_t>(w.joints.edges[child].parent) : child;
    }
  }
  const TouchingPair& pair = w.pairs[edge];
  return pair.child == i ? pair.parent : pair.child;
}

/// The bodies of the tree of this component, parents first, from `next` on. Returns their end.
template <std::size_t N, std::size_t max_pairs, bool jointed>
std::uint32_t order_bodies(std::uint32_t component, std::uint32_t num_bodies, std::uint32_t next,
                           ContactTree<N, max_pairs, jointed>& w) noexcept {
  std::uint32_t end = next;
  each_root(component, num_bodies, w, [&](std::uint32_t root) noexcept {
    w.bodies[root].parent = root;
    w.order[end++] = root;
  });
  for (; next < end; ++next) {
    const std::uint32_t i = w.order[next];
    for (std::uint32_t e = w.first_edge[i]; e != no_edge; e = w.next_edge[e]) {
      const std::uint32_t j = other_end(w.edges[e], i, w);
      if (j == w.bodies[i].parent) continue;
      if (!jointed || w.edges[e] < w.first_joint) {
        TouchingPair& pair = w.pairs[w.edges[e]];
        pair.child = j;
        pair.parent = i;
      }
      w.bodies[j].pair = w.edges[e];
      w.bodies[j].parent = i;
      w.order[end++] = j;
    }
  }
  return end;
}

/// The islands, each with its tree and its pairs. touches[i]: body i touches anything.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void make_islands(const std::array<bool, N>& touches, std::size_t num_bodies,
                  ContactTree<N, max_pairs, jointed>& w) noexcept {
  join_bodies(num_bodies, w);
  w.num_islands = 0;
  std::uint32_t end = 0;
  for (std::uint32_t root = 0; root < num_bodies; ++root) {
    bool alone = !touches[root];
    if constexpr (jointed) alone = alone && !w.joints.joined[root];
    if (alone || component_of(w.component, root) != root) continue;
    Island& island = w.islands[w.num_islands];
    island = {.first_body = end,
              .end_body = order_bodies(root, static_cast<std::uint32_t>(num_bodies), end, w)};
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

}  // namespace godobject
