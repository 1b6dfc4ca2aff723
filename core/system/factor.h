// Bodies that touch in loops, solved exactly: the factor of their whole system, in an order of least degree.
//
// A pile is a graph of bodies and of pairs that touch. Of the bodies that are left, the one with the fewest neighbours is
// eliminated next, which joins these to each other; k by k, with i and j its neighbours,
//
//   (31)  A_kk = L D L^T,  Z_i = A_ik L^-T,  A_ij -= Z_i D^-1 Z_j^T
//
// by substitution, without inverses: a body keeps its mass beside contacts that are 1e10 times stiffer. Bodies on joints
// by (33), after all that hangs on them. Bound: max_blocks blocks A_ik, and for each body a product for every two of its
// neighbours. An island that has more is left to the iteration.
//
// The room: what solves bodies that touch, together: factor_joints.h brings joints in (33), coupling_block.h is a
// pair's block, conjugate_gradients.h serves where the factor has no room.
#pragma once

#include "core/contact/tree_solve.h"
#include "core/math/bit_set.h"
#include "core/system/factor_joints.h"

namespace godobject {

/// What still hangs on a body by joints while the order is sought, and the place of the one it hangs on.
struct FactorLeaves {
  static constexpr std::uint32_t nowhere = ~std::uint32_t(0);
  std::uint32_t hanging = 0, parent = nowhere;
};

/// Scratch: undefined between steps. Bodies are numbered as they are eliminated.
template <std::size_t N, bool jointed_ = false>
struct ContactFactor {
  static constexpr bool jointed = jointed_;
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
  // by place in the island; by number
  [[no_unique_address]] std::conditional_t<jointed, std::array<FactorLeaves, N>, Absent<13>> leaves;
  [[no_unique_address]] std::conditional_t<jointed, std::array<FactoredJoint, N>, Absent<14>> joints;

  static constexpr std::uint32_t not_yet = 0xfffe, eliminated = 0xffff;
  static_assert(N < not_yet);
  /// Neighbours of the body at this place.
  std::uint32_t degree_of(std::uint32_t place) const noexcept {
    if constexpr (jointed) {
      if (leaves[place].hanging > 0) return not_yet;
    }
    return neighbours[place].size(size);
  }
  /// Of row i, from block b of its column on.
  std::uint32_t find_row(std::uint32_t i, std::uint32_t b) const noexcept {
    while (row[b] != i) ++b;
    return b;
  }
};

/// Who hangs on whom by a joint; they are neighbours as well.
template <std::size_t N, std::size_t max_pairs>
void find_leaves(const Island& island, const ContactTree<N, max_pairs, true>& tree,
                 ContactFactor<N, true>& w) noexcept {
  for (std::uint32_t i = 0; i < w.size; ++i) w.leaves[i] = {};
  tree.each_body(island, [&](std::uint32_t body, const TouchingBody& c) noexcept {
    if (tree.joint_of(c) == nullptr || c.parent == body) return;
    const std::uint32_t i = w.number_of[body], p = w.number_of[c.parent];
    w.leaves[i].parent = p;
    ++w.leaves[p].hanging;
    w.neighbours[i].insert(p);
    w.neighbours[p].insert(i);
  });
}

/// Who touches whom in an island, or is about to.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void find_neighbours(const Island& island, ContactTree<N, max_pairs, jointed>& tree,
                     ContactFactor<N, jointed>& w) noexcept {
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
  if constexpr (jointed) find_leaves(island, tree, w);
  for (std::uint32_t i = 0; i < w.size; ++i) w.degree[i] = w.degree_of(i);
}

/// The order of elimination. False: there is no room for the blocks.
template <std::size_t N, bool jointed>
bool order_bodies(ContactFactor<N, jointed>& w) noexcept {
  std::size_t num_blocks = 0;
  for (std::uint32_t k = 0; k < w.size; ++k) {
    std::uint32_t least =
        ~std::uint32_t(0);  // degree, then place: one number, which no branch has to wait for
    for (std::uint32_t i = 0; i < w.size; ++i) least = std::min(least, w.degree[i] << 16 | i);
    const std::uint32_t next = least & 0xffff;
    num_blocks += w.degree[next];
    if (num_blocks > w.max_blocks) return false;
    w.degree[next] = w.eliminated;
    w.place_of[k] = next;
    if constexpr (jointed) {
      if (w.leaves[next].parent != FactorLeaves::nowhere) --w.leaves[w.leaves[next].parent].hanging;
    }
    w.neighbours[next].each(w.size, [&](std::uint32_t i) noexcept {
      BitSet<N>& of_i = w.neighbours[i];
      of_i.insert(w.neighbours[next], w.size);
      of_i.erase(i);
      of_i.erase(next);
      w.degree[i] = w.degree_of(i);
    });
  }
  return true;
}

/// The joints by which the bodies of the factor hang.
template <std::size_t N, std::size_t max_pairs>
void load_joints(const ContactTree<N, max_pairs, true>& tree, ContactFactor<N, true>& w) noexcept {
  for (std::uint32_t k = 0; k < w.size; ++k) {
    const std::uint32_t i = w.body[k], p = tree.bodies[i].parent;
    const JointEdge* edge = tree.joint_of(tree.bodies[i]);
    FactoredJoint& joint = w.joints[k];
    joint.is_free = edge == nullptr;
    joint.on_world = p == i;
    if (edge == nullptr) continue;
    joint.num_axes = edge->num_axes;
    joint.parent = w.number_of[p];
    joint.d = tree.joints.p[i] - tree.joints.p[p];
    for (int a = 0; a < edge->num_axes; ++a)
      joint.s[static_cast<std::size_t>(a)] = axis_twist(*edge, a, tree.joints.p[i]);
  }
}

/// The numbers of an island's bodies, and its blocks. False: there is no room for them.
template <std::size_t N, std::size_t max_pairs, bool jointed>
bool order_factor(const Island& island, ContactTree<N, max_pairs, jointed>& tree,
                  ContactFactor<N, jointed>& w) noexcept {
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
  if constexpr (jointed) load_joints(tree, w);
  return true;
}

/// A of an island: of the bodies, and of the pairs that touch.
template <std::size_t N, std::size_t max_pairs, bool jointed>
void load_factor(const Island& island, const ContactTree<N, max_pairs, jointed>& tree,
                 ContactFactor<N, jointed>& w) noexcept {
  for (std::uint32_t k = 0; k < w.size; ++k) w.A[k] = tree.bodies[w.body[k]].A;
  for (std::uint32_t b = 0; b < w.first[w.size]; ++b) w.Z[b] = no_coupling();
  tree.each_pair(island, [&](const TouchingPair& pair) noexcept {
    if (!pair.touches) return;
    const std::uint32_t c = w.number_of[pair.child], p = w.number_of[pair.parent];
    w.A[c] += pair.A;
    const CouplingBlock A_pc = coupling(pair.A, pair.d);
    add_to_parent(A_pc, pair.d, w.A[p]);
    w.Z[pair.block] = p > c ? A_pc : transposed(A_pc);
  });
}

/// (33)  Body k by the coordinates of the joint by which it hangs.
template <std::size_t N>
void take_by_axes(std::uint32_t k, const JointEdge& edge, ContactFactor<N, true>& w) noexcept {
  const FactoredJoint& joint = w.joints[k];
  const std::uint32_t p = joint.parent;
  for (std::uint32_t b = w.first[k]; b < w.first[k + 1]; ++b) {
    const std::uint32_t i = w.row[b];
    if (joint.hangs()) {
      const CouplingBlock A_ip = shifted(w.Z[b], joint.d);
      if (i > p) w.Z[w.find_row(i, w.first[p])] += A_ip;
      if (i < p) w.Z[w.find_row(p, w.first[i])] += transposed(A_ip);
      if (i == p) {
        add_both(A_ip, w.A[p]);
        w.Z[b] += coupling(w.A[k] * Real(-1), joint.d);
      }
    }
    w.Z[b] = along_axes(w.Z[b], joint);
  }
  if (joint.hangs()) add_to_parent(w.A[k], joint.d, w.A[p]);
  w.A[k] = along_axes(w.A[k], joint, edge);
}

/// (31) of an island; again: with the impedances changed, and no other pairs. False: there is no room.
template <std::size_t N, std::size_t max_pairs, bool jointed>
bool factorize(const Island& island, bool again, ContactTree<N, max_pairs, jointed>& tree,
               ContactFactor<N, jointed>& w) noexcept {
  if (again) {
    tree.each_pair(island, [&](const TouchingPair& pair) noexcept {
      again = again && (pair.block != w.no_block || !pair.touches);
    });
  }
  if (!again && !order_factor(island, tree, w)) return false;
  load_factor(island, tree, w);
  for (std::uint32_t k = 0; k < w.size; ++k) {
    if constexpr (jointed) {
      if (const JointEdge* joint = tree.joint_of(tree.bodies[w.body[k]])) take_by_axes(k, *joint, w);
    }
    const PivotFactor& pivot = w.pivots[k] = factor(w.A[k]);
    if constexpr (jointed) {
      if (!w.joints[k].is_free)
        for (std::size_t a = 0; a < 3; ++a) tree.joints.axes[w.body[k]][a].D_inverse = pivot.D_inverse[a][0];
    }
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
template <std::size_t N, bool jointed>
void solve(const ContactFactor<N, jointed>& w, std::array<AnchorTwist, N>& b,
           std::array<AnchorTwist, N>& V) noexcept {
  for (std::uint32_t k = 0; k < w.size; ++k) {
    AnchorTwist& b_k = b[w.body[k]];
    if constexpr (jointed) {
      const FactoredJoint& joint = w.joints[k];
      if (joint.hangs()) {
        AnchorTwist& b_p = b[w.body[joint.parent]];
        b_p = b_p + moved_wrench(b_k, joint.d);
      }
      if (!joint.is_free) b_k = along_axes(b_k, joint);
    }
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
    AnchorTwist& V_k = V[w.body[k]];
    V_k = raised(w.pivots[k], b[w.body[k]] - scaled(sum, w.pivots[k]));
    if constexpr (jointed) {
      const FactoredJoint& joint = w.joints[k];
      if (!joint.is_free) V_k = along_axes(joint, V_k.w);
      if (joint.hangs()) V_k = V_k + shifted(V[w.body[joint.parent]], joint.d);
    }
  }
}

}  // namespace godobject
