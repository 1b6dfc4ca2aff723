// A stage of nets: where it begins, and its solution with the bodies that carry and touch them.
#pragma once

#include "core/contact/bodies.h"
#include "core/net/contacts.h"

namespace godobject {

/// Anchors and springs where the stage is predicted to end. The bodies are in w.finder.at.
template <class Contacts, std::size_t N, class Bases>
void begin_net(const NetInput<typename Contacts::Net>& in, const Bases& bases, Real h,
               BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  index_net<typename Contacts::Net>(in.par, net);
  for (std::size_t k = 0; k < net.num_runs; ++k) {
    const NetRun& run = net.runs[k];
    begin_anchors<typename Contacts::Net>(in.par, run, run.body == world ? TreePlace{} : w.finder.at[run.body], bases,
                                          in.gravity_W, h, net);
  }
  begin_springs<typename Contacts::Net>(in.par, h, net);
  sum_prestress(net);
  std::copy_n(net.v.begin(), net.num_nodes, w.x.V_0.nodes.begin());
  std::copy_n(net.v.begin(), net.num_nodes, w.x.V.nodes.begin());
}

template <class Contacts, std::size_t N>
void find_net_contacts(const typename Contacts::Params& par, const NetInput<typename Contacts::Net>& in,
                       std::size_t num_bodies, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  NetFinder<Contacts, N, typename Contacts::Net>(par, in.par, h, w.finder, w.net).find(num_bodies);
}

/// The velocities of nodes and of the bodies that carry and touch them.
template <class Contacts, std::size_t N>
void solve_net(Real h, const NetInput<typename Contacts::Net>& in, BodyContactScratch<Contacts, N>& w) noexcept {
  if (w.net.num_nodes == 0) return;
  if constexpr (Contacts::jointed) shift_net(w.graph.joints.V_p, h, w.net);
  using Scratch = BodyContactScratch<Contacts, N>;
  typename Scratch::OfNet::Coupled system{w.system, w.net, w.coupled_b};
  const Solving how{.is_coupled = true,
                    .has_contacts = w.net.near.size > 0 || w.near.size > 0,
                    .most_iterations = in.par.max_iterations,
                    .tolerance = in.par.tolerance};
  for (std::size_t n = 0; n < w.graph.num_islands; ++n)
    if (w.graph.islands[n].has_net) return solve_island(h, w.graph.islands[n], how, system, w);
  Island alone;  // no body carries or touches the nodes
  alone.has_net = true;
  solve_island(h, alone, how, system, w);
}

}  // namespace godobject
