// Broad phase: pairs of near bodies, by boxes round their spheres, sorted and swept along one axis.
//
// Bound for n bodies: n log2(n) comparisons of the sort; n^2 / 8 + n tests of a box against four, if all
// boxes overlap along the axis; n^2 / 128 words of the result. No memory between steps.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/contact/find/sphere_pack.h"
#include "core/math/bit_set.h"
#include "core/math/merge_sort.h"
#include "core/tuning.h"

namespace godobject {

/// Box round the spheres of a body, along the axes of the world; or four boxes.
template <class T>
struct AabbOf {
  Vector3<T> lo = Vector3<T>::Constant(T(0)), hi = Vector3<T>::Constant(T(0));
};
using Aabb = AabbOf<Real>;
using AabbPack = AabbOf<Pack>;

/// Working storage of the broad phase, undefined between steps.
template <std::size_t max_bodies>
struct BroadPhaseScratch {
  struct Entry {
    Real lo;  // lower end of the box along the axis
    std::uint32_t body;
  };
  std::array<Aabb, max_bodies> boxes;
  std::array<Entry, max_bodies> entries, merged;
  std::array<AabbPack, (max_bodies + 3) / 4> sorted;
  std::array<BitSet<max_bodies>, max_bodies> near;  // result: near bodies with higher numbers, for each body
  std::size_t num_entries = 0;                      // bodies with spheres, all of them finite
};

/// Returns a word whose bit j is set if sphere j of the pack, enlarged by its reach and `more`, reaches
/// into the box.
inline std::uint32_t reaching(const SpherePack& pack, Real more, const Aabb& box) noexcept {
  const Pack r = pack.r * (1 + contact_reach) + more;
  const auto along = [&](int c) {
    return (pack.p_W[c] - r <= Pack(box.hi[c])) & (Pack(box.lo[c]) <= pack.p_W[c] + r);
  };
  return bits(along(0) & along(1) & along(2));
}

/// Returns the axis along which the boxes are spread most. It affects only the duration of the sweep.
template <std::size_t max_bodies>
int widest_axis(const BroadPhaseScratch<max_bodies>& w) noexcept {
  Vec3 sum = Vec3::Zero(), sum_sq = Vec3::Zero();
  for (std::size_t k = 0; k < w.num_entries; ++k) {
    const Vec3& lo = w.boxes[w.entries[k].body].lo;
    sum += lo;
    sum_sq += lo.cwiseProduct(lo);
  }
  const Vec3 spread = static_cast<Real>(w.num_entries) * sum_sq - sum.cwiseProduct(sum);
  if (spread.x() >= spread.y() && spread.x() >= spread.z()) return 0;
  return spread.y() >= spread.z() ? 1 : 2;
}

/// Packs the boxes in the order of the entries, four to a pack. Lanes without a box overlap nothing.
template <std::size_t max_bodies>
void pack_boxes(BroadPhaseScratch<max_bodies>& w) noexcept {
  constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();
  const std::size_t n = w.num_entries;
  for (std::size_t k = 0; k < n; ++k) {
    set_lane(w.sorted[k / 4].lo, k % 4, w.boxes[w.entries[k].body].lo);
    set_lane(w.sorted[k / 4].hi, k % 4, w.boxes[w.entries[k].body].hi);
  }
  for (std::size_t k = n; k % 4 != 0; ++k) set_lane(w.sorted[k / 4].lo, k % 4, Vec3::Constant(nan));
}

/// Returns a word whose bit j is set if box j of the pack overlaps or touches this one.
inline std::uint32_t overlapping(const AabbPack& pack, const Aabb& box) noexcept {
  const auto along = [&](int c) { return (pack.lo[c] <= box.hi[c]) & (Pack(box.lo[c]) <= pack.hi[c]); };
  return bits(along(0) & along(1) & along(2));
}

/// Calls f(k, l) for the entries k < l whose boxes overlap, by a sweep along the axis. Hits are collected for
/// sixteen packs before they are processed, because unpredictable branches on each pack cost more than the
/// tests.
template <std::size_t max_bodies, class F>
void sweep(const BroadPhaseScratch<max_bodies>& w, int axis, F f) noexcept {
  const std::size_t num_packs = (w.num_entries + 3) / 4;
  for (std::size_t k = 0; k < w.num_entries; ++k) {
    const Aabb& box = w.boxes[w.entries[k].body];
    std::uint64_t after = ~std::uint64_t(1) << (k % 4);
    const auto is_in_reach = [&](std::size_t p) {
      return p < num_packs && w.entries[4 * p].lo <= box.hi[axis];
    };
    for (std::size_t p = k / 4; is_in_reach(p);) {
      const std::size_t first = 4 * p;
      std::uint64_t hits = 0;
      for (std::size_t j = 0; j < 64 && is_in_reach(p); j += 4)
        hits |= std::uint64_t(overlapping(w.sorted[p++], box)) << j;
      for (hits &= after; hits != 0; hits &= hits - 1)
        f(k, first + static_cast<std::size_t>(std::countr_zero(hits)));
      after = ~std::uint64_t(0);
    }
  }
}

/// Finds the pairs of bodies whose boxes overlap and that may_touch(a, b) accepts; result in w.near.
template <std::size_t max_bodies, class MayTouch>
void find_overlaps(std::size_t num_bodies, BroadPhaseScratch<max_bodies>& w, MayTouch may_touch) noexcept {
  const int axis = widest_axis(w);
  for (std::size_t k = 0; k < w.num_entries; ++k) w.entries[k].lo = w.boxes[w.entries[k].body].lo[axis];
  using Entry = typename BroadPhaseScratch<max_bodies>::Entry;
  merge_sort(w.entries.data(), w.merged.data(), w.num_entries,
             [](const Entry& a, const Entry& b) noexcept { return a.lo < b.lo; });
  pack_boxes(w);
  for (std::size_t a = 0; a < num_bodies; ++a) w.near[a] = {};
  sweep(w, axis, [&](std::size_t k, std::size_t l) {
    const std::uint32_t a = w.entries[k].body, b = w.entries[l].body;
    if (may_touch(a, b)) w.near[std::min(a, b)].insert(std::max(a, b));
  });
}

}  // namespace godobject
