// Contacts of a sphere with the faces of a mesh or height field.
#pragma once

#include "core/contact/find/before.h"
#include "core/shape/faces.h"

namespace godobject {

/// Adds a contact with its opening speed if it is within reach at the predicted end of the stage or at its
/// start. A load may keep a body from separating as predicted.
template <class Contacts, std::size_t N>
void add_near(const ContactFinder<Contacts, N>& w, NearContact at, Real reach,
              NearContacts<Contacts::max_contacts>& near) noexcept {
  at.v_n = opening_speed(w, at.a, at.b, at.p_W, at.n_W);
  if (std::max(at.d, at.d + w.h * at.v_n) > -reach) near.add(at);
}

/// Previous contacts of a sphere with an obstacle by slots; null without one.
using MemoryOfFaces = std::array<const ContactMemory*, max_touched_faces>;

/// Assigns to each touched face the slot of its previous contact, by the nearest normal. So a contact keeps
/// its memory if others come or go. R_WS: attitude of the shape.
inline std::array<std::size_t, max_touched_faces> slots_of(const MemoryOfFaces& before, const Mat3& R_WS,
                                                           const TouchedFaces& faces) noexcept {
  std::array<bool, max_touched_faces> is_taken{};
  std::array<std::size_t, max_touched_faces> slots{};
  for (std::size_t i = 0; i < faces.size; ++i) {
    const Vec3 n_W = R_WS * faces.list[i].at.n;
    // a slot without memory, the last one first, precedes slots whose contact was another
    Real best = -2;
    for (std::size_t slot = max_touched_faces; slot-- > 0;) {
      if (is_taken[slot]) continue;
      const Real cosine = before[slot] == nullptr ? same_contact : before[slot]->n_W.vec().dot(n_W);
      if (cosine <= best) continue;
      best = cosine;
      slots[i] = slot;
    }
    is_taken[slots[i]] = true;
  }
  return slots;
}

/// Finds the contacts of a sphere of radius r about p_W with the faces of an obstacle. contact: its key
/// without a slot, elements and bodies. nearest: the nearest point of the surface. first: that point, or that
/// of a swept sphere's first touch.
template <class Contacts, std::size_t N>
void find_on_faces(const ContactFinder<Contacts, N>& w, NearContact contact, const PlacedShape& shape,
                   const Vec3& p_W, Real r, const SurfacePoint& first, const SurfacePoint& nearest,
                   Real reach, NearContacts<Contacts::max_contacts>& near) noexcept {
  const Mat3& R_WS = shape.R_WS();
  const SurfacePoint first_S{.distance = first.distance, .n = R_WS.transpose() * first.n};
  const Vec3 p_S = R_WS.transpose() * (p_W - shape.p_W());
  const std::uint64_t touch = contact.key;
  MemoryOfFaces before{};
  for (std::size_t slot = 0; slot < max_touched_faces; ++slot)
    before[slot] = memory_of(face_key(touch, slot), *w.before);
  const auto came_by = [&](const Vec3& n_S) noexcept {
    return nearest.distance < 0 &&
           std::any_of(before.begin(), before.end(), [&](const ContactMemory* one) noexcept {
             return one != nullptr && !is_other_normal(one->n_W.vec(), R_WS * n_S);
           });
  };
  const Vec3 nearest_S = R_WS.transpose() * (p_W - nearest.distance * nearest.n - shape.p_W());
  TouchedFaces faces;
  if (shape.kind() == ShapeKind::mesh)
    find_faces<MeshShape>(shape.in_world(), p_S, r, first_S, nearest_S, r + reach, came_by, faces);
  else find_faces<HeightFieldShape>(shape.in_world(), p_S, r, first_S, nearest_S, r + reach, came_by, faces);
  const auto slots = slots_of(before, R_WS, faces);
  for (std::size_t i = 0; i < faces.size; ++i) {
    contact.key = face_key(touch, slots[i]);
    contact.n_W = i == 0 && faces.has_nearest ? first.n : Vec3(R_WS * faces.list[i].at.n);
    contact.d = r - faces.list[i].at.distance;
    contact.p_W = p_W - r * contact.n_W;
    add_near(w, contact, contact_reach * r, near);
  }
  near.is_short |= faces.is_full;
}

}  // namespace godobject
