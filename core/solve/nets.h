// Stage of nets: initialisation, and solution with the bodies that carry and touch them.
#pragma once

#include "core/solve/bodies.h"
#include "core/solve/net_contacts.h"

namespace godobject {

/// Linearises anchors, attachments and springs at the predicted nodes. The bodies are in w.finder.at.
template <Springs as = Springs::linear, class Contacts, std::size_t N>
void linearise_net(const NetInput<typename Contacts::Net>& in, Real h,
                   BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  for (std::size_t k = 0; k < net.num_runs; ++k) {
    const NetRun& run = net.runs[k];
    begin_anchors<typename Contacts::Net>(in.par, run,
                                          run.body == world ? TreePlace{} : w.finder.at[run.body], h, net);
  }
  begin_preconditioner<typename Contacts::Net>(in.par, h, net);
  begin_attachments<typename Contacts::Net>(in.par, w.finder.at, h, net);
  begin_springs<as, typename Contacts::Net>(in.par, h, net);
}

/// Begins the nets at the predicted end of the stage.
template <class Contacts, std::size_t N, class Bases>
void begin_net(const NetInput<typename Contacts::Net>& in, const Bases& bases, Real h,
               BodyContactScratch<Contacts, N>& w) noexcept {
  if (!w.stage.continues_step) index_net<typename Contacts::Net>(in.par, w.net);
  predict_nodes(bases, in.gravity_W, h, w.net);
  linearise_net(in, h, w);
}

template <class Contacts, std::size_t N>
void find_net_contacts(const typename Contacts::Params& par, const NetInput<typename Contacts::Net>& in,
                       std::size_t num_bodies, BodyContactScratch<Contacts, N>& w) noexcept {
  NetFinder<Contacts, N, typename Contacts::Net>(par, in.par, w.finder, w.net).find(num_bodies);
}

/// Solves for the velocities of nodes, and of the bodies that carry, touch or are attached to them.
template <class Contacts, std::size_t N>
void solve_linearised_net(Real h, const NetInput<typename Contacts::Net>& in,
                          BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::jointed) {
    shift_anchors(w.graph.joints.V_p, w.net);
    shift_attachments(w.graph.joints.V_p, w.net);
  }
  to_carrier_frame(w.net, w.x.V_0);
  find_flying(w.net);
  if constexpr (Contacts::Net::max_faces > 0) find_drifting<Contacts>(w.stage.continues_step, w.net);
  using Scratch = BodyContactScratch<Contacts, N>;
  typename Scratch::OfNet::Coupled system{w.system, w.net, w.coupled_b};
  const SolverLimits how{.has_contacts = w.net.near.size > 0 || w.near.size > 0,
                         .iteration_limit = in.par.max_iterations,
                         .tolerance = in.par.tolerated_change(h)};
  const auto solve = [&]() noexcept {
    for (std::size_t n = 0; n < w.graph.num_islands; ++n)
      if (w.graph.islands[n].has_net) return solve_island(h, w.graph.islands[n], how, system, w);
    Island alone;  // no body carries or touches the nodes
    alone.has_net = true;
    solve_island(h, alone, how, system, w);
  };
  solve();
  to_world_frame(w.net, w.x.V);
}

/// Solves the stage again with majorised springs (47), from its start, at rest.
template <class Contacts, std::size_t N>
void solve_majorised(Real h, const NetInput<typename Contacts::Net>& in,
                     BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  net.factored_h = 0;
  rest_at_start(h, net);
  linearise_net<Springs::majorised>(in, h, w);
  std::copy_n(net.v.begin(), net.num_nodes, w.x.V_0.nodes.begin());
  solve_linearised_net(h, in, w);
  net.factored_h = 0;
  net.report.majorised = true;
}

/// Solves for the velocities of nodes and of the bodies that carry and touch them. Springs are linear at the
/// predicted end of the stage. If they gain energy that way (46), they are majorised.
template <class Contacts, std::size_t N>
void solve_net(Real h, const NetInput<typename Contacts::Net>& in,
               BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  const NetReport stages_before = w.stage.continues_step ? net.report : NetReport{};
  net.report = {};
  if (net.num_nodes == 0) return;
  if constexpr (Contacts::jointed) shift_net_contacts(w.graph.joints.V_p, h, net);
  net.begins_at_solution = Contacts::jointed && in.again;
  const auto& begin = net.begins_at_solution ? w.x.V.nodes : net.v;
  std::copy_n(begin.begin(), net.num_nodes, w.x.V_0.nodes.begin());
  solve_linearised_net(h, in, w);
  if (spring_gain<typename Contacts::Net>(in.par, w.x.V.nodes, in.gravity_W, h, net)
          .exceeds_tolerance(in.par.tolerated_change(h)))
    solve_majorised(h, in, w);
  net.report.cover(stages_before);
}

}  // namespace godobject
