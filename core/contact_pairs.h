// The bodies that touch each other or the world in a stage: which they are, in pairs, and their contacts (24).
#pragma once

#include "core/contact_factor.h"
#include "core/contact_find.h"
#include "core/contact_pack.h"

namespace godobject {

/// The contacts part of a scene whose bodies touch each other. Capacities: spheres, surfaces, contacts at a time.
template <std::size_t spheres_, std::size_t surfaces_, std::size_t contacts_>
struct BodyContacts {
  static constexpr std::size_t max_contacts = contacts_;
  static constexpr bool between_bodies = true;
  static constexpr bool jointed = false;  // OnJoints
  using Params = ContactParams<spheres_, surfaces_>;
  using State = ContactMemories<contacts_>;
  using Output = ContactReport;
  using BodyOutput = ContactWrench;
};

/// A body's stage, about its centre of mass, world axes. A is split in its symmetric part and [s]x.
struct BodyStage {
  Block A_ww;
  Real M = 0;
  Column s, b_w, b_v;
};

inline AnchorTwist times(const BodyStage& stage, const AnchorTwist& V) noexcept {
  return {.w = stage.A_ww * V.w + cross(stage.s, V.w), .v = V.v * stage.M};
}
inline void add_impulse(const AnchorTwist& F, BodyStage& stage) noexcept {
  stage.b_w += F.w;
  stage.b_v += F.v;
}

/// Contacts on a line in velocities: normal forces F_n - by t at normal velocities of slope v_n.
struct LinePack {
  Pack F_n, by, v_n, touching;
};
template <std::size_t max_packs>
struct LinePacks {
  std::array<LinePack, max_packs> list;
  std::size_t size = 0;
};

/// Worthless between steps.
template <class Contacts, std::size_t N>
struct BodyContactScratch {
  static constexpr std::size_t max_contacts = Contacts::max_contacts;
  ContactFinder<Contacts, N> finder;
  NearContacts<max_contacts> near;
  std::array<ContactMemory, max_contacts> begun;  // of the near ones, where the stage starts
  std::array<std::uint32_t, max_contacts> place;  // pack and lane of the near ones
  std::array<ContactPack, max_contacts> packs;    // each of one pair, or one body with the world
  std::size_t num_packs = 0;
  LinePacks<max_contacts> line;  // those that leave their cases on it
  ContactTree<N, max_contacts, Contacts::jointed> tree;
  [[no_unique_address]] std::conditional_t<Contacts::jointed, Absent<12>, ContactFactor<N>> factor;
  bool factored = false;  // the island at hand
  std::array<BodyStage, N> stages;
  std::array<bool, N> touches;
  std::array<AnchorTwist, N> V, b, r, z, p, Ap, AV_0;  // of bodies: velocities, impulses; of the iteration
  std::array<AnchorTwist, N> V_0;                      // velocities of the pass before
  std::array<ContactMemories<max_contacts>, 2> memories;
  std::size_t last = 0;
  ContactStage stage;
  std::array<Wrench, N> wrenches;
  ContactReport report;
};

/// Number of the near contact's pair, or that of its body with the world.
inline std::uint32_t pair_of(const NearContact& near) noexcept {
  return static_cast<std::uint32_t>(near.key >> 32);
}

/// The pairs of the near contacts, and the tree of the stiffest.
template <class Contacts, std::size_t N>
void find_pairs(const typename Contacts::Params& par, std::size_t num_bodies, Real h,
                BodyContactScratch<Contacts, N>& w) noexcept {
  w.tree.num_pairs = 0;
  for (std::size_t i = 0; i < num_bodies; ++i) w.touches[i] = false;
  for (std::size_t i = 0; i < w.near.size; ++i) {
    const NearContact& near = w.near.list[i];
    w.touches[near.a] = true;
    if (near.b >= N) continue;
    w.touches[near.b] = true;
    if (i == 0 || pair_of(w.near.list[i - 1]) != pair_of(near)) {
      TouchingPair& pair = w.tree.pairs[w.tree.num_pairs++];
      pair.child = near.a;
      pair.parent = near.b;
      pair.stiffness = 0;
    }
    const ContactLaw& law = law_of(par, near);
    if (near.d > 0) w.tree.pairs[w.tree.num_pairs - 1].stiffness += h * law.k + law.c;
  }
  make_islands(w.touches, num_bodies, w.tree);
}

/// The normal force that a contact begins with: that of the step before; of a new one, F_n at the predicted velocities.
/// Bodies that hit each other are slowed down within the step: at predicted velocities too much touches, too hard.
inline Real foreseen(const ContactMemory& begun, Real F_n) noexcept {
  const bool is_new = begun.n_W.isZero();
  return std::max(is_new ? F_n : begun.n_W.dot(begun.F_W), Real(0));
}

/// (24) of the near contacts, four of a pair to a pack.
template <class Contacts, std::size_t N>
void begin_contacts(const typename Contacts::Params& par, const typename Contacts::State& before,
                    std::size_t num_bodies, Real step, Real h, BodyContactScratch<Contacts, N>& w) noexcept {
  Recall of_step(before), of_stage(w.memories[w.last]);
  w.num_packs = 0;
  for (std::size_t i = 0; i < num_bodies; ++i) w.tree.bodies[i].first_pack = w.tree.bodies[i].end_pack = 0;
  std::size_t j = 4, pairs = 0;
  for (std::size_t i = 0; i < w.near.size; ++i, ++j) {
    const NearContact& near = w.near.list[i];
    const bool on_world = near.b >= N;
    const bool is_new = i == 0 || pair_of(w.near.list[i - 1]) != pair_of(near);
    if (j == 4 || is_new) {
      for (; w.num_packs > 0 && j < 4; ++j) put_nothing(w.packs[w.num_packs - 1], j);
      j = 0;
      ++w.num_packs;
      if (is_new && !on_world) ++pairs;
      auto& first = on_world ? w.tree.bodies[near.a].first_pack : w.tree.pairs[pairs - 1].first_pack;
      auto& end = on_world ? w.tree.bodies[near.a].end_pack : w.tree.pairs[pairs - 1].end_pack;
      if (is_new) first = static_cast<std::uint32_t>(w.num_packs - 1);
      end = static_cast<std::uint32_t>(w.num_packs);
    }
    const std::uint32_t child = on_world ? near.a : w.tree.pairs[pairs - 1].child;
    const ContactLaw& law = law_of(par, near);
    const Real d_0 = near.d + h * near.v_n;
    // edges are found late where spheres of a corner let faces in: no motion explains how deep they are then
    const Real e_new = is_of_edges(near.key) ? d_0 : unexplained(d_0, near.v_n, step);
    const Real most =
        on_world ? std::numeric_limits<Real>::infinity() : max_pushed_steps * step * law.push_out;
    w.begun[i] = recalled(law, w.stage, near.key, of_step.find(near.key),
                          w.stage.goes_on ? of_stage.find(near.key) : nullptr, near.n_W,
                          {.d_0 = d_0, .e_new = e_new, .most = most});
    const Real side = child == near.a ? 1 : -1;
    ContactMemory memory = w.begun[i];
    memory.xi_W *= side;
    const Vec3 r = near.p_W - w.finder.at[child].p_W;
    ContactPack& pack = w.packs[w.num_packs - 1];
    set_contact(law, memory, h, d_0, r, side * near.n_W, pack, j);
    set_lane(pack.F, j, side * foreseen(memory, pack.F_0[j] - pack.eta_n[j] * near.v_n) * near.n_W);
    w.place[i] = static_cast<std::uint32_t>(4 * (w.num_packs - 1) + j);
  }
  for (; w.num_packs > 0 && j < 4; ++j) put_nothing(w.packs[w.num_packs - 1], j);
  for (std::size_t k = 0; k < w.tree.num_pairs; ++k) {
    TouchingPair& pair = w.tree.pairs[k];
    pair.d = Column(Vec3(w.finder.at[pair.child].p_W - w.finder.at[pair.parent].p_W));
  }
}

}  // namespace godobject
