// Spheres of bodies in the world, four to a pack, for the search for contacts between bodies.
#pragma once

#include <cstdint>

#include "core/math/simd4.h"
#include "core/math/types.h"

namespace godobject {

struct Sphere {
  Vec3 p_W = Vec3::Zero();  // centre, m
  Real r = 0;               // radius, m
};

/// Four spheres of one body. The last pack of a body repeats its last sphere in unused lanes.
struct SpherePack {
  Vector3<Pack> p_W = Vector3<Pack>::Constant(Pack(0));
  Pack r = 0;
};

/// Returns sphere k, counted from the first sphere of the first pack.
inline Sphere sphere(const SpherePack* packs, std::uint32_t k) noexcept {
  return {.p_W = lane(packs[k / 4].p_W, k % 4), .r = packs[k / 4].r[k % 4]};
}

}  // namespace godobject
