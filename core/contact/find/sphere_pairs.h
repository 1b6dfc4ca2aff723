// Which spheres of different bodies are near each other: gap and normal of every pair.
//
// Bound for each pair of bodies with overlapping boxes, of m spheres each: m / 2 tests of four spheres with a
// box, m^2 / 4 of a sphere against four. A full list costs a sift through a heap, about 2 log2(max_pairs)
// comparisons, for each pair that is deeper than the shallowest kept.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/contact/body_spheres.h"
#include "core/contact/find/broad_phase.h"
#include "core/math/bounded_list.h"

namespace godobject {

/// Spheres i < j of bodies body_i < body_j.
struct SpherePair {
  std::uint32_t i = 0, j = 0;            // numbers of the spheres
  std::uint32_t body_i = 0, body_j = 0;  // and of their bodies
  Real gap = 0;                          // phi, m; < 0: depth
  Vec3 n_W = Vec3::UnitZ();              // unit, from i to j
};

/// Order of the list: by bodies, then spheres.
inline bool comes_before(const SpherePair& a, const SpherePair& b) noexcept {
  if (a.body_i != b.body_i) return a.body_i < b.body_i;
  if (a.body_j != b.body_j) return a.body_j < b.body_j;
  return a.i != b.i ? a.i < b.i : a.j < b.j;
}
/// Which is kept rather when not all can be; of equal gaps, what comes first.
inline bool is_deeper(const SpherePair& a, const SpherePair& b) noexcept {
  return a.gap != b.gap ? a.gap < b.gap : comes_before(a, b);
}

/// The pairs found. Filled by find_sphere_pairs(); in the order of comes_before().
template <std::size_t max_pairs>
struct SpherePairs : BoundedList<SpherePair, max_pairs, is_deeper, comes_before> {
  std::size_t num_left_out = 0;  // bodies without pairs because a number of their spheres is not finite
};

/// Bit j: sphere j of the pack reaches into the box.
inline std::uint32_t reaching(const SpherePack& pack, const Aabb& box) noexcept {
  const auto along = [&](int c) {
    return (pack.p_W[c] - pack.r <= Pack(box.hi[c])) & (Pack(box.lo[c]) <= pack.p_W[c] + pack.r);
  };
  return bits(along(0) & along(1) & along(2));
}

/// Bit j: |p_j - p_i| < r_j + r_i + margin.
inline std::uint32_t near(const SpherePack& pack, const Sphere& i, Real margin) noexcept {
  const auto along = [&](int c) { return pack.p_W[c] - Pack(i.p_W[c]); };
  const Pack x = along(0), y = along(1), z = along(2);
  const Pack reach = pack.r + Pack(i.r + margin);
  return bits(x * x + y * y + z * z < reach * reach);
}

/// Gap and normal of spheres of bodies in these boxes. Where the centres coincide no direction is better than
/// another, and the normal is that from box to box; where these coincide too, the z axis.
inline void measure(const Sphere& i, const Sphere& j, const Aabb& box_i, const Aabb& box_j,
                    SpherePair& pair) noexcept {
  const Real reach = i.r + j.r;
  // Beyond the digits of a position, and for spheres of no radius where squares underflow.
  const Real coincident = std::max(Real(1e-9) * reach, Real(1e-150));
  const Vec3 d = j.p_W - i.p_W;
  const Real distance = std::sqrt(d.squaredNorm());
  pair.gap = distance - reach;
  if (distance > coincident) {
    pair.n_W = d * (1 / distance);
    return;
  }
  const Vec3 between = box_j.lo + box_j.hi - box_i.lo - box_i.hi;
  const Real length = std::sqrt(between.squaredNorm());
  if (length > coincident) pair.n_W = between / length;
}

/// Bit k: sphere k of the body reaches into the box.
template <class Body>
std::uint64_t reaching(const SpherePack* packs, const Body& body, const Aabb& box) noexcept {
  std::uint64_t all = 0;
  for (std::size_t k = 0; k < body.num_spheres; k += 4) all |= std::uint64_t(reaching(*packs++, box)) << k;
  return all & (~std::uint64_t(0) >> (64 - body.num_spheres));
}

/// Bit j of `spheres`: sphere j of the other body is near sphere i.
struct Hits {
  std::uint32_t i;
  std::uint64_t spheres;
};

/// Adds the pairs of bodies a < b whose gap is below `margin`. The boxes, of find_body_pairs(), contain what
/// is within margin / 2 of the bodies.
template <class Spheres, std::size_t max_pairs>
void add_pairs_of(const Spheres& spheres, std::uint32_t a, std::uint32_t b, const Aabb& box_a,
                  const Aabb& box_b, Real margin, SpherePairs<max_pairs>& out) noexcept {
  const auto &body_a = spheres.bodies[a], &body_b = spheres.bodies[b];
  const SpherePack* packs_a = &spheres.packs[body_a.first_pack];
  const SpherePack* packs_b = &spheres.packs[body_b.first_pack];
  const std::uint64_t sought = reaching(packs_b, body_b, grown(box_a, margin / 2));
  if (sought == 0) return;
  const auto first = static_cast<std::size_t>(std::countr_zero(sought)) / 4;
  const auto end = static_cast<std::size_t>(std::bit_width(sought) + 3) / 4;

  // First the hits of all spheres of a, without a branch on any: these could not be predicted.
  std::array<Hits, 64> found;
  std::size_t num_found = 0;
  std::uint64_t seeking = reaching(packs_a, body_a, grown(box_b, margin / 2));
  for (; seeking != 0; seeking &= seeking - 1) {
    const auto i = static_cast<std::uint32_t>(std::countr_zero(seeking));
    const Sphere sphere_i = sphere(packs_a, i);
    std::uint64_t hits = 0;
    for (std::size_t k = first; k < end; ++k)
      hits |= std::uint64_t(near(packs_b[k], sphere_i, margin)) << (4 * k);
    found[num_found] = {.i = i, .spheres = hits & sought};
    num_found += found[num_found].spheres != 0 ? 1 : 0;
  }
  for (std::size_t n = 0; n < num_found; ++n) {
    const std::uint32_t i = found[n].i;
    for (std::uint64_t hits = found[n].spheres; hits != 0; hits &= hits - 1) {
      const auto j = static_cast<std::uint32_t>(std::countr_zero(hits));
      SpherePair pair{.i = body_a.first_sphere + i, .j = body_b.first_sphere + j, .body_i = a, .body_j = b};
      measure(sphere(packs_a, i), sphere(packs_b, j), box_a, box_b, pair);
      out.add(pair);
    }
  }
}

/// Finds the spheres of bodies, not of one group, with a gap below `margin` (m, >= 0). Positions may be any
/// numbers, finite or not; radii and margin have finite squares (below 1e150 m).
template <std::size_t max_bodies, std::size_t max_spheres, std::size_t max_pairs>
void find_sphere_pairs(const BodySpheres<max_bodies, max_spheres>& spheres, Real margin,
                       BroadPhaseScratch<max_bodies>& w, SpherePairs<max_pairs>& out) noexcept {
  out.clear();
  out.num_left_out = find_body_pairs(spheres, margin, w);
  w.pairs.for_each([&](std::uint32_t a, std::uint32_t b) {
    add_pairs_of(spheres, a, b, w.boxes[a], w.boxes[b], margin, out);
  });
  out.put_in_order();
}

}  // namespace godobject
