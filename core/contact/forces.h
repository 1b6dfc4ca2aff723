// Forces of single contacts: those of a stage, and their means over a step.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/math/types.h"

namespace godobject {

/// Force of one contact.
struct ContactForce {
  std::uint64_t key = 0;
  std::uint32_t on = 0;        // number of the surface or sphere that is touched
  std::uint32_t a = 0, b = 0;  // bodies, or a node and a body
  Vec3 p_W = Vec3::Zero();     // contact point, m
  Vec3 n_W = Vec3::UnitZ();    // off b
  Vec3 F_W = Vec3::Zero();     // force on a, N
};

/// Contact forces, sorted by key.
template <std::size_t max_contacts>
struct ContactForces {
  std::array<ContactForce, max_contacts> list;
  std::size_t size = 0;

  template <std::size_t max_others>
  void assign(const ContactForces<max_others>& other) noexcept {
    size = std::min(other.size, max_contacts);
    std::copy_n(other.list.begin(), size, list.begin());
  }

  void scale(Real factor) noexcept {
    for (std::size_t i = 0; i < size; ++i) list[i].F_W *= factor;
  }

  /// Adds share times the forces of a stage. Each contact keeps its newest place. New contacts beyond the
  /// capacity are left out.
  template <std::size_t max_others>
  void add(const ContactForces<max_others>& stage, Real share) noexcept {
    std::size_t num_new = 0;
    for (std::size_t i = 0, k = 0; k < stage.size; ++k) {
      while (i < size && list[i].key < stage.list[k].key) ++i;
      if (i == size || list[i].key != stage.list[k].key) ++num_new;
    }
    // merged from the end, so that nothing is overwritten before it has moved
    std::size_t i = size, k = stage.size, end = size = std::min(size + num_new, max_contacts);
    std::size_t without_room = i + num_new - size;
    while (k > 0) {
      const ContactForce& of = stage.list[k - 1];
      if (i > 0 && list[i - 1].key > of.key) {
        list[--end] = list[--i];
        continue;
      }
      const bool is_known = i > 0 && list[i - 1].key == of.key;
      --k;
      if (!is_known && without_room > 0) {
        --without_room;
        continue;
      }
      const Vec3 F_W = share * of.F_W + (is_known ? list[--i].F_W : Vec3(Vec3::Zero()));
      list[--end] = of;
      list[end].F_W = F_W;
    }
  }
};

}  // namespace godobject
