// Which boxes overlap: against all pairs one by one, whatever way they are spread.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "core/contact/find/broad_phase.h"
#include "tests/core/one_body.h"

namespace godobject::test_broad_phase {
namespace {

constexpr std::size_t max_bodies = 150;
using Pairs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;

bool overlap(const Aabb& a, const Aabb& b) {
  return (a.lo.array() <= b.hi.array()).all() && (b.lo.array() <= a.hi.array()).all();
}

struct Boxes {
  std::unique_ptr<BroadPhaseScratch<max_bodies>> w = std::make_unique<BroadPhaseScratch<max_bodies>>();
  std::size_t num_bodies = 0;

  /// of: of some of the bodies, in rising order; the others are in no pair.
  template <class MayTouch>
  Pairs find(const std::vector<std::uint32_t>& of, MayTouch may_touch) {
    w->num_entries = 0;
    for (const std::uint32_t body : of) w->entries[w->num_entries++].body = body;
    find_overlaps(num_bodies, *w, may_touch);
    Pairs found;
    for (std::uint32_t a = 0; a < num_bodies; ++a)
      w->near[a].each(static_cast<std::uint32_t>(num_bodies),
                      [&](std::uint32_t b) { found.emplace_back(a, b); });
    return found;
  }
  template <class MayTouch>
  Pairs one_by_one(const std::vector<std::uint32_t>& of, MayTouch may_touch) const {
    Pairs found;
    for (std::size_t k = 0; k < of.size(); ++k)
      for (std::size_t l = k + 1; l < of.size(); ++l)
        if (overlap(w->boxes[of[k]], w->boxes[of[l]]) && may_touch(of[k], of[l]))
          found.emplace_back(of[k], of[l]);
    return found;
  }
};

std::vector<std::uint32_t> all_below(std::size_t n) {
  std::vector<std::uint32_t> all(n);
  for (std::uint32_t i = 0; i < n; ++i) all[i] = i;
  return all;
}
bool any_pair(std::uint32_t, std::uint32_t) { return true; }

/// Boxes of edges up to `size` in a room of these edges.
Boxes random_boxes(std::size_t n, const Vec3& room, Real size, Random& random) {
  Boxes b;
  b.num_bodies = n;
  for (std::size_t i = 0; i < n; ++i) {
    b.w->boxes[i].lo = random.vector().cwiseProduct(room);
    b.w->boxes[i].hi = b.w->boxes[i].lo + size * random.vector().cwiseAbs();
  }
  return b;
}

TEST(BroadPhase, FindsWhatAllPairsOneByOneFind) {
  Random random(1);
  std::size_t pairs = 0;
  for (const Vec3& room : {Vec3(1, 1, 1), Vec3(20, 0.1, 0.1), Vec3(0.1, 20, 0.1), Vec3(0, 0, 5),
                           Vec3(0, 0, 0), Vec3(1e6, 1e6, 1e6), Vec3(1e-9, 1e-9, 1e-9)}) {
    for (int n = 0; n < 100; ++n) {
      const auto size = static_cast<std::size_t>(random.integer(0, max_bodies));
      Boxes b = random_boxes(size, room, random.log_uniform(1e-3, 3), random);
      const Pairs found = b.find(all_below(size), any_pair);
      EXPECT_EQ(found, b.one_by_one(all_below(size), any_pair));
      pairs += found.size();
    }
  }
  EXPECT_GT(pairs, 10000u);
}

TEST(BroadPhase, LeavesOutWhomItIsNotAskedFor) {
  Random random(2);
  for (int n = 0; n < 100; ++n) {
    Boxes b = random_boxes(max_bodies, Vec3(1, 1, 1), 1, random);
    std::vector<std::uint32_t> some;
    for (std::uint32_t i = 0; i < max_bodies; ++i)
      if (random.integer(0, 1) == 0) some.push_back(i);
    const auto may_touch = [](std::uint32_t a, std::uint32_t c) { return a % 7 != c % 7; };
    EXPECT_EQ(b.find(some, may_touch), b.one_by_one(some, may_touch));
  }
}

/// Touching boxes overlap, in every direction; boxes apart by one digit do not.
TEST(BroadPhase, TouchingIsOverlapping) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const Real at : {1.0, -1.0}) {
      Boxes b;
      b.num_bodies = 2;
      b.w->boxes[0] = {.lo = Vec3::Zero(), .hi = Vec3::Ones()};
      b.w->boxes[1] = {.lo = at * Vec3::Unit(axis), .hi = at * Vec3::Unit(axis) + Vec3::Ones()};
      EXPECT_EQ(b.find({0, 1}, any_pair).size(), 1u);
      (at > 0 ? b.w->boxes[1].lo : b.w->boxes[1].hi)[axis] += at * 1e-15;
      EXPECT_EQ(b.find({0, 1}, any_pair).size(), 0u);
    }
  }
}

TEST(BroadPhase, TheResultHasNoHistory) {
  Random random(3);
  Boxes b = random_boxes(max_bodies, Vec3(1, 1, 1), 0.5, random);
  const Pairs first = b.find(all_below(max_bodies), any_pair);
  b.find({1, 5, 7}, any_pair);
  EXPECT_EQ(b.find(all_below(max_bodies), any_pair), first);
}

}  // namespace
}  // namespace godobject::test_broad_phase
