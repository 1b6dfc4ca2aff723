// Data of the previous step's contacts for the search: keys, pairs of deeply overlapping bodies, the face
// through which a sphere entered a box.
#pragma once

#include "core/contact/find/exit_direction.h"

namespace godobject {

/// Returns the key of a contact between bodies, or of a body and the world: the pair, the surface, and the
/// touching sphere. Keys of a pair are consecutive.
inline std::uint64_t pair_key(std::uint32_t a, std::uint32_t b) noexcept {
  return std::uint64_t(a) << 48 | std::uint64_t(b) << 32;
}
inline std::uint64_t touch_key(std::uint32_t sphere, std::uint32_t touched) noexcept {
  return std::uint64_t(touched) << 15 | sphere;
}
/// Returns the key of one of the contacts of a sphere with an obstacle that it touches at several faces.
/// slot: below max_touched_faces.
inline std::uint64_t face_key(std::uint64_t touch, std::size_t slot) noexcept {
  static_assert(max_touched_faces <= 16);  // four bits above the numbers of surfaces
  return touch | std::uint64_t(slot) << 26;
}
inline std::uint32_t sphere_of(std::uint64_t key) noexcept {
  return static_cast<std::uint32_t>(key) & 0x7fff;
}

/// Returns the key of crossing edges, made of the box numbers within their bodies and the edge numbers. It is
/// above the keys of all spheres.
inline std::uint64_t edges_key(std::uint32_t box_a, std::uint32_t box_b, std::uint32_t edges) noexcept {
  return std::uint64_t(3) << 30 | box_a << 19 | box_b << 8 | edges;
}
inline bool is_of_edges(std::uint64_t key) noexcept { return (key >> 30 & 3) == 3; }
/// Returns the key of a pair of sunk bodies, made of the number of the axis along which they separate.
inline std::uint64_t sinking_key(std::uint32_t axis) noexcept { return std::uint64_t(1) << 30 | axis; }
inline bool is_of_sinking(std::uint64_t key) noexcept { return (key >> 30 & 3) == 1; }

/// Bit of a key, set if the touching sphere is on the pair's second body and the surface on the first.
inline constexpr std::uint64_t of_second = std::uint64_t(1) << 31;
/// True if a sphere of the pair's second body touches the first.
inline bool is_of_second(std::uint64_t key) noexcept { return (key & of_second) != 0 && !is_of_edges(key); }

/// Overlap of a pair of bodies in the previous step.
struct DeepPair {
  bool spheres = false;  // true if the rest penetration of a sphere exceeds its reach
  // true if a contact spring other than that of sunk boxes is compressed
  bool pressed = false;
  std::uint32_t axis = SinkingAxis::none;  // axis along which they were sunk
  Vec3 pushed_W = Vec3::Zero();            // normal force of the second body on the first, N
};

/// Looks up the previous overlap of pairs of bodies in rising order.
template <class Contacts>
class RecallDeepPairs {
 public:
  RecallDeepPairs(const typename Contacts::Params& par, const typename Contacts::State& of) noexcept
      : par_(par), of_(of) {}
  DeepPair find(std::uint64_t pair) noexcept {
    while (at_ < of_.size && of_.list[at_].key < pair) ++at_;
    DeepPair deep;
    for (; at_ < of_.size && of_.list[at_].key >> 32 == pair >> 32; ++at_) {
      const ContactMemory& m = of_.list[at_];
      deep.pressed |= m.pressed > 0 && !is_of_sinking(m.key);
      deep.pushed_W += (is_of_second(m.key) ? -1 : 1) * m.F_n * m.n_W.vec();
      if (is_of_edges(m.key)) continue;
      if (is_of_sinking(m.key)) deep.axis = static_cast<std::uint32_t>(m.key) & ((1u << 30) - 1);
      else if (const std::uint32_t s = sphere_of(m.key);
               s < par_.num_spheres)  // otherwise a point of a shape
        deep.spheres |= m.e > contact_reach * par_.spheres[s].radius;
    }
    return deep;
  }

 private:
  const typename Contacts::Params& par_;
  const typename Contacts::State& of_;
  std::size_t at_ = 0;
};

/// Returns the memory of a key; null if there is none.
template <std::size_t max_contacts>
const ContactMemory* memory_of(std::uint64_t key, const ContactMemories<max_contacts>& before) noexcept {
  const ContactMemory *const first = before.list.data(), *const end = first + before.size;
  const ContactMemory* const at = std::lower_bound(
      first, end, key, [](const ContactMemory& m, std::uint64_t k) noexcept { return m.key < k; });
  return at == end || at->key != key ? nullptr : at;
}

/// Returns the face of a box nearest to a point p that is or was inside it. The face that carried the contact
/// force in the previous step takes precedence. side: 1 if the contact's normal is off the box, -1 if it is
/// off the point.
template <std::size_t max_contacts>
SurfacePoint behind_face_before(std::uint64_t key, const ContactMemories<max_contacts>& before,
                                const PlacedShape& box, const Vec3& p_W, const SurfacePoint& nearest,
                                Real side = 1) noexcept {
  const ContactMemory* const at = memory_of(key, before);
  if (at == nullptr) return nearest;
  const Vec3 n_S = face_along(box.R_WS(), side * at->n_W.vec()), n_W = box.R_WS() * n_S;
  return {.distance = n_W.dot(p_W - box.p_W()) - box.half_extents().dot(n_S.cwiseAbs()), .n = n_W};
}

}  // namespace godobject
