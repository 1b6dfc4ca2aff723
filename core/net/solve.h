// A stage of nets: where it begins, and its solution with the bodies that carry and touch them.
#pragma once

#include "core/contact/bodies.h"
#include "core/net/contacts.h"

namespace godobject {

/// Anchors and springs, linear from where the nodes are led. The bodies are in w.finder.at.
template <class Contacts, std::size_t N>
void linearise_net(const NetInput<typename Contacts::Net>& in, Real h,
                   BodyContactScratch<Contacts, N>& w) noexcept {
  auto& net = w.net;
  for (std::size_t k = 0; k < net.num_runs; ++k) {
    const NetRun& run = net.runs[k];
    begin_anchors<typename Contacts::Net>(in.par, run,
                                          run.body == world ? TreePlace{} : w.finder.at[run.body], h, net);
  }
  begin_springs<typename Contacts::Net>(in.par, h, net);
}

/// The nets where the stage is predicted to end.
template <class Contacts, std::size_t N, class Bases>
void begin_net(const NetInput<typename Contacts::Net>& in, const Bases& bases, Real h,
               BodyContactScratch<Contacts, N>& w) noexcept {
  index_net<typename Contacts::Net>(in.par, w.net);
  predict_nodes(bases, in.gravity_W, h, w.net);
  linearise_net(in, h, w);
}

template <class Contacts, std::size_t N>
void find_net_contacts(const typename Contacts::Params& par, const NetInput<typename Contacts::Net>& in,
                       std::size_t num_bodies, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  NetFinder<Contacts, N, typename Contacts::Net>(par, in.par, h, w.finder, w.net).find(num_bodies);
}

/// The velocities of nodes and of the bodies that carry and touch them.
template <class Contacts, std::size_t N>
void solve_linearised_net(Real h, const NetInput<typename Contacts::Net>& in,
                          BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::jointed) shift_anchors(w.graph.joints.V_p, w.net);
  ride(w.net, w.x.V_0);
  using Scratch = BodyContactScratch<Contacts, N>;
  typename Scratch::OfNet::Coupled system{w.system, w.net, w.coupled_b};
  const Solving how{.is_coupled = true,
                    .has_contacts = w.net.near.size > 0 || w.near.size > 0,
                    .most_iterations = in.par.max_iterations,
                    .tolerance = in.par.tolerance};
  const auto solve = [&]() noexcept {
    for (std::size_t n = 0; n < w.graph.num_islands; ++n)
      if (w.graph.islands[n].has_net) return solve_island(h, w.graph.islands[n], how, system, w);
    Island alone;  // no body carries or touches the nodes
    alone.has_net = true;
    solve_island(h, alone, how, system, w);
  };
  solve();
  get_off(w.net, w.x.V);
}

/// (47)  What the nodes may do against their carriers, which move as solved: with u_0 their velocities before and u after,
/// q where they are if they ride,
///
///   sum m u^2 / 2 + U(q + h u) <= sum m u_0^2 / 2 + U(q) + work of contacts,  U of springs and anchors.
///
/// Springs that were taken again and still do not hold may break that: u is then halved until it holds, and the bodies take
/// over the momenta of what is taken from it.
template <class Contacts, std::size_t N>
class DeformationBound {
 public:
  using Net = typename Contacts::Net;
  DeformationBound(Real h, const NetInput<Net>& in, BodyContactScratch<Contacts, N>& w) noexcept
      : h_(h), par_(in.par), w_(w), net_(w.net) {
    ride(net_, w.x.V);
  }
  void keep() noexcept {
    Real s = 1;
    while (s > 0 && !(energy(s, w_.x.V.nodes) <= most())) s = s > min_share ? s / 2 : 0;
    if (s < 1) take(s);
    get_off(net_, w_.x.V);
  }

 private:
  static constexpr Real min_share = 1. / 64;

  template <class F>
  void each_node(F f) const noexcept {
    for (std::size_t k = 0; k < net_.num_runs; ++k) {
      const NetRun& run = net_.runs[k];
      const bool on_world = run.body == world;
      const TreePlace at = on_world ? TreePlace{} : w_.finder.at[run.body];
      for (std::uint32_t n = run.first; n < run.end; ++n) {
        const Column riding =
            on_world ? Column(Pack(0)) : shifted(w_.x.V[static_cast<std::uint32_t>(run.body)], net_.r[n]).v;
        f(n, riding, at);
      }
    }
  }
  /// With the velocities s u.
  Real energy(Real s, const std::array<Column, Net::max_nodes>& u) noexcept {
    Real E = 0;
    each_node([&](std::uint32_t n, const Column& riding, const TreePlace& at) noexcept {
      const NetNode& node = par_.nodes[n];
      const Column moved = u[n] * (h_ * s), ridden = (riding - net_.v[n]) * h_;
      const Column x = Column(Vec3(net_.r[n].vec() - at.R_WB * node.p_B)) + moved;
      net_.riding_v[n] = net_.p[n] + ridden + moved;
      E += node.m * s * s * dot(u[n], u[n]) + node.k * dot(x, x);
    });
    for (std::size_t k = 0; k < par_.num_springs; ++k) {
      const NetSpring& spring = par_.springs[k];
      const Column x = net_.riding_v[spring.j] - net_.riding_v[spring.i];
      const Real d = std::sqrt(dot(x, x)) - spring.l_0;
      E += spring.k * d * d;
    }
    return E / 2;
  }
  Real most() noexcept {
    if (most_ >= 0) return most_;
    Real E = energy(0, w_.x.V.nodes);
    each_node([&](std::uint32_t n, const Column& riding, const TreePlace&) noexcept {
      const Column u_0 = net_.v_free[n] - riding;
      E += par_.nodes[n].m * dot(u_0, u_0) / 2;
    });
    for (std::size_t i = 0; i < net_.near.size; ++i) {
      const Vec3 F = lane(net_.packs[i / 4].F, i % 4);
      E += std::max(h_ * F.dot(w_.x.V.nodes[net_.near.list[i].a].vec()), Real(0));
    }
    return most_ = E;
  }
  /// Leaves the share s of u.
  void take(Real s) noexcept {
    auto& V = w_.x.V;
    w_.system.each([&](std::uint32_t u) noexcept { w_.x.Ap[u] = SpatialVector::zero(); });
    each_carried(net_, [&](const NetRun& run) noexcept {
      SpatialVector& taken = w_.x.Ap.bodies[run.body];
      for (std::uint32_t n = run.first; n < run.end; ++n)
        taken = taken + moved_wrench({.w = Column(Pack(0)), .v = V.nodes[n] * ((1 - s) * net_.m[n])}, net_.r[n]);
    });
    if (w_.system.size > 0) solve(w_.system, w_.x.Ap.bodies, net_.delta);
    w_.system.each([&](std::uint32_t u) noexcept { V[u] = V[u] + net_.delta[u]; });
    for (std::uint32_t n = 0; n < net_.num_nodes; ++n) V.nodes[n] = V.nodes[n] * s;
    const auto to = [](ContactPack& c, const auto& of) noexcept { move(c, of); };
    if (w_.system.size == 0) each_net_pack(V, net_, to);
    for (std::size_t n = 0; n < w_.graph.num_islands; ++n)
      if (w_.graph.islands[n].has_net) each_pack(V, w_.graph.islands[n], w_, to);
  }

  Real h_, most_ = -1;
  const typename Net::Params& par_;
  BodyContactScratch<Contacts, N>& w_;
  NetStage<Net, N>& net_;
};

/// (46)  The same, with the springs taken where the nodes are led to until they hold.
template <class Contacts, std::size_t N>
void solve_net(Real h, const NetInput<typename Contacts::Net>& in,
               BodyContactScratch<Contacts, N>& w) noexcept {
  using Net = typename Contacts::Net;
  auto& net = w.net;
  net.is_calm = true;
  if (net.num_nodes == 0) return;
  if constexpr (Contacts::jointed) shift_net_contacts(w.graph.joints.V_p, h, net);
  std::copy_n(net.v.begin(), net.num_nodes, w.x.V_0.nodes.begin());
  solve_linearised_net(h, in, w);
  int linearisations = 1;
  for (; linearisations < max_linearisations; ++linearisations) {
    const SpringMiss miss = spring_miss<Net>(in.par, w.x.V.nodes, h, net);
    const Real tolerance_sq =
        in.par.tolerance * in.par.tolerance;  // at rest there is no kinetic energy to compare with
    if (miss.missed <= max_spring_miss * miss.kinetic + miss.mass * tolerance_sq / 2) break;
    // from where they are on their carriers, then from where that leads
    if (net.is_calm) {
      for (std::uint32_t n = 0; n < net.num_nodes; ++n) w.x.V.nodes[n] = Column(Pack(0));
      get_off(net, w.x.V);
    }
    net.is_calm = false;
    lead_nodes(w.x.V.nodes, h, net);
    linearise_net(in, h, w);
    std::copy_n(net.v.begin(), net.num_nodes, w.x.V_0.nodes.begin());
    solve_linearised_net(h, in, w);
  }
  if (!net.is_calm) DeformationBound<Contacts, N>(h, in, w).keep();
  net.report.linearisations = linearisations;
}

}  // namespace godobject
