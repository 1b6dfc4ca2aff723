// Contacts of a tool with the world, solved with its bodies and their joints.
//
// Every contact is an impedance on its body (24), hung there before the bodies are solved along the tree of their
// joints; the modes of the contacts by Newton iterations over that. What the last pass leaves is reported as the residual.
#pragma once

#include "core/contact/candidates.h"
#include "core/contact/stage.h"
#include "core/joint/tree.h"

namespace godobject {

/// The contacts part of a scene whose bodies touch the world alone. Capacities: spheres, surfaces, contacts at a time.
template <std::size_t spheres_, std::size_t surfaces_, std::size_t contacts_>
struct FixedContacts {
  static constexpr std::size_t max_contacts = contacts_;
  static constexpr bool between_bodies = false;
  using Params = ContactParams<spheres_, surfaces_>;
  using State = ContactMemories<contacts_>;
  using Output = ContactReport;
  using BodyOutput = ContactWrench;
};

/// Scratch: undefined between steps.
template <class Contacts, std::size_t N>
struct FixedContactScratch {
  static constexpr std::size_t max_packs = Contacts::max_contacts / 4 + N;
  NearContacts<Contacts::max_contacts> near;
  std::array<BegunContact, Contacts::max_contacts> begun;  // of the near ones
  std::array<ContactPack, max_packs> packs;
  std::size_t num_packs = 0;
  std::array<ArticulatedBody, N> loaded;                            // bodies without contacts
  std::array<ContactMemories<Contacts::max_contacts>, 2> memories;  // at the ends of the stages
  std::size_t last = 0;                                             // of these
  ContactStage stage;
  std::array<Wrench, N> wrenches;  // on the bodies, about their centres of mass
  ContactReport report;
};

/// Spheres near surfaces, where the bodies are predicted to be.
template <class Contacts, std::size_t N, class Joints>
void find_contacts(const typename Contacts::Params& par, const Tree<N, Joints>& tree,
                   NearContacts<Contacts::max_contacts>& near) noexcept {
  near.clear();
  for (std::uint32_t s = 0; s < par.num_spheres; ++s) {
    const BodySphere& sphere = par.spheres[s];
    const TreePlace& at = tree.nodes[sphere.body].at;
    const Vec3 c_W = at.p_W + at.R_WB * sphere.p_B;
    const Real reach = contact_reach * sphere.radius;
    for (std::uint32_t o = 0; o < par.num_surfaces; ++o) {
      const SurfacePoint surface = nearest(par.surfaces[o].shape, c_W, sphere.radius + reach);
      const Real d = sphere.radius - surface.distance;
      if (!(d <= -reach))
        near.add({.key = contact_key(s, o),
                  .of = sphere_number(par, s),
                  .on = o,
                  .a = static_cast<std::uint32_t>(sphere.body),
                  .d = d,
                  .p_W = c_W - sphere.radius * surface.n,
                  .n_W = surface.n});
    }
  }
  near.put_in_order();
}

/// (24) of the near contacts, four of a body to a pack.
template <class Contacts, std::size_t N, class Joints>
void begin_contacts(const typename Contacts::Params& par, const typename Contacts::State& before, Real step,
                    Real h, const Tree<N, Joints>& tree, FixedContactScratch<Contacts, N>& w) noexcept {
  Recall of_step(before), of_stage(w.memories[w.last]);
  w.num_packs = 0;
  std::size_t j = 4;
  for (std::size_t i = 0; i < w.near.size; ++i, ++j) {
    const NearContact& near = w.near.list[i];
    const ContactLaw& law = law_of(par, near);
    if (j == 4 || w.packs[w.num_packs - 1].body != near.a) {
      for (; w.num_packs > 0 && j < 4; ++j) put_nothing(w.packs[w.num_packs - 1], j);
      w.packs[w.num_packs].u.setConstant(Pack(0));
      w.packs[w.num_packs++].body = near.a;
      j = 0;
    }
    const TreePlace& at = tree.nodes[near.a].at;
    const Vec3 r = near.p_W - at.a_W;
    const Real v_n = near.n_W.dot(at.V.v + at.V.w.cross(r));
    const Real d_0 = near.d + h * v_n;
    BegunContact& begun = w.begun[i];
    begun = recalled(law, w.stage, of_step.find(near.key), of_stage.find(near.key), near.n_W,
                     {.d_0 = d_0, .e_new = initial_offset(d_0, v_n, step)});
    set_contact(StageLaw(law, h), begun.e, d_0, r, near.n_W, begun.xi_W, w.packs[w.num_packs - 1], j);
  }
  for (; w.num_packs > 0 && j < 4; ++j) put_nothing(w.packs[w.num_packs - 1], j);
}

/// Hangs all contacts on their bodies.
template <class Contacts, std::size_t N, class Joints>
void hang_contacts(const FixedContactScratch<Contacts, N>& w, Real h, Tree<N, Joints>& tree) noexcept {
  for (std::size_t i = 0; i < w.num_packs;) {
    const std::size_t body = w.packs[i].body;
    ContactSums sums;
    for (; i < w.num_packs && w.packs[i].body == body; ++i) add<true>(w.packs[i], h, sums);
    const SymmetricSpatialMatrix A = total(sums);
    const SpatialVector b = total_impulse(sums);
    ArticulatedBody& a = tree.nodes[body].body;
    a.A += {.ww = A.ww, .wv = A.wv, .vw = transposed(A.wv), .vv = A.vv};
    a.b = a.b + b;
  }
}

/// Forces and next cases of all contacts. True: the forces obey the law.
template <class Contacts, std::size_t N, class Joints>
bool update_contacts(const Tree<N, Joints>& tree, Pass next, FixedContactScratch<Contacts, N>& w) noexcept {
  ContactResidual most;
  for (std::size_t i = 0; i < w.num_packs; ++i) {
    move(w.packs[i], tree.nodes[w.packs[i].body].V);
    settle<true>(w.packs[i], next, 0, most);
  }
  w.report.residual = most.worst();
  return w.report.residual <= contact_tolerance * most.F_n();
}

/// What the contacts carry over, and what they say.
template <class Contacts, std::size_t N, class Joints>
void end_contacts(const typename Contacts::Params& par, Real h, const Tree<N, Joints>& tree,
                  FixedContactScratch<Contacts, N>& w) noexcept {
  w.last = 1 - w.last;
  ContactMemories<Contacts::max_contacts>& next = w.memories[w.last];
  next.size = 0;
  w.report = {.num_near = w.near.size,
              .newton_iterations = w.report.newton_iterations,
              .residual = w.report.residual};
  for (Wrench& F : w.wrenches) F = {};
  std::size_t p = 0, j = 0;
  for (std::size_t i = 0; i < w.near.size; ++i, ++j) {
    const NearContact& near = w.near.list[i];
    if (j == 4 || w.packs[p].body != near.a) ++p, j = 0;
    const ContactPack& pack = w.packs[p];
    const Vec3 v = lane(pack.v, j), F = lane(pack.F, j);
    const Real depth = pack.d_0[j] - h * near.n_W.dot(v);
    const bool touches = near.n_W.dot(F) > 0;
    if (!touches && !(depth > 0)) continue;
    next.list[next.size++] = carried_over(law_of(par, near), near.key, w.begun[i], h, near.n_W, depth, F);
    const TreePlace& at = tree.nodes[near.a].at;
    Wrench& sum = w.wrenches[near.a];
    sum.f += F;
    sum.tau += (lane(pack.r, j) + at.a_W - at.p_W).cross(F);
    w.report.num_contacts += touches ? 1 : 0;
    w.report.deepest = std::max(depth, w.report.deepest);
  }
}

}  // namespace godobject
