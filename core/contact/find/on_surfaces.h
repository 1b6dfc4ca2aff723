// Contacts of the spheres of a body with surfaces of the world or of another body, four at a time for planes
// and boxes.
#pragma once

#include "core/contact/find/four_spheres.h"
#include "core/contact/find/on_shape.h"
#include "core/math/componentwise.h"

namespace godobject {

/// Finds the contacts of the spheres of body a with the surfaces [first, end) of body b. Spheres of a body
/// with shapes leave a box of the world through one face if they are deep. leaving_W: direction in which all
/// spheres of a leave b, for bodies that overlap deeply; otherwise null. Returns true if a sphere is too deep
/// in a box of b and leaving_W is null; the result is then undefined.
template <class Contacts, std::size_t N>
// NOLINTNEXTLINE(readability-function-size): a list of cases
bool find_on_surfaces(const ContactFinder<Contacts, N>& w, std::uint32_t a, std::uint32_t b,
                      std::uint64_t pair, std::uint32_t first, std::uint32_t end, const Vec3* leaving_W,
                      NearContacts<Contacts::max_contacts>& near) noexcept {
  constexpr std::uint32_t spheres = ContactFinder<Contacts, N>::max_surfaces;
  const auto& on_a = w.owned[a];
  Real travel = on_a.travel;
  if (b < N) travel += w.owned[b].travel;
  for (std::uint32_t o = first; o < end; ++o) {
    const Real ball = ball_round(w.placed[o]);
    for (std::uint32_t s = on_a.first_sphere, k = on_a.first_pack; s < on_a.end_sphere; s += 4, ++k) {
      const SpherePack& pack = w.packs[k];
      std::uint32_t searched = on_a.end_sphere - s >= 4 ? 15u : (1u << (on_a.end_sphere - s)) - 1;
      if constexpr (Contacts::between_bodies) {
        if (b < N) searched &= reaching(pack, on_a.travel, w.broad.boxes[b]);
        if (searched == 0) continue;
      }
      const PlacedShape& shape = w.placed[o];
      const auto found = [&](std::uint32_t j, Real d, const Vec3& n_W) noexcept {
        add_near(w,
                 {.key = pair | touch_key(s + j, o),
                  .of = spheres + s + j,
                  .on = o,
                  .a = a,
                  .b = b,
                  .d = d,
                  .p_W = lane(pack.p_W, j) - pack.r[j] * n_W,
                  .n_W = n_W},
                 contact_reach * pack.r[j], near);
      };
      const auto found_all = [&](std::uint32_t hits, const Pack& d, const Vector3<Pack>& n_W) noexcept {
        if (hits == 0) return;
        const Vector3<Pack> p_W = pack.p_W - n_W * pack.r;
        const Pack v_n = opening_speed<Pack>(w, a, b, p_W, n_W);
        hits &= bits(pack.r * -contact_reach < max(d, d + w.h * v_n));
        const auto p = columns(p_W), n = columns(n_W);
        for (; hits != 0; hits &= hits - 1) {
          const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
          near.add({.key = pair | touch_key(s + j, o),
                    .of = spheres + s + j,
                    .on = o,
                    .a = a,
                    .b = b,
                    .d = d[j],
                    .v_n = v_n[j],
                    .p_W = p[j].vec(),
                    .n_W = n[j].vec()});
        }
      };
      const auto first_touch = [&](std::uint32_t j) noexcept {
        const Vec3 p_W = lane(pack.p_W, j);
        return swept(shape, p_W, -w.since() * (swept_velocity_at(w, a, p_W) - swept_velocity_at(w, b, p_W)),
                     pack.r[j]);
      };
      const auto before = [&](std::uint32_t j, const SurfacePoint& nearest) noexcept {
        return behind_face_before(pair | touch_key(s + j, o), *w.before, shape, lane(pack.p_W, j), nearest);
      };
      Pack d;
      Vector3<Pack> n_W;
      if (shape.kind() == ShapeKind::plane) {
        const std::uint32_t hits = searched & near_plane(shape, pack, travel, d, n_W);
        found_all(hits, d, n_W);
        continue;
      }
      if (on_a.has_surfaces() && shape.kind() == ShapeKind::box) {
        std::uint32_t hits = 0;
        if (leaving_W != nullptr) {
          hits = searched & behind_face(shape, pack, face_along(shape.R_WS(), *leaving_W), d, n_W);
        } else {
          hits = searched & near_box(shape, pack, travel, nullptr, d, n_W);
          // it may have entered through another face, or have passed through
          const std::uint32_t past = min_component(shape.half_extents()) < travel ? 15 : bits(Pack(0) < d);
          std::uint32_t fast = hits & ((past & bits(pack.r < travel)) | bits(pack.r <= d));
          for (; fast != 0; fast &= fast - 1) {
            const auto j = static_cast<std::uint32_t>(std::countr_zero(fast));
            const SweptContact touch = first_touch(j);
            if (touch.touches) {
              found(j, touch.depth, touch.n_W);
            } else if (b >= N && touch.was_inside && d[j] < pack.r[j]) {
              const SurfacePoint behind = before(j, {.distance = pack.r[j] - d[j], .n = lane(n_W, j)});
              found(j, pack.r[j] - behind.distance, behind.n);
            } else {
              continue;
            }
            hits &= ~(1u << j);
          }
          if ((hits & bits(pack.r <= d)) != 0) {
            if (b < N) return true;
            const Vec3 face = face_along(shape.R_WS(), exit_direction(w, o, o + 1, a, Vec3::Zero()).n_W);
            hits = searched & near_box(shape, pack, travel, &face, d, n_W);
          }
        }
        found_all(hits, d, n_W);
        continue;
      }
      std::uint32_t hits = searched & may_touch(shape, ball, pack, travel);
      for (; hits != 0; hits &= hits - 1) {
        const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
        const TouchingBall one{.key = pair | touch_key(s + j, o),
                               .of = spheres + s + j,
                               .body = a,
                               .p_W = lane(pack.p_W, j),
                               .r = pack.r[j]};
        find_on_shape(w, one, b, o, travel, leaving_W, near);
      }
    }
  }
  return false;
}

}  // namespace godobject
