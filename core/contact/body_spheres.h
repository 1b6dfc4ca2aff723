// The spheres of many bodies in the world, four to a pack: what contacts between bodies are sought on.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/math/simd4.h"
#include "core/math/types.h"

namespace godobject {

struct Sphere {
  Vec3 p_W = Vec3::Zero();  // centre, m
  Real r = 0;               // radius, m
};

/// Four spheres of one body. The last pack of a body repeats its last sphere in lanes without one.
struct SpherePack {
  Vector3<Pack> p_W = Vector3<Pack>::Constant(Pack(0));
  Pack r = 0;
};

/// Sphere k of those that begin with this pack.
inline Sphere sphere(const SpherePack* packs, std::uint32_t k) noexcept {
  return {.p_W = lane(packs[k / 4].p_W, k % 4), .r = packs[k / 4].r[k % 4]};
}

/// Bodies and the radii of their spheres are added at set-up, centres are placed every step. Both
/// are numbered in the order in which they were added. A body has at most 64 spheres: one with more is added
/// in parts of one group, best each a region of it.
template <std::size_t max_bodies, std::size_t max_spheres>
struct BodySpheres {
  struct Body {
    std::uint32_t first_sphere = 0;
    std::uint32_t num_spheres = 0;
    std::uint32_t first_pack = 0;
    std::uint32_t group = 0;  // bodies of one group do not collide; 0: of none

    std::uint32_t end_pack() const noexcept { return first_pack + (num_spheres + 3) / 4; }
  };
  static constexpr std::uint32_t max_spheres_per_body = 64;
  // Every body may leave three lanes of its last pack free.
  static constexpr std::size_t max_packs = (max_spheres + 3 * max_bodies) / 4;

  std::array<SpherePack, max_packs> packs;
  std::array<Body, max_bodies> bodies;
  std::uint32_t num_bodies = 0;
  std::uint32_t num_spheres = 0;

  /// False: max_bodies is reached, nothing was added.
  [[nodiscard]] bool add_body(std::uint32_t group = 0) noexcept {
    if (num_bodies == max_bodies) return false;
    const std::uint32_t first_pack = num_bodies == 0 ? 0 : bodies[num_bodies - 1].end_pack();
    bodies[num_bodies++] = {
        .first_sphere = num_spheres, .num_spheres = 0, .first_pack = first_pack, .group = group};
    return true;
  }
  /// To the body added last, at the origin; r >= 0. False, and nothing was added: there is no body, it has
  /// max_spheres_per_body, or max_spheres is reached.
  [[nodiscard]] bool add_sphere(Real r) noexcept {
    if (num_spheres == max_spheres || num_bodies == 0) return false;
    Body& body = bodies[num_bodies - 1];
    if (body.num_spheres == max_spheres_per_body) return false;
    SpherePack& pack = packs[body.first_pack + body.num_spheres / 4];
    for (std::size_t j = body.num_spheres % 4; j < 4; ++j) pack.r.set(j, r);
    ++body.num_spheres;
    ++num_spheres;
    return true;
  }
  /// Centre of sphere k of a body, k < its num_spheres.
  void place(std::uint32_t body, std::uint32_t k, const Vec3& p_W) noexcept {
    SpherePack& pack = packs[bodies[body].first_pack + k / 4];
    set_lane(pack.p_W, k % 4, p_W);
    if (k + 1 != bodies[body].num_spheres) return;
    for (std::size_t j = k % 4 + 1; j < 4; ++j) set_lane(pack.p_W, j, p_W);
  }
};

}  // namespace godobject
