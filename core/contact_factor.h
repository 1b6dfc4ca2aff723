// Bodies that touch in loops, solved exactly: the factor of their whole system, in an order of least degree.
//
// A pile is a graph of bodies and of pairs that touch. Of the bodies that are left, the one with the fewest neighbours is
// eliminated next, which joins these to each other; k by k, with i and j its neighbours,
//
//   (31)  A_kk = L D L^T,  Z_i = A_ik L^-T,  A_ij -= Z_i D^-1 Z_j^T
//
// by substitution, without inverses: a body keeps its mass beside contacts that are 1e10 times stiffer. Bound: max_blocks
// blocks A_ik, and for each body a product for every two of its neighbours. An island that has more is left to the
// iteration.
#pragma once

#include "core/bit_set.h"
#include "core/contact_tree_solve.h"
#include "core/coupling_block.h"

namespace godobject {

/// Worthless between steps. Bodies are numbered as they are eliminated.
template <std::size_t N>
struct ContactFactor {
  static constexpr std::size_t max_blocks = std::min(8 * N, N*(N - 1) / 2 + 1);
  static constexpr std::uint32_t no_block = ~std::uint32_t(0);
  std::uint32_t size = 0;
  std::array<std::uint32_t, N> body, number_of;  // in the scene; here, of a body of the scene
  std::array<TwistBlock, N> A;                   // A_kk
  std::array<PivotFactor, N> pivots;
  std::array<std::uint32_t, N + 1> first;  // blocks of each column, in the order of their rows
  std::array<std::uint32_t, max_blocks> row;
  std::array<CouplingBlock, max_blocks> Z;  // A_ik, then Z_i
  // of the ordering, by place in the island
  std::array<BitSet<N>, N> neighbours;  // of a body that is eliminated: when it was
  std::array<std::uint32_t, N> degree, place_of;

  /// Of row i, from block b of its column on.
  std::uint32_t find_row(std::uint32_t i, std::uint32_t b) const noexcept {
    while (row[b] != i) ++b;
    return b;
  }
};

/// Who touches whom in an island, or is about to.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void find_neighbours(const Island& island, ContactTree<N, max_pairs, jointed>& tree,
                     ContactFactor<N>& w) noexcept {
  w.size = island.end_body - island.first_body;
  for (std::uint32_t i = 0; i < w.size; ++i) {
    w.neighbours[i] = {};
    w.number_of[tree.order[island.first_body + i]] = i;
  }
  tree.each_pair(island, [&](TouchingPair& pair) noexcept {
    pair.block = pair.touches || pair.stiffness > 0 ? 0 : w.no_block;
    if (pair.block == w.no_block) return;
    const std::uint32_t i = w.number_of[pair.child], j = w.number_of[pair.parent];
    w.neighbours[i].insert(j);
    w.neighbours[j].insert(i);
  });
  for (std::uint32_t i = 0; i < w.size; ++i) w.degree[i] = w.neighbours[i].size(w.size);
}

/// The order of elimination. False: there is no room for the blocks.
template <std::size_t N>
bool order_bodies(ContactFactor<N>& w) noexcept {
  constexpr std::uint32_t eliminated = 0xffff;
  static_assert(N < eliminated);
  std::size_t num_blocks = 0;
  for (std::uint32_t k = 0; k < w.size; ++k) {
    std::uint32_t least =
        ~std::uint32_t(0);  // degree, then place: one number, which no branch has to wait for
    for (std::uint32_t i = 0; i < w.size; ++i) least = std::min(least, w.degree[i] << 16 | i);
    const std::uint32_t next = least & 0xffff;
    num_blocks += w.degree[next];
    if (num_blocks > w.max_blocks) return false;
    w.degree[next] = eliminated;
    w.place_of[k] = next;
    w.neighbours[next].each(w.size, [&](std::uint32_t i) noexcept {
      BitSet<N>& of_i = w.neighbours[i];
      of_i.insert(w.neighbours[next], w.size);
      of_i.erase(i);
      of_i.erase(next);
      w.degree[i] = of_i.size(w.size);
    });
  }
  return true;
}

/// The numbers of an island's bodies, and its blocks. False: there is no room for them.
template <std::size_t N, std::size_t max_pairs, bool jointed>
bool order_factor(const Island& island, ContactTree<N, max_pairs, jointed>& tree,
                  ContactFactor<N>& w) noexcept {
  find_neighbours(island, tree, w);
  if (!order_bodies(w)) return false;
  const auto body_at = [&](std::uint32_t place) noexcept { return tree.order[island.first_body + place]; };
  for (std::uint32_t k = 0; k < w.size; ++k) {
    w.body[k] = body_at(w.place_of[k]);
    w.number_of[w.body[k]] = k;
  }
  std::uint32_t b = 0;
  for (std::uint32_t k = 0; k < w.size; ++k) {
    w.first[k] = b;
    w.neighbours[w.place_of[k]].each(
        w.size, [&](std::uint32_t place) noexcept { w.row[b++] = w.number_of[body_at(place)]; });
    std::sort(w.row.begin() + w.first[k], w.row.begin() + b);
  }
  w.first[w.size] = b;
  tree.each_pair(island, [&](TouchingPair& pair) noexcept {
    if (pair.block == w.no_block) return;
    const std::uint32_t c = w.number_of[pair.child], p = w.number_of[pair.parent];
    pair.block = w.find_row(std::max(c, p), w.first[std::min(c, p)]);
  });
  return true;
}

/// A of an island: of the bodies, and of the pairs that touch.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void load_factor(const Island& island, const ContactTree<N, max_pairs, jointed>& tree,
                 ContactFactor<N>& w) noexcept {
  for (std::uint32_t k = 0; k < w.size; ++k) w.A[k] = tree.bodies[w.body[k]].A;
  for (std::uint32_t b = 0; b < w.first[w.size]; ++b) w.Z[b] = no_coupling();
  tree.each_pair(island, [&](const TouchingPair& pair) noexcept {
    if (!pair.touches) return;
    const std::uint32_t c = w.number_of[pair.child], p = w.number_of[pair.parent];
    w.A[c] += pair.A;
    const CouplingBlock A_pc = coupling(pair.A, pair.d);
    hang(A_pc, pair.d, w.A[p]);
    w.Z[pair.block] = p > c ? A_pc : transposed(A_pc);
  });
}

/// (31) of an island; again: with the impedances changed, and no other pairs. False: there is no room.
template <std::size_t N, std::size_t max_pairs, bool jointed>
bool factorize(const Island& island, bool again, ContactTree<N, max_pairs, jointed>& tree,
               ContactFactor<N>& w) noexcept {
  if (again) {
    tree.each_pair(island, [&](const TouchingPair& pair) noexcept {
      again = again && (pair.block != w.no_block || !pair.touches);
    });
  }
  if (!again && !order_factor(island, tree, w)) return false;
  load_factor(island, tree, w);
  for (std::uint32_t k = 0; k < w.size; ++k) {
    const PivotFactor& pivot = w.pivots[k] = factor(w.A[k]);
    for (std::uint32_t b = w.first[k]; b < w.first[k + 1]; ++b) substitute(pivot, w.Z[b]);
    for (std::uint32_t c = w.first[k]; c < w.first[k + 1]; ++c) {
      const std::uint32_t j = w.row[c];
      const CouplingBlock Y_j = scaled(w.Z[c], pivot);
      subtract_product(w.Z[c], Y_j, w.A[j]);
      std::uint32_t to = w.first[j];
      for (std::uint32_t b = c + 1; b < w.first[k + 1]; ++b) {
        to = w.find_row(w.row[b], to);
        subtract_product(w.Z[b], Y_j, w.Z[to]);
      }
    }
  }
  return true;
}

/// V = A^-1 b. b is used up.
template <std::size_t N>
void solve(const ContactFactor<N>& w, std::array<AnchorTwist, N>& b, std::array<AnchorTwist, N>& V) noexcept {
  for (std::uint32_t k = 0; k < w.size; ++k) {
    AnchorTwist& b_k = b[w.body[k]];
    b_k = scaled(lowered(w.pivots[k], b_k), w.pivots[k]);
    for (std::uint32_t c = w.first[k]; c < w.first[k + 1]; ++c) {
      AnchorTwist& b_i = b[w.body[w.row[c]]];
      b_i = b_i - w.Z[c] * b_k;
    }
  }
  for (std::uint32_t k = w.size; k-- > 0;) {
    AnchorTwist sum{.w = Column(Pack(0)), .v = Column(Pack(0))};
    for (std::uint32_t c = w.first[k]; c < w.first[k + 1]; ++c)
      sum = sum + times_transposed(w.Z[c], V[w.body[w.row[c]]]);
    V[w.body[k]] = raised(w.pivots[k], b[w.body[k]] - scaled(sum, w.pivots[k]));
  }
}

}  // namespace godobject
