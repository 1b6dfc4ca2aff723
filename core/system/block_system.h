// One symmetric system of everything that a stage of an integrator couples: (26)  A V = b. Unknowns are twists of bodies,
// about their centres of mass, and velocities of nodes. What acts between them is a term, and add() is the way in for all:
// an effective mass A (h times an impedance) and an impulse b. A term says first between whom it acts, couple(), then, as
// often as it changes, what it is. Joints are no terms: `joints` take unknowns out (33).
//
// Like line_search.h, an implementation of the approach of Drake's irrotational contact fields (Castro, Han,
// Masterjohn 2024). docs/step.md lists the differences.
#pragma once

#include <cstdint>

#include "core/math/bit_set.h"
#include "core/scene.h"
#include "core/system/pivot.h"

namespace godobject {

/// Two unknowns that a term couples, by A_ij; A_ji is its transpose.
struct BlockEntry {
  std::uint32_t i = 0, j = 0;  // unknowns
  std::uint32_t slot = 0;      // of the system's blocks, or no_slot
  SpatialMatrix A;             // where the factor is not complete
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

  bool has_parent() const noexcept { return !is_free && parent != on_world; }
};

/// Scratch: undefined between steps. room: blocks beside the diagonal that the factor has room for. Of the unknowns the
/// first max_bodies are bodies, the others nodes.
/// always_keeps: what was loaded is kept however the system is solved.
template <std::size_t max_bodies_, std::size_t max_nodes_, std::size_t max_entries_, std::size_t room_,
          bool jointed_, bool always_keeps_ = false>
struct BlockSystem {
  static constexpr std::size_t max_bodies = max_bodies_, max_unknowns = max_bodies_ + max_nodes_;
  static constexpr std::size_t max_entries = max_entries_, room = room_;
  static constexpr bool has_nodes = max_nodes_ > 0, jointed = jointed_, always_keeps = always_keeps_;
  static constexpr bool is_coupled = false;  // with nodes of nets
  static_assert(max_unknowns < 0xfffe);
  static_assert(!jointed || room >= max_unknowns, "a joint needs its block");
  using Vector = std::array<SpatialVector, max_unknowns>;
  using Set = BitSet<max_unknowns>;

  // the unknowns that are solved for: by place, as they were added, until they are numbered in the order of elimination
  std::uint32_t size = 0;
  std::array<std::uint32_t, max_unknowns> unknown, number_of;
  std::uint32_t num_entries = 0;
  std::array<BlockEntry, max_entries> entries;
  // by unknown
  Vector b;
  [[no_unique_address]] std::conditional_t<jointed, std::array<BlockJoint, max_unknowns>, Absent<14>> joints;

  // by number, A_kk and the blocks A_ik of each column by rising rows: as terms load them, then L D L^T, (31), Z_i
  std::array<SymmetricSpatialMatrix, max_unknowns> A_kk;
  std::array<Pivot, max_unknowns> pivots;
  std::array<std::uint32_t, max_unknowns + 1> first;
  std::array<std::uint32_t, room> row;
  std::array<bool, room> is_fill;  // zero but for elimination
  std::array<SpatialMatrix, room> Z;
  // false: blocks without room are left out, and conjugate gradients ask for A and entries as they were loaded
  bool is_complete = true;
  std::array<SymmetricSpatialMatrix, max_unknowns> A;
  std::array<SpatialVector, max_unknowns> root_diagonal;

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

  /// The system as it was loaded outlives its factor.
  bool is_kept() const noexcept { return always_keeps || !is_complete; }
  /// Keeps the diagonal as it is; entries are kept as they are loaded.
  void keep() noexcept {
    for (std::uint32_t k = 0; k < size; ++k) A[k] = A_kk[k];
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
  /// Before terms are loaded: nothing couples anything. Each unknown's own term is set(), others are added.
  void begin_loading() noexcept {
    for (std::uint32_t s = 0; s < first[size]; ++s) Z[s] = SpatialMatrix::zero();
    if (!is_kept()) return;
    for (std::uint32_t e = 0; e < num_entries; ++e) entries[e].A = SpatialMatrix::zero();
  }

  void set(std::uint32_t i, const SymmetricSpatialMatrix& A_ii, const SpatialVector& b_i) noexcept {
    A_kk[number_of[i]] = A_ii;
    b[i] = b_i;
  }
  void add(std::uint32_t i, const SymmetricSpatialMatrix& A_ii) noexcept { A_kk[number_of[i]] += A_ii; }
  void add_impulse(std::uint32_t i, const SpatialVector& b_i) noexcept { b[i] = b[i] + b_i; }
  /// A_ij of an entry.
  void add_coupling(std::uint32_t entry, const SpatialMatrix& A_ij) noexcept {
    add_to_factor(entry, A_ij);
    if (is_kept()) entries[entry].A += A_ij;
  }
  /// A_ij of an entry, for the factor alone: after keep().
  void add_to_factor(std::uint32_t entry, const SpatialMatrix& A_ij) noexcept {
    const BlockEntry& e = entries[entry];
    if (e.slot != no_slot) Z[e.slot] += number_of[e.i] > number_of[e.j] ? A_ij : transposed(A_ij);
  }
  /// An effective mass for the twist of body c against body p, d away, taken at c. entry: of (p, c).
  void add_between(std::uint32_t entry, const SymmetricSpatialMatrix& A_c, const Column& d) noexcept {
    const SpatialMatrix A_pc = coupling(A_c, d);
    A_kk[number_of[entries[entry].j]] += A_c;
    add_coupled_to_parent(A_pc, d, A_kk[number_of[entries[entry].i]]);
    add_coupling(entry, A_pc);
  }

  /// f(unknown) for all of them.
  template <class F>
  void each(F f) const noexcept {
    for (std::uint32_t k = 0; k < size; ++k) f(unknown[k]);
  }
  /// AV = A V; if the system is not kept, before it is factored.
  template <class OfV, class OfAV>
  void multiply(const OfV& V, OfAV& AV) const noexcept {
    const auto& diagonal = is_kept() ? A : A_kk;
    for (std::uint32_t k = 0; k < size; ++k) AV[unknown[k]] = diagonal[k] * V[unknown[k]];
    const auto add_product = [&](std::uint32_t i, std::uint32_t j, const SpatialMatrix& A_ij) noexcept {
      AV[i] = AV[i] + A_ij * V[j];
      AV[j] = AV[j] + times_transposed(A_ij, V[i]);
    };
    if (!is_kept()) {
      for (std::uint32_t k = 0; k < size; ++k)
        for (std::uint32_t s = first[k]; s < first[k + 1]; ++s)
          if (!is_fill[s]) add_product(unknown[row[s]], unknown[k], Z[s]);
    } else {
      for (std::uint32_t e = 0; e < num_entries; ++e) add_product(entries[e].i, entries[e].j, entries[e].A);
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
