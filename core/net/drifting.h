// Nets of the world that touch each other, or themselves, and nothing else. Their common momentum is
// conserved: (45) corrects their translation as one, and (48) their rotation. Rotated as one they exert
// forces, because friction acts at nodes that are as far apart as the nets are thick.
#pragma once

#include "core/net/faces.h"
#include "core/net/scratch.h"

namespace godobject {

/// Finds the drifting nets that active contacts join, of those that near ones do.
template <class Net, std::size_t N>
void group_by_terms(NetStage<Net, N>& w) noexcept {
  auto& faces = w.faces;
  if (faces.num_drifting == 0) return;
  faces.active_group.separate(w.par->num_rows);
  for (const NetContactTerm& contact : w.terms()) {
    if (!contact.is_on_face()) continue;
    const std::size_t a = row_of_node(*w.par, contact.node), b = row_of_node(*w.par, contact.face.nodes[0]);
    if (a < w.par->num_rows && b < w.par->num_rows) faces.active_group.join(a, b, w.par->num_rows);
  }
}

/// Calls f(node, its group) for the nodes of drifting nets.
template <class Net, std::size_t N, class Groups, class F>
void each_drifting(const NetStage<Net, N>& w, const Groups& groups, F f) noexcept {
  if (w.faces.num_drifting == 0) return;
  for (std::size_t k = 0; k < w.par->num_rows; ++k)
    if (w.faces.drifts[k])
      for (std::uint32_t n = w.par->rows[k].first; n < w.par->rows[k].end; ++n) f(n, groups.of[k]);
}

/// Computes the velocities of drifting nets as a whole that the impulses J(node) give them.
template <class Net, std::size_t N, class Groups, class Impulse>
void set_drifts(NetStage<Net, N>& w, const Groups& groups, Impulse J) noexcept {
  auto& faces = w.faces;
  if (faces.num_drifting == 0) return;
  for (std::uint32_t k = 0; k < w.par->num_rows; ++k) {
    faces.mass[k] = 0;
    faces.sum[k] = Column(Pack(0));
  }
  each_drifting(w, groups, [&](std::uint32_t n, std::uint32_t group) noexcept {
    faces.mass[group] += w.m[n];
    faces.sum[group] += J(n);
  });
  for (std::uint32_t n = 0; n < w.num_nodes; ++n) faces.drift[n] = Column(Pack(0));
  each_drifting(w, groups, [&](std::uint32_t n, std::uint32_t group) noexcept {
    faces.drift[n] = faces.sum[group] * (1 / faces.mass[group]);
  });
}

}  // namespace godobject
