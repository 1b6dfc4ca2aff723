// Factor of a block system: L D L^T, unknown by unknown, with i and j the neighbours of k,
//
//   (31)  A_kk = L D L^T,  Z_i = A_ik L^-T,  A_ij -= Z_i D^-1 Z_j^T
//
// by substitution, without inverses, so that a body keeps its mass beside contacts 1e10 times stiffer. Bound:
// `room` blocks A_ik, and for each unknown a product for every two of its neighbours.
//
// A block E without room is left out, and its size is added to both diagonals (Ajiz and Jennings 1984), entry
// by entry
//
//   (27)  A_ii(r) += |E_rc| sqrt(a_r / a_c),  A_jj(c) += |E_rc| sqrt(a_c / a_r),  a the diagonal of A
//
// The factored matrix M is then A plus a positive semidefinite matrix. All its pivots are positive, however
// much is left out, and conjugate gradients with it converge. Trees need no further blocks, so for them M =
// A.
#pragma once

#include "core/system/block_joint.h"

namespace godobject {

/// Adds a left-out block E to the diagonals of the unknowns numbered i and j (27).
template <class System>
void leave_out(std::uint32_t i, std::uint32_t j, const SpatialMatrix& E, System& w) noexcept {
  const SpatialVector &a_i = w.root_diagonal[i], &a_j = w.root_diagonal[j];
  const auto leave = [](const Block& e, const Column& a_r, const Column& a_c, Block& A_rr,
                        Block& A_cc) noexcept {
    for (std::size_t c = 0; c < 3; ++c) {
      const Column e_c(abs(e.col[c].p));
      const Real a = a_c.p[c];
      for (std::size_t r = 0; r < 3; ++r) A_rr.col[r].p.set(r, A_rr.col[r].p[r] + e_c.p[r] * a_r.p[r] / a);
      A_cc.col[c].p.set(
          c, A_cc.col[c].p[c] + a * (e_c.p[0] / a_r.p[0] + e_c.p[1] / a_r.p[1] + e_c.p[2] / a_r.p[2]));
    }
  };
  SymmetricSpatialMatrix &A_ii = w.A_kk[i], &A_jj = w.A_kk[j];
  leave(E.vv, a_i.v, a_j.v, A_ii.vv, A_jj.vv);
  leave(E.wv, a_i.w, a_j.v, A_ii.ww, A_jj.vv);
  leave(E.vw, a_i.v, a_j.w, A_ii.vv, A_jj.ww);
  leave(E.ww, a_i.w, a_j.w, A_ii.ww, A_jj.ww);
}

/// Leaves out all entries without a slot.
template <class System>
void leave_out_entries(System& w) noexcept {
  const auto root = [](const Block& A) noexcept {
    return Column(
        sqrt(diagonal(A.col[0].template all<0>(), A.col[1].template all<1>(), A.col[2].template all<2>()).p));
  };
  for (std::uint32_t k = 0; k < w.size; ++k) {
    w.root_diagonal[k] = {.w = root(w.A_kk[k].ww), .v = root(w.A_kk[k].vv)};
  }
  for (std::uint32_t e = 0; e < w.num_entries; ++e) {
    const BlockEntry& entry = w.entries[e];
    if (entry.slot == no_slot) leave_out(w.number_of[entry.i], w.number_of[entry.j], entry.A, w);
  }
}

/// Adds a block A_ij, i and j > k numbers, to its slot; leaves it out if it has none.
template <class System>
void add_block(std::uint32_t i, std::uint32_t j, const SpatialMatrix& A_ij, System& w) noexcept {
  const std::uint32_t low = std::min(i, j), high = std::max(i, j), end = w.first[low + 1];
  const std::uint32_t b = find_row(w, high, w.first[low], end);
  if (b == end) leave_out(i, j, A_ij, w);
  else w.Z[b] += i > j ? A_ij : transposed(A_ij);
}

/// Replaces the unknown numbered k by the coordinates of its joint (33).
template <class System>
void project_on_axes(std::uint32_t k, const BlockJoint& joint, System& w) noexcept {
  if (joint.has_parent()) {
    const std::uint32_t p = w.number_of[joint.parent];
    for (std::uint32_t b = w.first[k]; b < w.first[k + 1]; ++b) {
      const std::uint32_t i = w.row[b];
      const SpatialMatrix A_ip = shifted(w.Z[b], joint.d);
      if (i == p) {
        add_both(A_ip, w.A_kk[p]);
        w.Z[b] += coupling(w.A_kk[k] * Real(-1), joint.d);
      } else {
        add_block(i, p, A_ip, w);
      }
    }
    add_to_parent(w.A_kk[k], joint.d, w.A_kk[p]);
  }
  for (std::uint32_t b = w.first[k]; b < w.first[k + 1]; ++b) w.Z[b] = along_axes(w.Z[b], joint);
  w.A_kk[k] = along_axes(w.A_kk[k], joint);
}

/// Eliminates with one block of column k (31): block number c, Z_j. Subtracts its products with the blocks of
/// column k from the later columns. columns: number of columns of k.
template <int columns, class System>
void eliminate_block(std::uint32_t k, std::uint32_t c, System& w) noexcept {
  const std::uint32_t j = w.row[c], end = w.first[j + 1];
  std::uint32_t to = w.first[j];
  const SpatialMatrix Y_j = scaled<columns>(w.Z[c], w.pivots[k]);
  subtract_product<columns>(w.Z[c], Y_j, w.A_kk[j]);
  for (std::uint32_t b = c + 1; b < w.first[k + 1]; ++b) {
    const std::uint32_t i = w.row[b];
    while (to < end && w.row[to] < i) ++to;
    if (to < end && w.row[to] == i) {
      subtract_product<columns>(w.Z[b], Y_j, w.Z[to]);
    } else {
      SpatialMatrix E = SpatialMatrix::zero();
      subtract_product<columns>(w.Z[b], Y_j, E);
      leave_out(i, j, E, w);
    }
  }
}

/// Factors a system that is ordered and loaded (31).
template <class System>
void factorize(System& w) noexcept {
  if (!w.is_complete) {
    if constexpr (!System::always_keeps) w.keep();
    leave_out_entries(w);
  }
  for (std::uint32_t k = 0; k < w.size; ++k) {
    const std::uint32_t u = w.unknown[k];
    if (const BlockJoint* joint = w.joint_of(u)) project_on_axes(k, *joint, w);
    w.with_columns(u, [&](auto columns) noexcept {
      constexpr int C = decltype(columns)::value;
      Pivot& pivot = w.pivots[k];
      factor<C>(w.A_kk[k], pivot);
      for (std::uint32_t b = w.first[k]; b < w.first[k + 1]; ++b) substitute<C>(pivot, w.Z[b]);
      for (std::uint32_t c = w.first[k]; c < w.first[k + 1]; ++c) eliminate_block<C>(k, c, w);
    });
    if constexpr (System::jointed) {
      for (std::size_t a = 0; a < 3; ++a) w.joints[u].D_inverse[a] = w.pivots[k].D_inverse[3 + a][0];
    }
  }
}

/// Solves V = A^-1 b, or M^-1 b if blocks are left out. b is overwritten.
template <class System, class B, class OfV>
void solve(const System& w, B& b, OfV& V) noexcept {
  for (std::uint32_t k = 0; k < w.size; ++k) {
    const std::uint32_t u = w.unknown[k];
    SpatialVector& b_k = b[u];
    if (const BlockJoint* joint = w.joint_of(u)) {
      if (joint->has_parent()) b[joint->parent] = b[joint->parent] + moved_wrench(b_k, joint->d);
      b_k.v = along_axes(b_k, *joint);
    }
    w.with_columns(u, [&](auto columns) noexcept {
      constexpr int C = decltype(columns)::value;
      b_k = scaled<C>(solve_lower<C>(w.pivots[k], b_k), w.pivots[k]);
      for (std::uint32_t c = w.first[k]; c < w.first[k + 1]; ++c)
        subtract_product<C>(w.Z[c], b_k, b[w.unknown[w.row[c]]]);
    });
  }
  for (std::uint32_t k = w.size; k-- > 0;) {
    const std::uint32_t u = w.unknown[k];
    SpatialVector& V_k = V[u];
    w.with_columns(u, [&](auto columns) noexcept {
      constexpr int C = decltype(columns)::value;
      SpatialVector sum = SpatialVector::zero();
      for (std::uint32_t c = w.first[k]; c < w.first[k + 1]; ++c)
        add_product_transposed<C>(w.Z[c], V[w.unknown[w.row[c]]], sum);
      V_k = solve_upper<C>(w.pivots[k], b[u] - scaled<C>(sum, w.pivots[k]));
    });
    if (const BlockJoint* joint = w.joint_of(u)) {
      V_k = moved_along(*joint, V_k.v);
      if (joint->has_parent()) V_k = V_k + shifted(V[joint->parent], joint->d);
    }
  }
}

/// True if the system is a single body, which is solved by 3 x 3 blocks: two divisions in a row instead of
/// six.
template <class System>
bool is_single_body(const System& w) noexcept {
  const std::uint32_t u = w.unknown[0];
  return w.size == 1 && w.joint_of(u) == nullptr;
}

/// Solves V = A^-1 b of a system that factorize_and_solve() has solved. b is overwritten.
template <class System, class Vector>
void solve_again(const System& w, Vector& b, Vector& V) noexcept {
  if (is_single_body(w)) {
    const SymmetricSpatialMatrix& A = w.A_kk[0];
    const std::uint32_t u = w.unknown[0];
    V[u] = solved({.ww = A.ww, .wv = A.wv, .vw = transposed(A.wv), .vv = A.vv}, b[u]);
  } else {
    solve(w, b, V);
  }
}

/// Factors and solves V = A^-1 b of a loaded system. b is overwritten.
template <class System, class Vector>
void factorize_and_solve(System& w, Vector& b, Vector& V) noexcept {
  if (!is_single_body(w)) factorize(w);
  solve_again(w, b, V);
}

}  // namespace godobject
