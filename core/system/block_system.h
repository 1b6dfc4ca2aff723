// One symmetric system A V = b of everything that a stage of an integrator couples: bodies, nodes, joints, contacts,
// springs.
//
// Unknowns are twists of bodies, about their centres of mass, and velocities of nodes. What acts between them is a term,
// and add() is the way in for all of them: an impedance A (times h) and an impulse b. A term says first between whom it
// acts, couple(), then, as often as it changes, what it is. Joints are no terms but take unknowns out, hang() (33).
//
// The room: block_order.h numbers the unknowns, block_factor.h is L D L^T of the system (31), with joints by
// block_joint.h (33), pivot.h of a diagonal block; conjugate_gradients.h iterates where the factor has no room for all
// of its blocks. Like the rest of this solver (line_search.h, the modes of contacts by Newton's method) it is the
// approach of Drake's irrotational contact fields (Castro, Han, Masterjohn 2024), with the differences in docs/step.md.
#pragma once

#include <cstdint>

#include "core/math/bit_set.h"
#include "core/scene.h"
#include "core/system/pivot.h"

namespace godobject {

/// What two unknowns are coupled by, A_ij; A_ji is its transpose.
struct BlockEntry {
  std::uint32_t i = 0, j = 0;  // unknowns
  std::uint32_t slot = 0;      // of a factor, or no_slot
  bool is_zero = true;
  SpatialMatrix A;
};
inline constexpr std::uint32_t no_slot = ~std::uint32_t(0);

/// (33)  How an unknown moves with the one it hangs on: V = X V_parent + S q'.
struct BlockJoint {
  static constexpr std::uint32_t on_world = ~std::uint32_t(0);
  bool is_free = true;              // it hangs on nothing
  std::uint32_t parent = on_world;  // unknown
  int num_axes = 0;
  Column d;                         // from the parent to this one
  std::array<SpatialVector, 3> s;   // at this one
  std::array<Real, 3> D_inverse{};  // pivots of the coordinates, once factored

  bool hangs() const noexcept { return !is_free && parent != on_world; }
};

/// Scratch: undefined between steps. room: blocks beside the diagonal that the factor has room for. Of the unknowns the
/// first max_bodies are bodies, the others nodes.
template <std::size_t max_bodies_, std::size_t max_nodes_, std::size_t max_entries_, std::size_t room_,
          bool jointed_>
struct BlockSystem {
  static constexpr std::size_t max_bodies = max_bodies_, max_unknowns = max_bodies_ + max_nodes_;
  static constexpr std::size_t max_entries = max_entries_, room = room_;
  static constexpr bool has_nodes = max_nodes_ > 0, jointed = jointed_;
  static_assert(max_unknowns < 0xfffe);
  static_assert(!jointed || room >= max_unknowns, "a joint needs its block");
  using Vector = std::array<SpatialVector, max_unknowns>;
  using Set = BitSet<max_unknowns>;

  // the unknowns that are solved for: by place, as they were added, until they are numbered in the order of elimination
  std::uint32_t size = 0;
  std::array<std::uint32_t, max_unknowns> unknown, number_of;
  // by unknown
  std::array<SymmetricSpatialMatrix, max_unknowns> A;
  Vector b;
  [[no_unique_address]] std::conditional_t<jointed, std::array<BlockJoint, max_unknowns>, Absent<14>> joints;
  // between unknowns
  std::uint32_t num_entries = 0;
  std::array<BlockEntry, max_entries> entries;

  // factor (31), by number: A_kk, L D L^T of it, and the blocks A_ik, then Z_i, of each column by rising rows
  std::array<SymmetricSpatialMatrix, max_unknowns> A_kk;
  std::array<Pivot, max_unknowns> pivots;
  std::array<std::uint32_t, max_unknowns + 1> first;
  std::array<std::uint32_t, room> row;
  std::array<SpatialMatrix, room> Z;
  bool is_complete = true;                                // false: blocks without room are left out of it
  std::array<SpatialVector, max_unknowns> root_diagonal;  // of A_kk, if some are

  // of the numbering, by place
  std::array<Set, max_unknowns> neighbours;
  std::array<std::uint32_t, max_unknowns> degree, order;
  [[no_unique_address]] std::conditional_t<jointed, std::array<std::uint32_t, max_unknowns>, Absent<15>>
      hanging;

  static constexpr bool is_body(std::uint32_t u) noexcept { return !has_nodes || u < max_bodies; }
  const BlockJoint* joint_of(std::uint32_t u) const noexcept {
    if constexpr (jointed) {
      if (!joints[u].is_free) return &joints[u];
    }
    return nullptr;
  }

  void clear() noexcept { size = num_entries = 0; }
  void add_unknown(std::uint32_t u) noexcept {
    number_of[u] = size;
    unknown[size++] = u;
    if constexpr (jointed) joints[u].is_free = true;
  }
  /// Says that a term acts between two unknowns. Its entry; no_slot: there are max_entries.
  std::uint32_t couple(std::uint32_t i, std::uint32_t j) noexcept {
    if (num_entries == max_entries) return no_slot;
    BlockEntry& entry = entries[num_entries];
    entry.i = i;
    entry.j = j;
    return num_entries++;
  }
  /// A = 0 and b = 0.
  void reset() noexcept {
    for (std::uint32_t k = 0; k < size; ++k) {
      A[unknown[k]] = {.ww = Block::zero(), .wv = Block::zero(), .vv = Block::zero()};
      b[unknown[k]] = SpatialVector::zero();
    }
    for (std::uint32_t e = 0; e < num_entries; ++e) entries[e].is_zero = true;
  }

  void add(std::uint32_t i, const SymmetricSpatialMatrix& A_ii) noexcept { A[i] += A_ii; }
  void add_impulse(std::uint32_t i, const SpatialVector& b_i) noexcept { b[i] = b[i] + b_i; }
  /// A_ij of an entry.
  void add_coupling(std::uint32_t entry, const SpatialMatrix& A_ij) noexcept {
    BlockEntry& e = entries[entry];
    if (e.is_zero) e.A = A_ij;
    else e.A += A_ij;
    e.is_zero = false;
  }
  /// An impedance for the twist of body c against body p, d away, taken at c. entry: of (p, c).
  void add_between(std::uint32_t entry, const SymmetricSpatialMatrix& A_c, const Column& d) noexcept {
    const SpatialMatrix A_pc = coupling(A_c, d);
    A[entries[entry].j] += A_c;
    add_coupled_to_parent(A_pc, d, A[entries[entry].i]);
    add_coupling(entry, A_pc);
  }

  /// f(unknown) for all of them.
  template <class F>
  void each(F f) const noexcept {
    for (std::uint32_t k = 0; k < size; ++k) f(unknown[k]);
  }
  /// AV = A V.
  void multiply(const Vector& V, Vector& AV) const noexcept {
    each([&](std::uint32_t u) noexcept { AV[u] = A[u] * V[u]; });
    for (std::uint32_t k = 0; k < num_entries; ++k) {
      const BlockEntry& e = entries[k];
      if (e.is_zero) continue;
      AV[e.i] = AV[e.i] + e.A * V[e.j];
      AV[e.j] = AV[e.j] + times_transposed(e.A, V[e.i]);
    }
  }

  /// f(rows of unknown u) as a constant: 2, or 1 for a node.
  template <class F>
  static void with_rows(std::uint32_t u, F f) noexcept {
    if (is_body(u)) f(std::integral_constant<int, 2>{});
    else f(std::integral_constant<int, 1>{});
  }
  /// f(columns of unknown u) as a constant, once it is numbered: the coordinates of a joint are in one.
  template <class F>
  void with_columns(std::uint32_t u, F f) const noexcept {
    if (is_body(u) && joint_of(u) == nullptr) f(std::integral_constant<int, 2>{});
    else f(std::integral_constant<int, 1>{});
  }
};

}  // namespace godobject
