// Search for contacts: spheres of bodies near each other, near shapes on other bodies, and near the world.
// Points, edges and axes of shapes near shapes of others.
//
// Spheres of other bodies touch a body at its shapes, or at its spheres if it has no shapes. Contact points
// of two spheres or edges lie midway between them, so that the order of bodies does not matter. Bodies of one
// tree of joints do not touch each other. Bound: that of the broad phase. For each pair of bodies with
// overlapping boxes, a query for each sphere in the other's box. For each body and surface of the world, a
// test of nearness per four spheres, and a query for each near one. For shapes: on_points.h, edges.h, axes.h.
#pragma once

#include "core/contact/find/axes.h"
#include "core/contact/find/on_points.h"
#include "core/contact/find/on_surfaces.h"

namespace godobject {

/// Finds crossings of the edges of box o of body a and box q of body b, or the world. Edges that are deep at
/// both ends of the stage were not the first to touch. If the boxes were apart at its start, edges are
/// evaluated at the time of touching.
template <class Contacts, std::size_t N>
BoxesAre find_crossings(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t o,
                        std::uint32_t b, std::uint32_t q, std::uint64_t key, bool may_be_sunk,
                        NearContacts<Contacts::max_contacts>& near) noexcept {
  constexpr Real infinity = std::numeric_limits<Real>::infinity();
  const Real travel = w.owned[a].travel + (b < N ? w.owned[b].travel : 0),
             reach = reach_of_edges(w.placed[o], w.placed[q]);
  // only against the world: between bodies, the sweep made grippers gain energy (decision 042)
  const bool sweeps = b >= N && travel > reach;
  const std::size_t before = near.size;
  Real before_end = 0;
  bool were_separated = false;
  const auto add = [&](const EdgeCrossing& crossing) noexcept {
    NearContact at{.key = key | crossing.edges,
                   .of = o,
                   .on = q,
                   .a = a,
                   .b = b,
                   .d = crossing.d,
                   .p_W = crossing.p_W,
                   .n_W = crossing.n_W};
    if (sweeps) {
      const Vec3 v_a = velocity_at(w, a, at.p_W);
      const Real v_n = at.n_W.dot(v_a - velocity_at(w, b, at.p_W));
      at.d -= before_end * v_n;
      at.p_W += before_end * v_a;
      were_separated |= at.d + w.since() * v_n <= reach;
    }
    at.p_W += at.d / 2 * at.n_W;  // between the edges, so that the order of the bodies does not matter
    add_near(w, at, infinity, near);
  };
  const auto add_end = [&](bool may) noexcept { return each_crossing(w.placed[o], w.placed[q], may, add); };
  const BoxesAre at_end = add_end(may_be_sunk);
  if (!sweeps || were_separated ||
      (at_end == BoxesAre::in_touch && !(travel > sunk_depth / edge_reach * reach)))
    return at_end;
  before_end = time_from_touch(w, a, o, b, q, travel, reach);
  if (!(before_end > 0)) return at_end;
  near.forget_from(before);
  each_crossing(earlier(w, a, o, before_end), earlier(w, b, q, before_end), false, add);
  before_end = 0;
  if (near.size == before) add_end(false);
  return BoxesAre::deep;
}

/// Finds crossings of the axis of a capsule with the axis of another or with edges of a box. o: surface of
/// body a. q: surface of body b, or of the world.
template <class Contacts, std::size_t N>
void find_on_axes(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t o, std::uint32_t b,
                  std::uint32_t q, std::uint64_t key, NearContacts<Contacts::max_contacts>& near) noexcept {
  const PlacedShape &of = w.placed[o], &on = w.placed[q];
  const bool is_of_box = of.kind() == ShapeKind::box;
  const Real least = contact_reach * std::max(round_radius(of.in_world()), round_radius(on.in_world())),
             reach = least + w.owned[a].travel + (b < N ? w.owned[b].travel : 0);
  const Real round = ball_round(of) + ball_round(on) + reach;
  if ((of.p_W() - on.p_W()).squaredNorm() > round * round) return;
  const auto add = [&](std::uint32_t number, Real d, const Vec3& p_W, const Vec3& n_W) noexcept {
    if (d <= -reach) return;
    add_near(w, {.key = key | number, .of = o, .on = q, .a = a, .b = b, .d = d, .p_W = p_W, .n_W = n_W},
             least, near);
  };
  if (is_of_box) {
    each_axis_on_edges(on, of, [&](std::uint32_t number, Real d, const Vec3& p_W, const Vec3& n_W) noexcept {
      add(number, d, p_W, -n_W);
    });
  } else if (on.kind() == ShapeKind::box) {
    each_axis_on_edges(of, on, add);
  } else {
    each_axis_crossing(of, on, memory_of(key, *w.before), add);
  }
}

/// Finds crossings of the boxes and capsules of body a with those among [first, end) of body b, or the world.
/// Returns true if two boxes may be sunk and are.
template <class Contacts, std::size_t N>
bool find_on_edges(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b, std::uint64_t pair,
                   std::uint32_t first, std::uint32_t end, bool may_be_sunk,
                   NearContacts<Contacts::max_contacts>& near) noexcept {
  const auto& on_a = w.owned[a];
  bool are_sunk = false;
  for (std::uint32_t o = on_a.first_surface; o < on_a.end_surface; ++o) {
    for (std::uint32_t q = first; q < end; ++q) {
      const ShapeKind of = w.placed[o].kind(), on = w.placed[q].kind();
      if (!has_edges(of) || !has_edges(on)) continue;
      const std::uint64_t key = pair | edges_key(o - on_a.first_surface, q - first, 0);
      if (of == ShapeKind::box && on == ShapeKind::box)
        are_sunk |= find_crossings(w, a, o, b, q, key, may_be_sunk, near) == BoxesAre::sunk;
      else find_on_axes(w, a, o, b, q, key, near);
    }
  }
  return are_sunk;
}

/// Adds one contact along one axis for sunk bodies, at the deepest point behind its face. The axis is kept
/// until they have separated.
template <class Contacts, std::size_t N>
void find_sunk(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b, std::uint64_t pair,
               std::uint32_t before, NearContacts<Contacts::max_contacts>& near) noexcept {
  const SinkingAxis axis = sinking_axis(w, a, b, before);
  add_near(w,
           {.key = pair | sinking_key(axis.number),
            .of = w.owned[a].first_surface,
            .on = w.owned[b].first_surface,
            .a = a,
            .b = b,
            .d = axis.depth,
            .p_W = axis.p_W,
            .n_W = axis.n_W},
           std::numeric_limits<Real>::infinity(), near);
}

/// Finds the contacts of two bodies, at least one with shapes. were_deep: overlap in the previous stage.
template <class Contacts, std::size_t N>
void find_on_bodies(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b, std::uint64_t pair,
                    const DeepPair& were_deep, NearContacts<Contacts::max_contacts>& near) noexcept {
  const auto &on_a = w.owned[a], &on_b = w.owned[b];
  const auto find = [&](const Vec3* a_leaves, const Vec3* b_leaves) noexcept {
    return find_on_surfaces(w, a, b, pair, on_b.first_surface, on_b.end_surface, a_leaves, near) ||
           find_on_surfaces(w, b, a, pair | of_second, on_a.first_surface, on_a.end_surface, b_leaves, near);
  };
  const std::size_t before = near.size;
  Vec3 a_leaves, b_leaves;
  bool are_deep = false;
  if (were_deep.spheres || find(nullptr, nullptr)) {
    near.forget_from(before);
    a_leaves = separation_direction(w, a, b, were_deep.pushed_W);
    b_leaves = -a_leaves;
    are_deep = true;
    find(&a_leaves, &b_leaves);
  }
  if (on_a.has_surfaces() && on_b.has_surfaces()) {
    if (on_a.has_points)
      find_on_points(w, a, on_a.first_surface, on_a.end_surface, b, on_b.first_surface, on_b.end_surface,
                     pair, true, are_deep ? &a_leaves : nullptr, near);
    if (on_b.has_points)
      find_on_points(w, b, on_b.first_surface, on_b.end_surface, a, on_a.first_surface, on_a.end_surface,
                     pair | of_second, false, are_deep ? &b_leaves : nullptr, near);
  }
  // a soft law explains the depth of others: its springs store the work, so their contacts are kept
  const bool may_be_sunk = !were_deep.pressed || were_deep.axis != SinkingAxis::none;
  if (!find_on_edges(w, a, b, pair, on_b.first_surface, on_b.end_surface, may_be_sunk, near)) return;
  near.forget_from(before);
  find_sunk(w, a, b, pair, were_deep.axis, near);
}

/// Finds the contacts of the spheres of both bodies.
template <class Contacts, std::size_t N>
void find_on_spheres(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b,
                     std::uint64_t pair, NearContacts<Contacts::max_contacts>& near) noexcept {
  const auto &on_a = w.owned[a], &on_b = w.owned[b];
  const Vec3 between = w.at[a].p_W - w.at[b].p_W;
  for (std::uint32_t s = on_a.first_sphere; s < on_a.end_sphere; ++s) {
    const Sphere sphere_a = sphere(&w.packs[on_a.first_pack], s - on_a.first_sphere);
    for (std::uint32_t t = on_b.first_sphere; t < on_b.end_sphere; ++t) {
      const Sphere sphere_b = sphere(&w.packs[on_b.first_pack], t - on_b.first_sphere);
      const Real both = sphere_a.r + sphere_b.r, least = contact_reach * std::min(sphere_a.r, sphere_b.r);
      const Real reach = least + on_a.travel + on_b.travel;
      const Vec3 apart = sphere_a.p_W - sphere_b.p_W;
      const Real distance_sq = apart.squaredNorm();
      if (distance_sq >= (both + reach) * (both + reach)) continue;
      const Real distance = std::sqrt(distance_sq);
      const Vec3 n = direction(apart, distance, direction(between, between.norm(), Vec3::UnitZ()));
      constexpr std::uint32_t spheres = ContactFinder<Contacts, N>::max_surfaces;
      add_near(w,
               {.key = pair | touch_key(t, s),  // keys rise in the order of these loops
                .of = spheres + s,
                .on = spheres + t,
                .a = a,
                .b = b,
                .d = both - distance,
                .p_W = sphere_a.p_W - (sphere_a.r - (both - distance) / 2) * n,
                .n_W = n},
               least, near);
    }
  }
}

/// Finds the near contacts of all bodies in a stage of length h with the predicted end w.at. before: contact
/// memory of the previous stage.
template <class Contacts, std::size_t N>
void find_contacts(const typename Contacts::Params& par, const typename Contacts::State& before,
                   std::size_t num_bodies, Real h, ContactFinder<Contacts, N>& w,
                   NearContacts<Contacts::max_contacts>& near) noexcept {
  near.clear();
  w.h = h;
  w.before = &before;
  place_bodies(par, num_bodies, w);
  if constexpr (Contacts::between_bodies)
    find_overlaps(num_bodies, w.broad,
                  [&](std::uint32_t a, std::uint32_t b) { return w.owned[a].tree != w.owned[b].tree; });
  RecallDeepPairs<Contacts> deep_pairs(par, before);
  const auto num_fixed = static_cast<std::uint32_t>(w.num_fixed);
  for (std::uint32_t a = 0; a < num_bodies; ++a) {
    if constexpr (Contacts::between_bodies)
      w.broad.near[a].each(static_cast<std::uint32_t>(num_bodies), [&](std::uint32_t b) noexcept {
        const std::uint64_t pair = pair_key(a, b);
        if (w.owned[a].has_surfaces() || w.owned[b].has_surfaces())
          find_on_bodies(w, a, b, pair, deep_pairs.find(pair), near);
        else find_on_spheres(w, a, b, pair, near);
      });
    if (num_fixed == 0) continue;
    const std::uint64_t pair = pair_key(a, 0xffff);
    const auto& on_a = w.owned[a];
    find_on_surfaces(w, a, std::uint32_t{N}, pair, 0, num_fixed, nullptr, near);
    if (!on_a.has_surfaces()) continue;
    if (on_a.has_points)
      find_on_points(w, a, on_a.first_surface, on_a.end_surface, std::uint32_t{N}, 0, num_fixed, pair, true,
                     nullptr, near);
    if (w.world_has_points) {
      find_on_points(w, std::uint32_t{N}, 0, num_fixed, a, on_a.first_surface, on_a.end_surface,
                     pair | of_second, false, nullptr, near);
      find_on_edges(w, a, std::uint32_t{N}, pair, 0, num_fixed, true, near);
    }
  }
  near.put_in_order();
}

}  // namespace godobject
