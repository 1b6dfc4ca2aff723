// Elimination order of the unknowns: next is the unknown with the smallest neighbourhood (minimum degree).
// Its neighbours are then joined to each other.
//
// Jointed unknowns follow all their descendants. If blocks are short, those of terms are allocated first, in
// the order of coupling; fill-in gets the remaining ones.
#pragma once

#include <algorithm>

#include "core/system/block_system.h"

namespace godobject {

/// Computes the elimination order of the unknowns, by place. The available blocks are counted.
template <class System>
class BlockOrder {
 public:
  explicit BlockOrder(System& w) noexcept : w_(w) {}

  /// Orders for a complete factor. Returns false, without an order, if the fill-in exceeds the free blocks.
  bool find_complete() noexcept {
    if (!find_neighbours(w_.max_unknowns * w_.max_unknowns)) return false;
    std::size_t used = 0;
    return eliminate([&](std::uint32_t next) noexcept {
      used += w_.neighbours[next].size(w_.size);
      if (used > w_.room) return false;
      w_.neighbours[next].each(w_.size, [&](std::uint32_t i) noexcept {
        typename System::Set& of_i = w_.neighbours[i];
        of_i.insert(w_.neighbours[next], w_.size);
        of_i.erase(i);
        remove_neighbour(next, i);
      });
      return true;
    });
  }

  /// Orders for an incomplete factor, within the available blocks.
  void find_incomplete() noexcept {
    find_neighbours(w_.room);
    static_cast<void>(eliminate([&](std::uint32_t next) noexcept {
      const typename System::Set& all = w_.neighbours[next];
      all.each(w_.size, [&](std::uint32_t i) noexcept {
        all.each(w_.size, [&](std::uint32_t j) noexcept {
          if (j <= i || used_ == w_.room || w_.neighbours[i].contains(j)) return;
          join(i, j);
        });
      });
      all.each(w_.size, [&](std::uint32_t i) noexcept { remove_neighbour(next, i); });
      return true;
    }));
  }

 private:
  static constexpr std::uint32_t not_ready = 0xfffe, eliminated = 0xffff;

  void join(std::uint32_t i, std::uint32_t j) noexcept {
    w_.neighbours[i].insert(j);
    w_.neighbours[j].insert(i);
    ++used_;
  }
  /// Removes `next` from the neighbours of i after its elimination.
  void remove_neighbour(std::uint32_t next, std::uint32_t i) noexcept {
    w_.neighbours[i].erase(next);
    w_.degree[i] = degree_of(i);
  }
  /// Returns the number of neighbours of an unknown.
  std::uint32_t degree_of(std::uint32_t i) const noexcept {
    if constexpr (System::jointed) {
      if (w_.remaining_children[i] > 0) return not_ready;
    }
    return w_.neighbours[i].size(w_.size);
  }

  /// Collects the neighbours coupled by terms and joints; of terms only those with room.
  bool find_neighbours(std::size_t room) noexcept {
    used_ = 0;
    for (std::uint32_t i = 0; i < w_.size; ++i) {
      w_.neighbours[i] = {};
      if constexpr (System::jointed) w_.remaining_children[i] = 0;
    }
    if constexpr (System::jointed) {
      for (std::uint32_t i = 0; i < w_.size; ++i) {
        const BlockJoint& joint = w_.joints[w_.unknown[i]];
        if (!joint.has_parent()) continue;
        ++w_.remaining_children[w_.number_of[joint.parent]];
        join(i, w_.number_of[joint.parent]);
      }
    }
    bool all = true;
    for (std::uint32_t e = 0; e < w_.num_entries; ++e) {
      BlockEntry& entry = w_.entries[e];
      const std::uint32_t i = w_.number_of[entry.i], j = w_.number_of[entry.j];
      entry.slot = 0;
      if (w_.neighbours[i].contains(j)) continue;
      if (used_ < room) join(i, j);
      else entry.slot = no_slot;
      all = all && entry.slot != no_slot;
    }
    for (std::uint32_t i = 0; i < w_.size; ++i) w_.degree[i] = degree_of(i);
    return all;
  }

  template <class Eliminate>
  bool eliminate(Eliminate join_neighbours) noexcept {
    for (std::uint32_t k = 0; k < w_.size; ++k) {
      std::uint32_t least = ~std::uint32_t(0);  // degree, then place: one number, compared without branches
      for (std::uint32_t i = 0; i < w_.size; ++i) least = std::min(least, w_.degree[i] << 16 | i);
      const std::uint32_t next = least & 0xffff;
      w_.degree[next] = eliminated;
      w_.order[k] = next;
      if constexpr (System::jointed) {
        const BlockJoint& joint = w_.joints[w_.unknown[next]];
        if (joint.has_parent()) --w_.remaining_children[w_.number_of[joint.parent]];
      }
      if (!join_neighbours(next)) return false;
    }
    return true;
  }

  System& w_;
  std::size_t used_ = 0;
};

/// Returns the block of row i among [b, end) of a column, or end.
template <class System>
std::uint32_t find_row(const System& w, std::uint32_t i, std::uint32_t b, std::uint32_t end) noexcept {
  while (b < end && w.row[b] < i) ++b;
  return b < end && w.row[b] == i ? b : end;
}

/// Numbers the unknowns and assigns a slot to every block.
template <class System>
void order(System& w) noexcept {
  BlockOrder<System> find(w);
  w.is_complete = find.find_complete();
  if (!w.is_complete) find.find_incomplete();

  for (std::uint32_t k = 0; k < w.size; ++k) w.degree[w.order[k]] = k;  // elimination number of each place
  std::uint32_t b = 0;
  for (std::uint32_t k = 0; k < w.size; ++k) {
    w.first[k] = b;
    w.neighbours[w.order[k]].each(w.size,
                                  [&](std::uint32_t place) noexcept { w.row[b++] = w.degree[place]; });
    std::sort(w.row.begin() + w.first[k], w.row.begin() + b);
  }
  w.first[w.size] = b;
  for (std::uint32_t s = 0; s < b; ++s) w.is_fill[s] = true;
  for (std::uint32_t k = 0; k < w.size; ++k) w.order[k] = w.unknown[w.order[k]];
  for (std::uint32_t k = 0; k < w.size; ++k) {
    w.unknown[k] = w.order[k];
    w.number_of[w.unknown[k]] = k;
  }
  for (std::uint32_t e = 0; e < w.num_entries; ++e) {
    BlockEntry& entry = w.entries[e];
    if (entry.slot == no_slot) continue;
    const auto [low, high] = std::minmax(w.number_of[entry.i], w.number_of[entry.j]);
    entry.slot = find_row(w, high, w.first[low], w.first[low + 1]);
    w.is_fill[entry.slot] = false;
  }
}

}  // namespace godobject
