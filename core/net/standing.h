// Nets without anchors that nothing but the world acts on. (45) corrects their translation as one, as that of
// a carrier with its net. A net that slides as a whole is then accelerated exactly. The force that drives it
// near the threshold of friction may be far below the tolerance of the iteration.
#pragma once

#include "core/net/faces.h"
#include "core/net/incomplete_factor.h"

namespace godobject {

/// Finds the standing nets, after the contacts are gathered, and E of (44) of their translation: nodes and
/// contacts. Springs do not resist it.
template <class Net, std::size_t N>
void find_standing(NetStage<Net, N>& w) noexcept {
  const auto& par = *w.par;
  bool is_none = true;
  for (std::size_t k = 0; k < par.num_rows; ++k) {
    RowStage& of = w.rows[k];
    of.stands = of.is_free && !of.flies;
    if constexpr (Net::max_faces > 0)
      of.stands = of.stands && !(w.faces.num_drifting > 0 && w.faces.drifts[k]);
    if (!of.stands) continue;
    is_none = false;
    Real m = 0;
    for (std::uint32_t n = par.rows[k].first; n < par.rows[k].end; ++n) m += w.m[n];
    of.E = Block::identity() * m;
  }
  if (is_none) return;
  const auto stop = [&](std::uint32_t n, Real) noexcept {
    const std::size_t k = row_of_node(par, n);
    if (k < par.num_rows) w.rows[k].stands = false;
  };
  for (const NetContactTerm& contact : w.terms()) {
    if (contact.body != NetContactTerm::on_world) {
      each_node_of(contact, stop);
      continue;
    }
    const std::size_t k = row_of_node(par, contact.node);
    if (k == par.num_rows || !w.rows[k].stands) continue;
    w.rows[k].E += Block::identity() * contact.a + outer(contact.n * contact.b, contact.n);
  }
  for (std::size_t k = 0; k < par.num_rows; ++k) {
    if (!w.rows[k].stands) continue;
    Mat3 A;
    for (Eigen::Index j = 0; j < 3; ++j) A.col(j) = w.rows[k].E.col[static_cast<std::size_t>(j)].vec();
    w.rows[k].E_inverse = block_of(Mat3(A.inverse()));
  }
}

/// Calls f(net, data of it) for every net whose motion as one (45) corrects: standing and flying ones.
template <class Stage, class F>
void each_corrected(Stage& w, F f) noexcept {
  for (std::size_t k = 0; k < w.par->num_rows; ++k)
    if (w.rows[k].stands || (w.rows[k].floats && w.rows[k].flies)) f(w.par->rows[k], w.rows[k]);
}

/// Returns the velocity of a standing net that the impulses J(node) give it as a whole, with its contacts.
template <class Impulse>
SpatialVector common_motion(const NodeRow& nodes, const RowStage& of, Impulse J) noexcept {
  Column sum(Pack(0));
  for (std::uint32_t n = nodes.first; n < nodes.end; ++n) sum += J(n);
  return {.w = Column(Pack(0)), .v = of.E_inverse * sum};
}

}  // namespace godobject
