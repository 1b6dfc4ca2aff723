// Pairs of bodies in contact, and the islands formed by contacts and joints.
#pragma once

#include <array>
#include <utility>

#include "core/joint/edges.h"
#include "core/term/term.h"

namespace godobject {

/// Contacts of a pair of bodies, or of a body with the world, and their sum: effective mass and impulse at
/// rest.
struct TouchingContacts {
  std::uint32_t first_pack = 0, end_pack = 0;
  bool touches = false;  // true if some contact is active
  SymmetricSpatialMatrix A;
  SpatialVector F;
};

/// Pair of bodies in contact. A and F are for the twist of the child against the parent, at the child's
/// centre of mass.
struct TouchingPair : TouchingContacts {
  std::uint32_t child = 0, parent = 0;
  bool is_deep = false;     // true if some contact is deep at the predicted places
  std::uint32_t entry = 0;  // entry in the system, or no_slot
  Column d;                 // vector from the parent's centre of mass to the child's
};

/// Island: bodies near each other and near no others, a system of its own. Ranges in the order of
/// TouchingGraph.
struct Island {
  std::uint32_t first_body = 0, end_body = 0, first_pair = 0, end_pair = 0;
  bool has_terms = false, has_net = false;
};

/// Graph of bodies in contact, undefined between steps.
template <std::size_t N, std::size_t max_pairs, bool jointed_ = false, std::size_t max_terms = 0>
struct TouchingGraph {
  static constexpr bool jointed = jointed_, has_terms = max_terms > 0;
  std::array<TouchingContacts, N> bodies;  // their contacts with the world
  std::array<TouchingPair, max_pairs> pairs;
  std::size_t num_pairs = 0;
  std::array<std::uint32_t, N> order;               // bodies with contacts, island by island
  std::array<std::uint32_t, max_pairs> pair_order;  // pairs, island by island
  std::array<Island, N> islands;
  std::size_t num_islands = 0;
  std::array<std::uint32_t, N> joined_to,
      island_of;  // union-find parent of each body; island of each root
  [[no_unique_address]] std::conditional_t<jointed, JointEdges<N>, Absent<11>> joints;
  [[no_unique_address]] std::conditional_t<has_terms, std::array<TermEdge, max_terms>, Absent<19>> terms;
  std::uint32_t num_terms = 0;

  /// Calls f(number, body) for each body of an island. each_pair() calls f(pair) for each of its pairs.
  template <class F>
  void each_body(const Island& island, F f) noexcept {
    for (std::uint32_t k = island.first_body; k < island.end_body; ++k) f(order[k], bodies[order[k]]);
  }
  template <class F>
  void each_pair(const Island& island, F f) noexcept {
    if constexpr (max_pairs > 0)
      for (std::uint32_t k = island.first_pair; k < island.end_pair; ++k) f(pairs[pair_order[k]]);
  }

  /// Returns the root of a body in the union-find forest.
  std::uint32_t root_of(std::uint32_t i) noexcept {
    while (joined_to[i] != i) i = joined_to[i] = joined_to[joined_to[i]];
    return i;
  }
  void join(std::uint32_t i, std::uint32_t j) noexcept { joined_to[root_of(i)] = root_of(j); }
  Island& island_with(std::uint32_t i) noexcept { return islands[island_of[root_of(i)]]; }
};

/// Unites bodies that form a pair or are joined by a term or a joint. Bodies on joints to the world are one
/// tool.
template <std::size_t N, std::size_t max_pairs, bool jointed, std::size_t max_terms>
void join_bodies(std::size_t num_bodies, TouchingGraph<N, max_pairs, jointed, max_terms>& w) noexcept {
  for (std::uint32_t i = 0; i < num_bodies; ++i) w.joined_to[i] = i;
  if constexpr (max_pairs > 0)
    for (std::uint32_t k = 0; k < w.num_pairs; ++k) w.join(w.pairs[k].child, w.pairs[k].parent);
  if constexpr (max_terms > 0)
    for (std::uint32_t t = 0; t < w.num_terms; ++t)
      for (std::uint32_t e = 1; e < w.terms[t].size; ++e) w.join(w.terms[t].list[0], w.terms[t].list[e]);
  if constexpr (jointed) {
    std::size_t on_world = world;
    for (std::uint32_t i = 0; i < num_bodies; ++i) {
      const JointEdge& joint = w.joints.edges[i];
      if (joint.on_body()) w.join(i, static_cast<std::uint32_t>(joint.parent));
      if (!joint.on_world()) continue;
      if (on_world != world) w.join(i, static_cast<std::uint32_t>(on_world));
      on_world = i;
    }
  }
}

/// Builds the islands with their bodies and pairs. touches[i]: true if body i touches anything.
/// join_further(): unites bodies by couplings that are not in the graph.
template <std::size_t N, std::size_t max_pairs, bool jointed, std::size_t max_terms, class JoinFurther>
void make_islands(const std::array<bool, N>& touches, std::size_t num_bodies,
                  TouchingGraph<N, max_pairs, jointed, max_terms>& w, JoinFurther join_further) noexcept {
  join_bodies(num_bodies, w);
  join_further();
  const auto is_alone = [&](std::uint32_t i) noexcept {
    if constexpr (jointed) {
      if (w.joints.joined[i]) return false;
    }
    return !touches[i];
  };
  w.num_islands = 0;
  for (std::uint32_t i = 0; i < num_bodies; ++i) {
    if (is_alone(i) || w.root_of(i) != i) continue;
    w.islands[w.num_islands] = {};
    w.island_of[i] = static_cast<std::uint32_t>(w.num_islands++);
  }
  // count, then start, then members of each island
  for (std::uint32_t i = 0; i < num_bodies; ++i)
    if (!is_alone(i)) ++w.island_with(i).end_body;
  if constexpr (max_pairs > 0)
    for (std::uint32_t k = 0; k < w.num_pairs; ++k) ++w.island_with(w.pairs[k].child).end_pair;
  std::uint32_t body = 0, pair = 0;
  for (std::size_t n = 0; n < w.num_islands; ++n) {
    Island& island = w.islands[n];
    island.first_body = body;
    island.first_pair = pair;
    body += std::exchange(island.end_body, body);
    pair += std::exchange(island.end_pair, pair);
  }
  for (std::uint32_t i = 0; i < num_bodies; ++i)
    if (!is_alone(i)) w.order[w.island_with(i).end_body++] = i;
  if constexpr (max_pairs > 0)
    for (std::uint32_t k = 0; k < w.num_pairs; ++k)
      w.pair_order[w.island_with(w.pairs[k].child).end_pair++] = k;
  if constexpr (max_terms > 0) {
    for (std::uint32_t t = 0; t < w.num_terms; ++t) {
      w.terms[t].island = w.island_of[w.root_of(w.terms[t].list[0])];
      w.islands[w.terms[t].island].has_terms = true;
    }
  }
}

}  // namespace godobject
