// List of near contacts of a stage.
#pragma once

#include "core/contact/contact.h"
#include "core/contact/memory.h"
#include "core/math/bounded_list.h"
#include "core/tuning.h"

namespace godobject {

/// Near contact of a sphere or edge with a surface, sphere or edge, at the predicted end of a stage or at its
/// start.
struct NearContact {
  std::uint64_t key = 0;
  std::uint32_t of = 0, on = 0;  // touching and touched element: surface number, or sphere number after them
  std::uint32_t a = 0, b = 0;    // bodies of `of` and `on`
  Real d = 0;                    // depth, m; < 0: apart
  Real v_n = 0;                  // opening speed, m/s
  Vec3 p_W = Vec3::Zero();       // contact point: on the sphere, or midway between two spheres or edges
  Vec3 n_W = Vec3::UnitZ();      // normal, off b

  static bool comes_before(const NearContact& a, const NearContact& b) noexcept { return a.key < b.key; }
  static bool is_deeper(const NearContact& a, const NearContact& b) noexcept {
    return a.d != b.d ? a.d > b.d : comes_before(a, b);
  }
};

/// List of near contacts of a stage.
template <std::size_t max_contacts>
using NearContacts =
    BoundedList<NearContact, max_contacts, NearContact::is_deeper, NearContact::comes_before>;

/// Returns the law of a contact.
template <std::size_t max_spheres, std::size_t max_surfaces>
const ContactLaw& law_of(const ContactParams<max_spheres, max_surfaces>& par,
                         const NearContact& near) noexcept {
  return par.law(par.material_of(near.of), par.material_of(near.on));
}

}  // namespace godobject
