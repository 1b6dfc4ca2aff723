// Bodies in contact with each other or the world in a stage, in pairs, with their contacts (24).
#pragma once

#include "core/contact/find/find.h"
#include "core/contact/forces.h"
#include "core/contact/stage.h"
#include "core/net/coupled_system.h"
#include "core/solve/islands.h"
#include "core/system/conjugate_gradients.h"

namespace godobject {

/// Contact part of a scene whose bodies touch the world alone. Capacities: spheres, surfaces, contacts at a
/// time.
template <std::size_t spheres_, std::size_t surfaces_, std::size_t contacts_>
struct FixedContacts {
  static constexpr std::size_t max_contacts = contacts_, max_pairs = 0, max_blocks = 0;
  static constexpr bool between_bodies = false;
  static constexpr bool jointed = false;                             // OnJoints
  static constexpr std::size_t max_terms = 0, max_term_entries = 0;  // WithTerms
  using TermStages = Absent<19>;
  static constexpr bool has_net = false;  // WithNet
  static constexpr std::size_t max_net_packs = 0;
  template <std::size_t>
  static constexpr std::size_t max_net_pairs = 0;
  using Params = ContactParams<spheres_, surfaces_>;
  using State = ContactMemories<contacts_>;
  using Output = ContactReport;
  using BodyOutput = ContactWrench;
};

/// Contact part of a scene whose bodies also touch each other. blocks: capacity of the system's factor beside
/// its diagonal (31); 0: eight for each body.
template <std::size_t spheres_, std::size_t surfaces_, std::size_t contacts_, std::size_t blocks_ = 0>
struct BodyContacts : FixedContacts<spheres_, surfaces_, contacts_> {
  static constexpr std::size_t max_pairs = contacts_, max_blocks = blocks_;
  static constexpr bool between_bodies = true;
};

/// Contact part of a scene with terms.
template <class Contacts, class Terms_>
struct WithTerms : Contacts {
  using Terms = Terms_;
  static constexpr std::size_t max_terms = Terms::max_terms, max_term_entries = Terms::max_entries;
  using TermStages = typename Terms::Stages;
};

/// Contact part of a scene with a net.
template <class Contacts, class Net_>
struct WithNet : Contacts {
  using Net = Net_;
  static constexpr bool has_net = true;
  static constexpr std::size_t max_net_packs = NetStage<Net, 1>::max_packs;
  template <std::size_t N>  // bodies
  static constexpr std::size_t max_net_pairs = NetStage<Net, N>::max_pairs;
};

/// Stage of a body, about its centre of mass, world axes. Its A has a skew part (11), which a symmetric
/// solver cannot represent. Without contacts or joints the body moves by the whole A. Otherwise the
/// gyroscopic skew part S acts at the torque-free motion, and those of torques are left out. They do no work
/// on w+, but would if they acted on a free motion that contacts or joints prevent.
///
///   (34)  A_ww = (A + A^T) / 2,  b_w = b - S w_free
struct BodyStage {
  Block A_ww;
  Real M = 0;  // kg, with a coupling's share
  SpatialVector b;
  Real m = 0;  // mass of the body, kg

  bool is_held() const noexcept { return M > m; }  // by a coupling
};

inline SpatialVector times(const BodyStage& stage, const SpatialVector& V) noexcept {
  return {.w = stage.A_ww * V.w, .v = V.v * stage.M};
}

/// Near contacts [first, end) of a pair of bodies, or of a body and the world.
struct NearGroup {
  static constexpr std::uint32_t no_pair = ~std::uint32_t(0);
  std::uint32_t first = 0, end = 0;
  std::uint32_t pair = no_pair;  // number of the pair in the graph
};

/// Contacts along a search direction: at step length t the normal force is F_n - by t, with v_n the rate of
/// the normal velocity.
struct LinePack {
  Pack F_n, by, v_n, active;
};
template <std::size_t max_packs>
struct LinePacks {
  std::array<LinePack, max_packs> list;
  std::size_t size = 0;
};

/// Additional storage of a scene with a net, and the type of its systems.
template <class Contacts, std::size_t N, class System>
struct NetStageType {
  using type = Absent<21>;
  using Coupled = System;
  using CoupledB = Absent<22>;
};
template <class Contacts, std::size_t N, class System>
requires(Contacts::has_net) struct NetStageType<Contacts, N, System> {
  using type = NetStage<typename Contacts::Net, N>;
  using Coupled = CoupledSystem<System, type>;
  using CoupledB = typename Coupled::Vector;
};

/// Working storage of contacts, undefined between steps. N: bodies.
template <class Contacts, std::size_t N>
struct BodyContactScratch {
  static constexpr std::size_t max_contacts = Contacts::max_contacts, max_pairs = Contacts::max_pairs,
                               max_terms = Contacts::max_terms;
  // four contacts of a pair, or of a body with the world
  static constexpr std::size_t max_packs = max_pairs > 0 ? max_contacts : max_contacts / 4 + N;
  static constexpr std::size_t room = Contacts::max_blocks > 0 ? Contacts::max_blocks
                                      : max_pairs + max_terms > 0
                                          ? std::max(N, std::min(blocks_per_body* N, N*(N - 1) / 2 + 1))
                                          : N;
  static constexpr std::size_t max_entries =
      std::max<std::size_t>(max_pairs + Contacts::max_term_entries + (Contacts::jointed ? N : 0) +
                                Contacts::template max_net_pairs<N>,
                            1);
  using System = BlockSystem<N, max_entries, room, Contacts::jointed, Contacts::has_net>;
  using OfNet = NetStageType<Contacts, N, System>;
  ContactFinder<Contacts, N> finder;
  NearContacts<max_contacts> near;
  std::array<NearGroup, max_contacts> groups;  // near contacts of a pair, or of a body and the world
  std::size_t num_groups = 0;
  // each pack: contacts of one pair, or of one body with the world
  std::array<ContactPack, max_packs> packs;
  std::array<InitialMemoryPack, max_packs> initial;  // initial data of these contacts
  // contacts that change their modes along the search direction
  LinePacks<max_packs + Contacts::max_net_packs> line;
  TouchingGraph<N, max_pairs, Contacts::jointed, max_terms> graph;
  [[no_unique_address]] typename Contacts::TermStages terms;
  System system;  // system of the current island
  SystemVectors<typename OfNet::Coupled>
      x;  // V: velocities of all bodies; V_0: predicted velocities, then those of the previous iteration
  [[no_unique_address]] typename OfNet::type net;            // nodes of nets
  [[no_unique_address]] typename OfNet::CoupledB coupled_b;  // b of bodies and nets
  std::array<BodyStage, N> stages;
  std::array<bool, N> touches;
  // with joints, a stage may have substeps
  StageMemories<max_contacts, Contacts::jointed ? 3 : 2> memories;
  ContactForces<max_contacts> forces;  // contact forces of the stage
  ContactStage stage;
  // true if some extrapolated contact has unexplained penetration (35)
  [[no_unique_address]] std::conditional_t<checks_penetration_jumps<Contacts>, bool, Absent<24>>
      penetration_jumps{};
  std::array<Wrench, N> wrenches;
  // impulses on bodies beyond their contact forces, left by the iterations (29)
  [[no_unique_address]] std::conditional_t<Contacts::between_bodies, std::array<SpatialVector, N>, Absent<31>>
      unbalanced;
  bool is_unbalanced = false;
  ContactReport report;
};

/// Joins the bodies that carry nodes of nets, and those in contact with or attached to these nodes.
template <class Contacts, std::size_t N>
void join_net(BodyContactScratch<Contacts, N>& w) noexcept {
  const auto of_net = [&](std::uint32_t i) noexcept {
    w.touches[i] = true;
    if (w.net.first_body == w.net.no_body) w.net.first_body = i;
    w.graph.join(i, w.net.first_body);
  };
  w.net.first_body = w.net.no_body;
  each_carried(w.net, [&](const NetRun& run) noexcept { of_net(static_cast<std::uint32_t>(run.body)); });
  for (std::size_t k = 0; k < w.net.near.size; ++k)
    if (w.net.near.list[k].b < N) of_net(w.net.near.list[k].b);
  for (const NetContactTerm& one : w.net.attached())
    if (one.body < N) of_net(one.body);
}

/// Returns the number of a near contact's pair: two bodies, or a body and the world.
inline std::uint32_t pair_of(const NearContact& near) noexcept {
  return static_cast<std::uint32_t>(near.key >> 32);
}

/// Finds the groups and pairs of the near contacts, and the islands that they form.
template <class Contacts, std::size_t N>
void find_pairs(std::size_t num_bodies, BodyContactScratch<Contacts, N>& w) noexcept {
  w.graph.num_pairs = w.num_groups = 0;
  for (std::size_t i = 0; i < num_bodies; ++i) w.touches[i] = false;
  for (std::uint32_t i = 0; i < w.near.size;) {
    const NearContact& first = w.near.list[i];
    NearGroup& group = w.groups[w.num_groups++] = {.first = i};
    bool is_deep = false;
    for (; i < w.near.size && pair_of(w.near.list[i]) == pair_of(first); ++i)
      is_deep = is_deep || w.near.list[i].d > 0;
    group.end = i;
    w.touches[first.a] = true;
    if constexpr (Contacts::between_bodies) {
      if (first.b >= N) continue;
      w.touches[first.b] = true;
      group.pair = static_cast<std::uint32_t>(w.graph.num_pairs);
      TouchingPair& pair = w.graph.pairs[w.graph.num_pairs++];
      pair.child = first.a;
      pair.parent = first.b;
      pair.is_deep = is_deep;
      pair.d = Column(Vec3(w.finder.at[pair.child].p_W - w.finder.at[pair.parent].p_W));
    }
  }
  if constexpr (Contacts::max_terms > 0) {
    for (std::uint32_t t = 0; t < w.graph.num_terms; ++t) {
      const TermEdge& term = w.graph.terms[t];
      for (std::uint32_t e = 0; e < term.size; ++e) w.touches[term.list[e]] = true;
    }
  }
  make_islands(w.touches, num_bodies, w.graph, [&]() noexcept {
    if constexpr (Contacts::has_net) join_net(w);
  });
  if constexpr (Contacts::has_net)
    if (w.net.first_body != w.net.no_body) w.graph.island_with(w.net.first_body).has_net = true;
}

/// Returns the contacts of a group in the graph.
template <class Contacts, std::size_t N>
TouchingContacts& contacts_of(const NearGroup& group, BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::between_bodies)
    if (group.pair != NearGroup::no_pair) return w.graph.pairs[group.pair];
  return w.graph.bodies[w.near.list[group.first].a];
}

/// True for a parent or child of a joint; joints carry forces that its contacts do not.
template <class Contacts, std::size_t N>
bool is_joined(std::uint32_t i, const BodyContactScratch<Contacts, N>& w) noexcept {
  if constexpr (Contacts::jointed) return w.graph.joints.joined[i];
  return false;
}

/// True if the body touches anything or is joined.
template <class Contacts, std::size_t N>
bool is_in_island(std::uint32_t i, const BodyContactScratch<Contacts, N>& w) noexcept {
  return w.touches[i] || is_joined(i, w);
}

}  // namespace godobject
