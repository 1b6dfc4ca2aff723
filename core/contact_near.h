// Which spheres are near which surfaces. Bound: a query for each sphere and surface of the world.
#pragma once

#include "core/contact.h"
#include "core/contact_memory.h"
#include "core/deepest.h"

namespace godobject {

/// A sphere near a surface where a stage is predicted to end.
struct NearContact {
  std::uint64_t key = 0;
  std::uint32_t sphere = 0;
  std::uint32_t touched = 0;   // number of the surface
  std::uint32_t a = 0, b = 0;  // bodies of the sphere and of what it touches
  Real d = 0;                  // depth, m; < 0: apart
  Real v_n = 0;                // how fast it opens, m/s
  Vec3 c_W = Vec3::Zero();     // centre of the sphere
  Vec3 n_W = Vec3::UnitZ();    // off the surface

  static bool comes_before(const NearContact& a, const NearContact& b) noexcept { return a.key < b.key; }
  static bool is_deeper(const NearContact& a, const NearContact& b) noexcept {
    return a.d != b.d ? a.d > b.d : comes_before(a, b);
  }
};

/// The list of a stage.
template <std::size_t max_contacts>
using NearContacts = Deepest<NearContact, max_contacts, NearContact::is_deeper, NearContact::comes_before>;

/// A sphere nearer to a surface than this many of its radii may come to bear a force within the stage.
inline constexpr Real contact_reach = 0.25;

}  // namespace godobject
