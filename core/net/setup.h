// Setup of nets before the first step: ordering, checks, placement.
#pragma once

#include <algorithm>

#include "core/math/so3.h"
#include "core/net/faces.h"
#include "core/net/groups.h"

namespace godobject {

/// Orders springs by i < j, then j; attachments by nodes; nodes in groups; and faces in patches. Entries
/// beyond the capacity, or that are no springs, stay in place for is_valid_net() to reject.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
void put_in_order(NetParams<max_nodes, max_springs, max_attachments, max_faces>& par) noexcept {
  if (par.num_nodes > max_nodes || par.num_springs > max_springs) return;
  bool are_springs = true;
  for (std::size_t s = 0; s < par.num_springs; ++s) {
    NetSpring& spring = par.springs[s];
    if (spring.j < spring.i) std::swap(spring.i, spring.j);
    are_springs = are_springs && spring.i < spring.j && spring.j < par.num_nodes;
  }
  std::sort(par.springs.begin(), par.springs.begin() + static_cast<std::ptrdiff_t>(par.num_springs),
            [](const NetSpring& a, const NetSpring& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; });
  if constexpr (max_attachments > 0) {
    auto& list = par.attachments.list;
    std::sort(list.begin(),
              list.begin() + static_cast<std::ptrdiff_t>(std::min(par.attachments.size, max_attachments)),
              [](const NetAttachment& a, const NetAttachment& b) { return a.node < b.node; });
  }
  if (!are_springs) return;
  NodeGrouping(par).put_in_groups();
  assign_slots(par);
  find_rows(par);
  put_faces_in_order(par);
}

/// Finds the rows: sets of nodes that no spring joins to other nodes. A row floats in a stage if its anchors
/// have no stiffness.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
void find_rows(NetParams<max_nodes, max_springs, max_attachments, max_faces>& par) noexcept {
  par.num_rows = 0;
  std::size_t s = 0;
  for (std::uint32_t first = 0, end = 1; first < par.num_nodes; first = end++) {
    for (std::uint32_t n = first; n < end; ++n)
      for (; s < par.num_springs && par.springs[s].i == n; ++s) end = std::max(end, par.springs[s].j + 1);
    if (end > first + 1) par.rows[par.num_rows++] = {.first = first, .end = end};
  }
}

/// True if the nodes of one carrier are consecutive, springs and nodes are in order, and numbers are positive
/// as required. Bodies are below num_bodies.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
bool is_valid_net(const NetParams<max_nodes, max_springs, max_attachments, max_faces>& par,
                  std::size_t num_bodies) noexcept {
  const auto is_number = [](Real a) noexcept { return a >= 0 && a - a == 0; };
  if (par.num_nodes > max_nodes || par.num_springs > max_springs || par.max_iterations < 1) return false;
  if (!is_number(par.tolerance)) return false;
  for (std::size_t n = 0; n < par.num_nodes; ++n) {
    const NetNode& node = par.nodes[n];
    if (node.body != world && node.body >= num_bodies) return false;
    for (std::size_t before = 0; n > 0 && node.body != par.nodes[n - 1].body && before < n; ++before)
      if (par.nodes[before].body == node.body) return false;
    const Real p = node.p_B.sum();
    if (!(node.m > 0) || !is_number(node.m) || !is_number(node.k) || !is_number(node.g) ||
        !is_number(node.radius) || p - p != 0 || node.material >= max_materials)
      return false;
  }
  for (std::size_t s = 0; s < par.num_springs; ++s) {
    const NetSpring& spring = par.springs[s];
    if (spring.i >= spring.j || spring.j >= par.num_nodes) return false;
    if (s > 0 && (spring.i < par.springs[s - 1].i ||
                  (spring.i == par.springs[s - 1].i && spring.j <= par.springs[s - 1].j)))
      return false;
    if (!is_number(spring.k) || !is_number(spring.g) || !is_number(spring.l_0)) return false;
  }
  if (par.num_rows > par.rows.size()) return false;
  for (std::size_t k = 0; k < par.num_rows; ++k)
    if (par.rows[k].first >= par.rows[k].end || par.rows[k].end > par.num_nodes) return false;
  return are_valid_faces(par) && are_valid_groups(par);
}

/// True if attachments are ordered, of nodes below num_nodes, to existing bodies other than the carrier. The
/// net must be valid.
template <std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments, std::size_t max_faces>
bool are_valid_attachments(const NetParams<max_nodes, max_springs, max_attachments, max_faces>& par,
                           std::size_t num_bodies) noexcept {
  if (par.attachments.size > max_attachments) return false;
  const auto is_number = [](Real a) noexcept { return a >= 0 && a - a == 0; };
  std::uint32_t before = 0;
  return std::all_of(par.attachments.begin(), par.attachments.end(), [&](const NetAttachment& one) {
    const bool in_order = one.node >= before;
    before = one.node;
    const Real p = one.p_B.sum();
    return in_order && one.node < par.num_nodes && (one.body == world || one.body < num_bodies) &&
           one.body != par.nodes[one.node].body && p - p == 0 && is_number(one.k) && is_number(one.g);
  });
}

/// Places every node at its anchor, moving with its carrier.
template <class State, std::size_t max_nodes, std::size_t max_springs, std::size_t max_attachments,
          std::size_t max_faces>
void place_net(const NetParams<max_nodes, max_springs, max_attachments, max_faces>& par, State& x) noexcept {
  for (std::size_t n = 0; n < par.num_nodes; ++n) {
    const NetNode& node = par.nodes[n];
    auto& at = x.net.nodes[n];
    at = {};
    at.p_W = node.p_B;
    if (node.body == world) continue;
    const auto& body = x.bodies[node.body].x;
    const Vec3 r = to_world(body.X_WB.q, node.p_B);
    at.p_W = body.X_WB.p + r;
    at.v_W = body.v_W + to_world(body.X_WB.q, body.w_B).cross(r);
  }
}

}  // namespace godobject
