// Terms of a scene (core/term) in a stage: linearisation, and loading into the systems of the islands.
#pragma once

#include "core/solve/line_search.h"

namespace godobject {

/// Makes the bodies of a joint one tool.
template <class Contacts, std::size_t N>
void join_tools(const TermEnds& ends, BodyContactScratch<Contacts, N>& w) noexcept {
  if (ends.size < 2) return;
  const std::uint32_t kept = w.finder.owned[ends.list[0]].tree, joined = w.finder.owned[ends.list[1]].tree;
  for (auto& owned : w.finder.owned)
    if (owned.tree == joined) owned.tree = kept;
}

/// Linearises the terms at the predicted end of the stage, for velocities relative to V_p of jointed bodies,
/// and adds the graph's edges. forces: of the terms in the previous solve. coordinate(i, c): coordinate c of
/// the joint of body i at the predicted end.
template <class Contacts, std::size_t N, std::size_t max, class CoordinateOf>
void begin_terms(const typename Contacts::Terms::Params& par, const TermForces<max>& forces, Real h,
                 const CoordinateOf& coordinate, BodyContactScratch<Contacts, N>& w) noexcept {
  const TermStage<decltype(w.finder.at), decltype(w.stages), CoordinateOf> in{w.finder.at, w.stages,
                                                                              coordinate, h};
  w.graph.num_terms = 0;
  Contacts::Terms::each_kind(par, w.terms, [&](auto kind, const auto& terms, auto& stages) noexcept {
    stages.size = terms.size;
    for (std::size_t t = 0; t < terms.size; ++t) {
      auto& stage = stages.list[t];
      kind.begin(terms.list[t], in, forces.list[w.graph.num_terms], stage);
      kind.each_force(stage, [&](std::uint32_t u, const Column& r, const Column& F) noexcept {
        Column w_W(w.finder.at[u].V.w);
        if constexpr (Contacts::jointed) w_W -= w.graph.joints.V_p[u].w;
        const Block K = block_of(lever_stiffness<Real>(r.vec(), h * h * F.vec()));
        w.stages[u].A_ww += K;
        w.stages[u].b.w += K * w_W;
      });
      if constexpr (Contacts::jointed) kind.shift(w.graph.joints.V_p, stage);
      if constexpr (kind.is_joint) join_tools(kind.ends(stage), w);
      w.graph.terms[w.graph.num_terms++] = {kind.ends(stage)};
    }
  });
}

/// Calls f(kind, number among all terms, edge, stage) for the terms of an island.
template <class Contacts, std::size_t N, class F>
void each_term(const Island& island, BodyContactScratch<Contacts, N>& w, F f) noexcept {
  if constexpr (Contacts::max_terms > 0) {
    if (!island.has_terms) return;
    const auto number = static_cast<std::uint32_t>(&island - w.graph.islands.data());
    Contacts::Terms::each(w.terms, [&](auto kind, std::uint32_t t, auto& stage) noexcept {
      if (w.graph.terms[t].island == number) f(kind, t, w.graph.terms[t], stage);
    });
  }
}

/// Declares the couplings of an island's terms.
template <class Contacts, std::size_t N>
void couple_terms(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  each_term(island, w, [&](auto, std::uint32_t, TermEdge& edge, const auto&) noexcept {
    std::size_t k = 0;
    edge.each_pair([&](std::uint32_t a, std::uint32_t b) noexcept {
      edge.entries[k++] = w.system.couple(edge.list[a], edge.list[b]);
    });
  });
}

template <class Contacts, std::size_t N>
void load_terms(const Island& island, BodyContactScratch<Contacts, N>& w) noexcept {
  each_term(island, w, [&](auto kind, std::uint32_t, const TermEdge& edge, const auto& stage) noexcept {
    kind.load(stage, edge.entries, w.system);
  });
}

/// Calls f(u, impulse on u about its centre of mass) for all terms at the solved velocities.
template <class Contacts, std::size_t N, class F>
void each_term_impulse(BodyContactScratch<Contacts, N>& w, F f) noexcept {
  if constexpr (Contacts::max_terms > 0)
    Contacts::Terms::each(w.terms, [&](auto kind, std::uint32_t, const auto& stage) noexcept {
      kind.each_impulse(w.x.V, stage, f);
    });
}

/// Computes the forces of all terms at the solved velocities.
template <class Contacts, std::size_t N, std::size_t max>
void end_terms(Real h, BodyContactScratch<Contacts, N>& w, TermForces<max>& forces) noexcept {
  Contacts::Terms::each(w.terms, [&](auto kind, std::uint32_t t, const auto& stage) noexcept {
    const SpatialVector F = kind.force(w.x.V, stage) * (1 / h);
    forces.list[t] = {.tau = F.w.vec(), .f = F.v.vec()};
  });
}

}  // namespace godobject
