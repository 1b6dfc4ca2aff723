// Start of contacts in a stage, four at a time: laws, carried-over memory, and the linearisation (24).
#pragma once

#include "core/contact/places.h"
#include "core/math/flatten.h"
#include "core/solve/pairs.h"

namespace godobject {

/// Up to four consecutive near contacts; unused lanes repeat the last one.
struct NearFour {
  std::uint32_t size;
  std::array<const NearContact*, 4> of;

  NearFour(const NearContact* first, std::size_t left) noexcept
      : size(static_cast<std::uint32_t>(std::min<std::size_t>(left, 4))),
        of{first, first + std::min<std::uint32_t>(size - 1, 1), first + std::min<std::uint32_t>(size - 1, 2),
           first + (size - 1)} {}

  template <class Member>
  auto all(Member member) const noexcept {
    return gathered(lanes_of_four, [&](std::size_t j) -> decltype(auto) { return (of[j]->*member); });
  }
  /// Returns 1, and 0 in unused lanes.
  Pack live() const noexcept {
    return gathered(lanes_of_four, [&](std::size_t j) -> Real { return j < size ? 1 : 0; });
  }
  /// Returns 1 where the normal points away from the surface that body a touches, -1 where it points away
  /// from body a, 0 in unused lanes.
  Pack sides(std::uint32_t a) const noexcept {
    return gathered(lanes_of_four, [&](std::size_t j) -> Real {
      return j >= size ? 0 : of[j]->a == a ? 1 : -1;
    });
  }
};

/// Returns the laws of four contacts.
inline StageLawOf<Pack> gathered(const std::array<StageLawOf<Real>, 4>& of) noexcept {
  return each_number(
      [&](auto number) noexcept { return Pack(of[0].*number, of[1].*number, of[2].*number, of[3].*number); });
}

/// Returns the laws of near contacts in the stage. law_of(contact): its law. common_law: the most frequent
/// law, already converted for the stage to `law`; stage_law() converts any other. Contacts in unused lanes
/// carry no force.
template <class LawOf, class OfStage>
StageLawOf<Pack> laws_of(const NearFour& near, const ContactLaw& common_law, const StageLawOf<Real>& law,
                         LawOf law_of, OfStage stage_law) noexcept {
  bool alike = true;
  for (std::uint32_t j = 0; j < 4; ++j) alike = alike && &law_of(*near.of[j]) == &common_law;
  if (alike && near.size == 4) return each_number([&](auto number) noexcept { return Pack(law.*number); });
  std::array<StageLawOf<Real>, 4> each{};
  for (std::uint32_t j = 0; j < near.size; ++j) {
    const ContactLaw& its = law_of(*near.of[j]);
    each[j] = &its == &common_law ? law : stage_law(its);
  }
  return gathered(each);
}

/// Linearises four near contacts at r (24). side: the body whose twist is used, 0 without one. start: the
/// contacts as found, completed by their depths. penetration_jumps: set if some depth is unexplained (35).
/// Returns the initial energy of the contact springs (38), J.
template <std::size_t max_contacts, class PenetrationJumps>
GODOBJECT_FLATTEN Pack begin_four(const NearFour& near, const StageLawOf<Pack>& law, const Pack& side,
                                  const Vector3<Pack>& r, Real h, const ContactStage& stage,
                                  ContactStartOf<Pack>& start, Recall<max_contacts>& recall,
                                  [[maybe_unused]] PenetrationJumps& penetration_jumps,
                                  InitialMemoryPack& initial, ContactPack& pack) noexcept {
  const ContactPastOf<Pack> past =
      gathered({recall.find_or_empty(near.of[0]->key), recall.find_or_empty(near.of[1]->key),
                recall.find_or_empty(near.of[2]->key), recall.find_or_empty(near.of[3]->key)});
  const Pack v_n = near.all(&NearContact::v_n);
  start.d_0 = near.all(&NearContact::d) + h * v_n;
  // approach during the extrapolation to the start of the stage explains depth (35); approach within a stage
  // that was not predicted does not
  start.approach = stage.extrapolated * max(-v_n, Pack(0));
  if constexpr (std::is_same_v<PenetrationJumps, bool>) {
    const auto deeper = are_penetration_jumps(stage, past, start, v_n, law.max_stored_penetration);
    penetration_jumps =
        penetration_jumps || (!stage.is_joined() && (bits(deeper) & ((1u << near.size) - 1)) != 0);
  }
  initial = {.contact = recalled(law, stage, h, past, start), .v_W = start.v_W, .sticking = sticking_of(law)};
  set_contacts(law, initial, side, start.n_W, r, start.d_0, v_n, h, pack);
  return initial.contact.found;
}

/// Stores the contact memory at the end of the stage for the active or deep contacts of a group of four.
/// at: places of the bodies at the predicted end. c_W: contact points.
template <std::size_t max_contacts>
GODOBJECT_FLATTEN void carry_over(const NearFour& near, const Pack& side, const ContactPlacesOf<Pack>& at,
                                  const Vector3<Pack>& c_W, const ContactStage& stage, Real h,
                                  const InitialMemoryPack& initial, const ContactPack& pack,
                                  ContactMemories<max_contacts>& next) noexcept {
  const Vector3<Pack> n_W = pack.n * side, F_W = pack.F * side;
  const Pack v_n = pack.n.dot(pack.v), depth = pack.d_0 - h * v_n;
  const std::uint32_t stay = bits((Pack(0) < n_W.dot(F_W)) | (Pack(0) < depth)) & ((1u << near.size) - 1);
  if (stay == 0) return;
  const ContactPastOf<Pack> past = carried_over<Pack>(initial, stage, h,
                                                      {.at = at,
                                                       .c_W = c_W,
                                                       .n_W = n_W,
                                                       .s_W = (pack.v - pack.n * v_n + pack.v_xi) * side,
                                                       .F_W = F_W,
                                                       .d = depth});
  const auto c_a = columns(past.anchors.c_a), c_b = columns(past.anchors.c_b),
             n_a = columns(past.anchors.n_a), n_b = columns(past.anchors.n_b),
             xi_a = columns(past.anchors.xi_a), xi_b = columns(past.anchors.xi_b), n = columns(n_W),
             slip_dot = columns(past.slip_dot_W);
  for (std::uint32_t left = stay; left != 0; left &= left - 1) {
    const auto j = static_cast<std::size_t>(std::countr_zero(left));
    next.list[next.size++] = {.key = near.of[j]->key,
                              .on = near.of[j]->on,
                              .e = past.e[j],
                              .pressed = past.pressed[j],
                              .F_n = past.F_n[j],
                              .c_a = c_a[j],
                              .c_b = c_b[j],
                              .n_a = n_a[j],
                              .n_b = n_b[j],
                              .n_W = n[j],
                              .xi_a = xi_a[j],
                              .xi_b = xi_b[j],
                              .slip_dot_W = slip_dot[j]};
  }
}

/// Appends the forces of the active contacts of a group of four.
template <std::size_t max_contacts>
void add_bearing(const NearFour& near, const Pack& side, const ContactPack& pack,
                 ContactForces<max_contacts>& forces) noexcept {
  const Vector3<Pack> F_W = pack.F * side;
  const std::uint32_t bear = bits(Pack(0) < F_W.dot(F_W)) & ((1u << near.size) - 1);
  for (std::uint32_t left = bear; left != 0; left &= left - 1) {
    const auto j = static_cast<std::size_t>(std::countr_zero(left));
    const NearContact& of = *near.of[j];
    forces.list[forces.size++] = {
        .key = of.key, .on = of.on, .a = of.a, .b = of.b, .p_W = of.p_W, .n_W = of.n_W, .F_W = lane(F_W, j)};
  }
}

/// Linearises a group of near contacts (24), four to a pack, from pack `first` on. Not inlined: in
/// begin_contacts() its loop takes more instructions.
template <class Contacts, std::size_t N>
[[gnu::noinline]] std::uint32_t begin_group(const typename Contacts::Params& par, const NearGroup& group,
                                            Real h, std::uint32_t first,
                                            Recall<Contacts::max_contacts>& recall, Pack& found,
                                            BodyContactScratch<Contacts, N>& w) noexcept {
  const NearContact& one = w.near.list[group.first];
  const bool on_world = !Contacts::between_bodies || group.pair == NearGroup::no_pair;
  const BodyStage &a = w.stages[one.a], &b = w.stages[on_world ? one.a : one.b];
  const Real m = std::min(a.m, b.m), M = std::min(a.M, b.M);
  GroupPlaces<Contacts, N> places(one.a, one.b, w.finder);
  const auto law = [&](const ContactLaw& of) noexcept {
    return stage_law<Contacts>(of, m, M, h, w.stage.relaxation_time, on_world);
  };
  const auto law_of_contact = [&](const NearContact& near) noexcept -> const ContactLaw& {
    return law_of(par, near);
  };
  const ContactLaw& common_law = law_of(par, one);
  const StageLawOf<Real> law_in_stage = law(common_law);
  for (std::uint32_t i = group.first; i < group.end; i += 4, ++first) {
    const NearFour near(&w.near.list[i], group.end - i);
    const Pack sides = near.sides(one.a);
    const Vector3<Pack> c_W = near.all(&NearContact::p_W);
    ContactStartOf<Pack> start{
        .at = places.of(sides),
        .n_W = near.all(&NearContact::n_W),
        .v_W = places.velocity(c_W) * sides,
        .rho = gathered(lanes_of_four, [&](std::size_t j) { return rolling_radius(par, *near.of[j]); })};
    found += begin_four(near, laws_of(near, common_law, law_in_stage, law_of_contact, law), sides,
                        c_W - places.p_W(), h, w.stage, start, recall, w.penetration_jumps, w.initial[first],
                        w.packs[first]);
  }
  return first;
}

/// Linearises the near contacts (24).
template <class Contacts, std::size_t N>
void begin_contacts(const typename Contacts::Params& par, std::size_t num_bodies, Real h,
                    BodyContactScratch<Contacts, N>& w) noexcept {
  Recall recall(w.memories.before());
  for (std::size_t i = 0; i < num_bodies; ++i) w.graph.bodies[i].first_pack = w.graph.bodies[i].end_pack = 0;
  std::uint32_t packs = 0;
  Pack found = 0;
  if constexpr (checks_penetration_jumps<Contacts>) w.penetration_jumps = false;
  for (std::size_t g = 0; g < w.num_groups; ++g) {
    TouchingContacts& of = contacts_of(w.groups[g], w);
    of.first_pack = packs;
    of.end_pack = packs = begin_group(par, w.groups[g], h, packs, recall, found, w);
  }
  w.report.found += total(found);
}

}  // namespace godobject
