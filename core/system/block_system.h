// Symmetric block system of all coupled unknowns of a stage: A V = b (26). Unknowns are twists of bodies
// about their centres of mass. A term declares its coupling once with couple() and adds its values with
// add_*() whenever they change. Values are an effective mass A (h times an impedance) and an impulse b.
// Joints are no terms: `joints` eliminate unknowns (33).
//
// An implementation, with line_search.h, of the approach of Drake's irrotational contact fields (Castro, Han,
// Masterjohn 2024). docs/step.md lists the differences.
#pragma once

#include <cstdint>

#include "core/composition.h"
#include "core/math/bit_set.h"
#include "core/system/pivot.h"

namespace godobject {

/// Two unknowns that a term couples, by A_ij; A_ji is its transpose.
struct BlockEntry {
  std::uint32_t i = 0, j = 0;  // unknowns
  std::uint32_t slot = 0;      // index of the system's block, or no_slot
  SpatialMatrix A;             // value, if the factor is incomplete
};
inline constexpr std::uint32_t no_slot = ~std::uint32_t(0);

/// Motion of an unknown relative to its parent (33): V = X V_parent + S q'.
struct BlockJoint {
  static constexpr std::uint32_t on_world = ~std::uint32_t(0);
  bool is_free = true;              // true if it has no parent
  std::uint32_t parent = on_world;  // unknown number of the parent
  int num_axes = 0;
  Column d;                         // vector from the parent to this unknown
  std::array<SpatialVector, 3> s;   // axes S, at this unknown
  std::array<Real, 3> D_inverse{};  // pivots of the coordinates, once factored

  bool has_parent() const noexcept { return !is_free && parent != on_world; }
};

/// Undefined between steps. room: capacity of the factor for blocks beside the diagonal. always_keeps: loaded
/// values are kept, also with a complete factor.
template <std::size_t max_unknowns_, std::size_t max_entries_, std::size_t room_, bool jointed_,
          bool always_keeps_ = false>
struct BlockSystem {
  static constexpr std::size_t max_unknowns = max_unknowns_, max_entries = max_entries_, room = room_;
  static constexpr bool jointed = jointed_, always_keeps = always_keeps_;
  static constexpr bool is_coupled = false;  // true with nodes of nets
  static_assert(max_unknowns < 0xfffe);
  static_assert(!jointed || room >= max_unknowns, "a joint needs its block");
  using Vector = std::array<SpatialVector, max_unknowns>;
  using Set = BitSet<max_unknowns>;

  // unknowns in the order of adding, indexed by place; then numbered in elimination order
  std::uint32_t size = 0;
  std::array<std::uint32_t, max_unknowns> unknown, number_of;
  std::uint32_t num_entries = 0;
  std::array<BlockEntry, max_entries> entries;
  // indexed by unknown
  Vector b;
  [[no_unique_address]] std::conditional_t<jointed, std::array<BlockJoint, max_unknowns>, Absent<14>> joints;

  // indexed by elimination number: A_kk, and the blocks A_ik of each column, rows ascending. They hold the
  // loaded values, then the factors L D L^T and Z_i (31)
  std::array<SymmetricSpatialMatrix, max_unknowns> A_kk;
  std::array<Pivot, max_unknowns> pivots;
  std::array<std::uint32_t, max_unknowns + 1> first;
  std::array<std::uint32_t, room> row;
  std::array<bool, room> is_fill;  // true if the block is zero before elimination
  std::array<SpatialMatrix, room> Z;
  // false if blocks without room are left out; conjugate gradients then need A and entries as loaded
  bool is_complete = true;
  std::array<SymmetricSpatialMatrix, max_unknowns> A;
  std::array<SpatialVector, max_unknowns> root_diagonal;

  // storage for the numbering, indexed by place
  std::array<Set, max_unknowns> neighbours;
  std::array<std::uint32_t, max_unknowns> degree, order;
  [[no_unique_address]] std::conditional_t<jointed, std::array<std::uint32_t, max_unknowns>, Absent<15>>
      remaining_children;

  const BlockJoint* joint_of(std::uint32_t u) const noexcept {
    if constexpr (jointed) {
      if (!joints[u].is_free) return &joints[u];
    }
    return nullptr;
  }

  /// True if the loaded system is kept beside its factor.
  bool is_kept() const noexcept { return always_keeps || !is_complete; }
  /// Keeps the diagonal; entries are kept as loaded.
  void keep() noexcept {
    for (std::uint32_t k = 0; k < size; ++k) A[k] = A_kk[k];
  }

  void clear() noexcept { size = num_entries = 0; }
  void add_unknown(std::uint32_t u) noexcept {
    number_of[u] = size;
    unknown[size++] = u;
    if constexpr (jointed) joints[u].is_free = true;
  }
  /// Declares that a term couples two unknowns. Returns its entry; no_slot if there are max_entries.
  std::uint32_t couple(std::uint32_t i, std::uint32_t j) noexcept {
    if (num_entries == max_entries) return no_slot;
    BlockEntry& entry = entries[num_entries];
    entry.i = i;
    entry.j = j;
    return num_entries++;
  }
  /// Clears the system before terms are loaded. Each unknown's own term is set(), others are added.
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
  /// Adds A_ij to an entry.
  void add_coupling(std::uint32_t entry, const SpatialMatrix& A_ij) noexcept {
    add_to_factor(entry, A_ij);
    if (is_kept()) entries[entry].A += A_ij;
  }
  /// Adds A_ij to an entry of the factor alone, after keep().
  void add_to_factor(std::uint32_t entry, const SpatialMatrix& A_ij) noexcept {
    const BlockEntry& e = entries[entry];
    if (e.slot != no_slot) Z[e.slot] += number_of[e.i] > number_of[e.j] ? A_ij : transposed(A_ij);
  }
  /// Adds an effective mass for the twist of body c against body p, d away, taken at c. entry: of (p, c).
  void add_between(std::uint32_t entry, const SymmetricSpatialMatrix& A_c, const Column& d) noexcept {
    const SpatialMatrix A_pc = coupling(A_c, d);
    A_kk[number_of[entries[entry].j]] += A_c;
    add_coupled_to_parent(A_pc, d, A_kk[number_of[entries[entry].i]]);
    add_coupling(entry, A_pc);
  }

  /// Calls f(unknown) for all unknowns.
  template <class F>
  void each(F f) const noexcept {
    for (std::uint32_t k = 0; k < size; ++k) f(unknown[k]);
  }
  /// Computes AV = A V. A system that is not kept must not be factored yet.
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

  /// Calls f with the columns of a numbered unknown u in threes, as a constant: 2 for a body without a joint,
  /// 1 for a joint's coordinates.
  template <class F>
  void with_columns(std::uint32_t u, F f) const noexcept {
    if (joint_of(u) == nullptr) f(std::integral_constant<int, 2>{});
    else f(std::integral_constant<int, 1>{});
  }
};

}  // namespace godobject
