// Groups of four nodes of nets, in the elimination order of the factor (43), formed before the first step.
//
// Nodes of a group must not be joined by springs, and each waits for earlier joined ones. In the order of
// their numbers almost every node waits for the previous one. The nodes of a carrier are therefore divided
// into strips in the order of their numbers, and taken from each strip in turn. Four consecutive nodes are
// then seldom joined, and neither are the next four, so that a processor works on both groups. The quality of
// the factor hardly depends on it (docs/decisions/059).
#pragma once

#include <algorithm>

#include "core/net/net.h"
#include "core/tuning.h"

namespace godobject {

/// Springs of each node that has(spring, node) accepts for one of its two nodes.
template <class Par>
struct SpringsOfNodes;
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
struct SpringsOfNodes<NetParams<max_nodes, max_springs, max_attachments, max_faces>> {
  // springs of node n: list[first[n]] to list[first[n + 1] - 1]
  std::array<std::uint32_t, max_nodes + 1> first{};
  std::array<std::uint32_t, 2 * max_springs> list{};

  template <class Has>
  SpringsOfNodes(const NetParams<max_nodes, max_springs, max_attachments, max_faces>& par, Has has) noexcept {
    const auto each = [&](auto f) {
      for (std::uint32_t s = 0; s < par.num_springs; ++s)
        for (const std::uint32_t n : {par.springs[s].i, par.springs[s].j})
          if (has(par.springs[s], n)) f(n, s);
    };
    each([&](std::uint32_t n, std::uint32_t) { ++first[n + 1]; });
    for (std::size_t n = 0; n < par.num_nodes; ++n) first[n + 1] += first[n];
    auto next = first;
    each([&](std::uint32_t n, std::uint32_t s) { list[next[n]++] = s; });
  }
  std::uint32_t num(std::uint32_t n) const noexcept { return first[n + 1] - first[n]; }
};

/// Returns the node that a spring joins to n.
inline std::uint32_t other_end(const NetSpring& spring, std::uint32_t n) noexcept {
  return spring.i == n ? spring.j : spring.i;
}

/// Assigns nodes to groups. Springs must join existing nodes.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
class NodeGrouping {
 public:
  using Par = NetParams<max_nodes, max_springs, max_attachments, max_faces>;
  explicit NodeGrouping(Par& par) noexcept
      : par_(par), springs_(par, [](const NetSpring&, std::uint32_t) { return true; }) {}

  void put_in_groups() noexcept {
    par_.num_groups = 0;
    for (std::uint32_t n = 0; n < par_.num_nodes; ++n) left_[n] = springs_.num(n);
    for (std::uint32_t first = 0, end = 0; first < par_.num_nodes; first = end) {
      while (end < par_.num_nodes && par_.nodes[end].body == par_.nodes[first].body) ++end;
      const std::size_t num_ends = order_from_ends(first, end), size = order_in_strips(first, end, num_ends);
      group(0, num_ends, true);
      group(num_ends, size, false);
    }
  }

 private:
  static constexpr std::uint32_t taken = max_nodes;

  template <class F>
  void each_neighbour(std::uint32_t n, F f) const noexcept {
    for (std::uint32_t k = springs_.first[n]; k < springs_.first[n + 1]; ++k)
      f(other_end(par_.springs[springs_.list[k]], n));
  }

  /// Orders the nodes of [first, end) with at most one neighbour, repeatedly: threads and trees from their
  /// ends. The factor is exact for those. Returns their number.
  std::size_t order_from_ends(std::uint32_t first, std::uint32_t end) noexcept {
    std::size_t size = 0;
    const auto wait = [&](std::uint32_t n) noexcept {
      is_ordered_[n] = true;
      ordered_[size++] = n;
    };
    for (std::uint32_t n = first; n < end; ++n)
      if (left_[n] <= 1) wait(n);
    for (std::size_t k = 0; k < size; ++k)
      each_neighbour(ordered_[k], [&](std::uint32_t n) noexcept {
        --left_[n];
        if (first <= n && n < end && left_[n] <= 1 && !is_ordered_[n]) wait(n);
      });
    return size;
  }

  /// Orders the other nodes, from each strip in turn. Returns the number of ordered nodes.
  std::size_t order_in_strips(std::uint32_t first, std::uint32_t end, std::size_t num_ends) noexcept {
    std::size_t size = 0;
    for (std::uint32_t n = first; n < end; ++n)
      if (!is_ordered_[n]) in_order_[size++] = n;
    const std::size_t length = (size + node_strips - 1) / node_strips;
    std::size_t all = num_ends;
    for (std::size_t k = 0; k < length; ++k)
      for (std::size_t of = k; of < size; of += length) ordered_[all++] = in_order_[of];
    return all;
  }

  bool joins(std::uint32_t n, const NodeGroup& group) const noexcept {
    bool found = false;
    each_neighbour(n, [&](std::uint32_t other) noexcept {
      for (std::uint32_t j = 0; j < group.size; ++j) found = found || group.nodes[j] == other;
    });
    return found;
  }

  /// Groups the ordered nodes at [from, end): in their order, or each in the first group with room.
  void group(std::size_t from, std::size_t end, bool in_order) noexcept {
    for (; from < end; ++from) {
      if (ordered_[from] == taken) continue;
      const auto number = static_cast<std::uint32_t>(par_.num_groups);
      NodeGroup& group = par_.groups[par_.num_groups++] = {};
      for (std::size_t k = from; k < std::min(end, from + nodes_looked_ahead) && group.size < 4; ++k) {
        const std::uint32_t n = ordered_[k];
        if (n == taken) continue;
        if (joins(n, group)) {
          if (in_order) break;
          continue;
        }
        par_.places[n] = {.group = number, .lane = group.size};
        group.nodes[group.size++] = n;
        ordered_[k] = taken;
      }
      std::fill(group.nodes.begin() + group.size, group.nodes.end(), group.nodes[0]);
    }
  }

  Par& par_;
  SpringsOfNodes<Par> springs_;
  std::array<std::uint32_t, max_nodes> left_{};  // neighbours that do not wait
  std::array<std::uint32_t, max_nodes> ordered_{}, in_order_{};
  std::array<bool, max_nodes> is_ordered_{};
};

/// Assigns the springs to slots of each group: those to nodes of later groups.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
void assign_slots(NetParams<max_nodes, max_springs, max_attachments, max_faces>& par) noexcept {
  const SpringsOfNodes<NetParams<max_nodes, max_springs, max_attachments, max_faces>> own(
      par, [&](const NetSpring& spring, std::uint32_t n) {
        return par.places[n].group < par.places[other_end(spring, n)].group;
      });
  std::uint32_t num_slots = 0;
  for (std::size_t g = 0; g < par.num_groups; ++g) {
    NodeGroup& group = par.groups[g];
    std::uint32_t most = 0;
    for (const std::uint32_t n : group.nodes) most = std::max(most, own.num(n));
    group.first = num_slots;
    group.end = num_slots += most;
    for (std::uint32_t k = 0; k < most; ++k) {
      SpringSlot& slot = par.slots[group.first + k];
      for (std::uint32_t j = 0; j < 4; ++j) {
        const std::uint32_t n = group.nodes[j];
        const bool has_one = j < group.size && k < own.num(n);
        slot.springs[j] = has_one ? own.list[own.first[n] + k] : par.no_spring;
        slot.others[j] = has_one ? other_end(par.springs[slot.springs[j]], n) : n;
      }
    }
  }
}

/// True if every node is in one group of its carrier, and every spring in one slot of the group of its
/// earlier node.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
bool are_valid_groups(const NetParams<max_nodes, max_springs, max_attachments, max_faces>& par) noexcept {
  const NetSpring& none = par.springs[par.no_spring];
  if (par.num_groups > par.num_nodes || none.k != 0 || none.g != 0) return false;
  std::size_t num_placed = 0, num_held = 0;
  std::uint32_t num_slots = 0;
  std::array<bool, max_springs + 1> is_held{};
  for (std::uint32_t g = 0; g < par.num_groups; ++g) {
    const NodeGroup& group = par.groups[g];
    if (group.size < 1 || group.size > 4 || group.first != num_slots || group.end < group.first ||
        group.end > max_springs)
      return false;
    num_slots = group.end;
    num_placed += group.size;
    for (std::uint32_t j = 0; j < 4; ++j) {
      const std::uint32_t n = group.nodes[j];
      if (n >= par.num_nodes || par.nodes[n].body != par.nodes[group.nodes[0]].body) return false;
      const NodePlace& place = par.places[n];
      if (place.group != g || place.lane != (j < group.size ? j : 0)) return false;
      for (std::uint32_t k = group.first; k < group.end; ++k) {
        const std::uint32_t s = par.slots[k].springs[j], other = par.slots[k].others[j];
        if (s == par.no_spring && other == n) continue;
        if (j >= group.size || s >= par.num_springs || is_held[s] || other >= par.num_nodes) return false;
        const NetSpring& spring = par.springs[s];
        if (std::min(n, other) != spring.i || std::max(n, other) != spring.j || par.places[other].group <= g)
          return false;
        is_held[s] = true;
        ++num_held;
      }
    }
  }
  return num_placed == par.num_nodes && num_held == par.num_springs;
}

}  // namespace godobject
