// Which spheres are near which surfaces. Bound: a query for each sphere and surface of the world.
#pragma once

#include <algorithm>

#include "core/contact.h"
#include "core/contact_memory.h"

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
};

/// The list of a stage, in the order of the keys.
template <std::size_t max_contacts>
struct NearContacts {
  std::array<NearContact, max_contacts> list;
  std::size_t size = 0;
  std::size_t num_found = 0;  // more than size: the list was full, and the deepest were kept

  bool full() const noexcept { return num_found > size; }
  void clear() noexcept { size = num_found = 0; }
  void add(const NearContact& contact) noexcept {
    ++num_found;
    if (size < max_contacts) list[size++] = contact;
    else put_in_place_of_shallowest(contact);
  }
  /// The full list is a heap with the shallowest on top, until put_in_order().
  void put_in_place_of_shallowest(const NearContact& contact) noexcept {
    const auto is_deeper = [](const NearContact& a, const NearContact& b) noexcept {
      return a.d != b.d ? a.d > b.d : a.key < b.key;
    };
    if (num_found == max_contacts + 1) std::make_heap(list.begin(), list.end(), is_deeper);
    if (!is_deeper(contact, list.front())) return;
    std::pop_heap(list.begin(), list.end(), is_deeper);
    list.back() = contact;
    std::push_heap(list.begin(), list.end(), is_deeper);
  }
  void put_in_order() noexcept {
    if (full())
      std::sort(list.begin(), list.end(),
                [](const NearContact& a, const NearContact& b) noexcept { return a.key < b.key; });
  }
};

/// A sphere nearer to a surface than this many of its radii may come to bear a force within the stage.
inline constexpr Real contact_reach = 0.25;

}  // namespace godobject
