// Pairs of near spheres: against all pairs one by one; lists too full; centres coincident, far or not finite.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/contact/find/sphere_pairs.h"
#include "tests/core/one_body.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_broad_phase {
namespace {

constexpr Real nan = std::numeric_limits<Real>::quiet_NaN();
constexpr Real infinity = std::numeric_limits<Real>::infinity();

struct SphereBody {
  std::vector<Sphere> spheres;
  std::uint32_t group = 0;
};
using Bodies = std::vector<SphereBody>;

/// Everything a search needs, with room for the scenes of these tests.
template <std::size_t max_pairs = 20000>
struct Search {
  static constexpr std::size_t max_bodies = 150;
  BodySpheres<max_bodies, 1500> spheres;
  BroadPhaseScratch<max_bodies> scratch;
  SpherePairs<max_pairs> out;

  void load(const Bodies& bodies) {
    spheres.num_bodies = spheres.num_spheres = 0;
    for (const SphereBody& body : bodies) {
      ASSERT_TRUE(spheres.add_body(body.group));
      for (const Sphere& s : body.spheres) ASSERT_TRUE(spheres.add_sphere(s.r));
      for (std::uint32_t k = 0; k < body.spheres.size(); ++k)
        spheres.place(spheres.num_bodies - 1, k, body.spheres[k].p_W);
    }
  }
  std::vector<SpherePair> find(const Bodies& bodies, Real margin) {
    load(bodies);
    find_sphere_pairs(spheres, margin, scratch, out);
    return {out.list.begin(), out.list.begin() + static_cast<std::ptrdiff_t>(out.size)};
  }
};

/// All pairs, one by one.
std::vector<SpherePair> brute_force(const Bodies& bodies, Real margin) {
  std::vector<SpherePair> found;
  std::uint32_t i = 0;
  for (std::uint32_t a = 0; a < bodies.size(); ++a) {
    for (const Sphere& s : bodies[a].spheres) {
      std::uint32_t j = i + static_cast<std::uint32_t>(&bodies[a].spheres.back() - &s) + 1;
      for (std::uint32_t b = a + 1; b < bodies.size(); ++b) {
        const bool apart = bodies[a].group != 0 && bodies[a].group == bodies[b].group;
        for (const Sphere& t : bodies[b].spheres) {
          const Vec3 d = t.p_W - s.p_W;
          const Real gap = d.norm() - s.r - t.r;
          if (!apart && gap < margin)
            found.push_back({.i = i, .j = j, .body_i = a, .body_j = b, .gap = gap, .n_W = d.normalized()});
          ++j;
        }
      }
      ++i;
    }
  }
  std::sort(found.begin(), found.end(), comes_before);
  return found;
}

void expect_same(const std::vector<SpherePair>& found, const std::vector<SpherePair>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    ASSERT_EQ(found[k].i, expected[k].i) << k;
    ASSERT_EQ(found[k].j, expected[k].j) << k;
    EXPECT_EQ(found[k].body_i, expected[k].body_i);
    EXPECT_EQ(found[k].body_j, expected[k].body_j);
    EXPECT_NEAR(found[k].gap, expected[k].gap, 1e-12);
    EXPECT_LT((found[k].n_W - expected[k].n_W).norm(), 1e-9);
  }
}
// NOLINTBEGIN(bugprone-suspicious-memory-comparison): of the bits, zeros and NaN included
bool bit_equal(const SpherePair& a, const SpherePair& b) {
  return a.i == b.i && a.j == b.j && a.body_i == b.body_i && a.body_j == b.body_j &&
         std::memcmp(&a.gap, &b.gap, sizeof a.gap) == 0 &&
         std::memcmp(a.n_W.data(), b.n_W.data(), 3 * sizeof(Real)) == 0;
}
// NOLINTEND(bugprone-suspicious-memory-comparison)
bool bit_equal(const std::vector<SpherePair>& a, const std::vector<SpherePair>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const SpherePair& p, const SpherePair& q) { return bit_equal(p, q); });
}

/// Clusters of spheres in a box of edge `size`.
Bodies random_bodies(Random& random, int num_bodies, int max_spheres, Real size, Real min_r, Real max_r) {
  Bodies bodies(static_cast<std::size_t>(num_bodies));
  for (SphereBody& body : bodies) {
    const Vec3 centre(random.uniform(0, size), random.uniform(0, size), random.uniform(0, size));
    const int n = random.integer(0, max_spheres);
    for (int k = 0; k < n; ++k) {
      const Real r = random.log_uniform(min_r, max_r);
      body.spheres.push_back({.p_W = centre + 2 * r * random.vector(), .r = r});
    }
  }
  return bodies;
}
SphereBody one_sphere(const Vec3& p_W, Real r, std::uint32_t group = 0) {
  return {.spheres = {{.p_W = p_W, .r = r}}, .group = group};
}

class BroadPhase : public ::testing::Test {
 protected:
  std::unique_ptr<Search<>> search_ = std::make_unique<Search<>>();

  std::vector<SpherePair> find(const Bodies& bodies, Real margin) { return search_->find(bodies, margin); }
};

TEST_F(BroadPhase, FindsWhatAllPairsOneByOneFind) {
  Random random(1);
  std::size_t num_pairs = 0, num_empty = 0;
  for (int scene = 0; scene < 600; ++scene) {
    const Real size = random.log_uniform(0.02, 10),
               margin = random.integer(0, 1) * random.log_uniform(1e-4, 0.1);
    const Bodies bodies = random_bodies(random, random.integer(0, 40), 11, size, 0.01, 0.02);
    const auto expected = brute_force(bodies, margin);
    expect_same(find(bodies, margin), expected);
    EXPECT_FALSE(search_->out.full());
    EXPECT_EQ(search_->out.num_left_out, 0u);
    num_pairs += expected.size();
    num_empty += expected.empty() ? 1 : 0;
  }
  EXPECT_GT(num_pairs, 100000u);
  EXPECT_GT(num_empty, 30u);
}

TEST_F(BroadPhase, FindsPairsOfVeryDifferentRadii) {
  Random random(2);
  for (int scene = 0; scene < 200; ++scene) {
    const Bodies bodies = random_bodies(random, 40, 6, 2, 1e-4, 1);
    expect_same(find(bodies, 1e-3), brute_force(bodies, 1e-3));
  }
}

TEST_F(BroadPhase, FindsPairsOfManyBodiesWhateverTheirAxis) {
  Random random(3);
  for (int axis = 0; axis < 3; ++axis) {
    Bodies bodies = random_bodies(random, 150, 10, 0.2, 0.01, 0.02);
    for (SphereBody& body : bodies)
      for (Sphere& s : body.spheres) s.p_W[axis] *= 10;
    const auto expected = brute_force(bodies, 0.005);
    EXPECT_GT(expected.size(), 50u);
    expect_same(find(bodies, 0.005), expected);
  }
}

TEST_F(BroadPhase, FindsPairsOfBodiesOf64Spheres) {
  Random random(4);
  Bodies bodies(3);
  for (SphereBody& body : bodies)
    for (int k = 0; k < 64; ++k) body.spheres.push_back({.p_W = 0.03 * random.vector(), .r = 0.01});
  const auto expected = brute_force(bodies, 0);
  EXPECT_GT(expected.size(), 100u);
  expect_same(find(bodies, 0), expected);
}

TEST_F(BroadPhase, AHeapInOnePlaceIsComplete) {
  Random random(5);
  Bodies bodies;
  for (int b = 0; b < 60; ++b) bodies.push_back(one_sphere(1e-3 * random.vector(), 1));
  expect_same(find(bodies, 0), brute_force(bodies, 0));
  EXPECT_EQ(search_->out.num_found, 60u * 59 / 2);
}

TEST_F(BroadPhase, TouchingIsNotBelowTheMargin) {
  // In binary fractions, without rounding.
  for (int c = 0; c < 3; ++c) {
    for (Real sign : {-1.0, 1.0}) {
      const auto at = [&](Real distance) {
        return Bodies{one_sphere(Vec3::Zero(), 0.25), one_sphere(sign * distance * Vec3::Unit(c), 0.25)};
      };
      EXPECT_TRUE(find(at(0.5), 0).empty());
      EXPECT_TRUE(find(at(0.625), 0.125).empty());
      const auto found = find(at(0.5), 0.125);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].gap, 0);
      EXPECT_EQ(found[0].n_W, Vec3(sign * Vec3::Unit(c)));
    }
  }
}

TEST_F(BroadPhase, TheMarginReachesInEveryDirection) {
  Random random(6);
  for (int k = 0; k < 500; ++k) {
    const Real margin = random.log_uniform(1e-6, 1);
    const Vec3 direction = random.vector().normalized();
    const auto at = [&](Real gap) {
      return Bodies{one_sphere({1, 2, 3}, 0.01), one_sphere(Vec3(1, 2, 3) + (0.03 + gap) * direction, 0.02)};
    };
    EXPECT_EQ(find(at(margin - 1e-9), margin).size(), 1u);
    EXPECT_EQ(find(at(margin + 1e-9), margin).size(), 0u);
  }
}

TEST_F(BroadPhase, CoincidentCentresHaveTheNormalOfTheirBodies) {
  const Vec3 p(0.1, 0.2, 0.3);
  const SphereBody left{.spheres = {{.p_W = p, .r = 0.01}, {.p_W = p - Vec3(0.1, 0, 0), .r = 0.01}}};
  const SphereBody right{.spheres = {{.p_W = p, .r = 0.02}, {.p_W = p + Vec3(0.1, 0, 0), .r = 0.01}}};
  auto found = find({left, right}, 0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_DOUBLE_EQ(found[0].gap, -0.03);
  EXPECT_LT((found[0].n_W - Vec3::UnitX()).norm(), 1e-9);

  found = find({one_sphere(p, 0.01), one_sphere(p, 0.01)}, 0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_DOUBLE_EQ(found[0].gap, -0.02);
  EXPECT_EQ(found[0].n_W, Vec3::UnitZ());
}

TEST_F(BroadPhase, PointsOfNoRadiusMayCoincide) {
  const auto found = find({one_sphere(Vec3::Ones(), 0), one_sphere(Vec3::Ones(), 0)}, 1e-3);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].gap, 0);
  EXPECT_EQ(found[0].n_W, Vec3::UnitZ());
}

TEST_F(BroadPhase, BodiesOfOneGroupDoNotCollide) {
  Random random(7);
  Bodies bodies = random_bodies(random, 60, 8, 0.1, 0.01, 0.02);
  const std::size_t num_all = brute_force(bodies, 0).size();
  ASSERT_GT(num_all, 100u);
  for (std::size_t b = 0; b < bodies.size(); ++b) bodies[b].group = static_cast<std::uint32_t>(b % 4);
  const auto expected = brute_force(bodies, 0);
  EXPECT_LT(expected.size(), num_all);
  expect_same(find(bodies, 0), expected);
  EXPECT_FALSE(search_->scratch.pairs.contains(1, 5));
}

TEST_F(BroadPhase, TheResultHasNoHistory) {
  Random random(8);
  const Bodies bodies = random_bodies(random, 50, 9, 0.1, 0.005, 0.02);
  const auto first = find(bodies, 1e-3);
  ASSERT_GT(first.size(), 100u);
  for (int k = 0; k < 20; ++k) {
    find(random_bodies(random, random.integer(1, 150), 9, 0.2, 0.005, 0.02), 0.01);
    EXPECT_TRUE(bit_equal(find(bodies, 1e-3), first));
  }
  std::memset(static_cast<void*>(&search_->scratch), 0xff, sizeof search_->scratch);  // NaN
  EXPECT_TRUE(bit_equal(find(bodies, 1e-3), first));
}

TEST_F(BroadPhase, RenumberedBodiesHaveTheSamePairs) {
  Random random(9);
  Bodies bodies(50);
  for (SphereBody& body : bodies) body = one_sphere(0.05 * random.vector(), random.uniform(0.02, 0.05));
  const auto first = find(bodies, 1e-3);
  ASSERT_GT(first.size(), 100u);

  const auto last = static_cast<std::uint32_t>(bodies.size() - 1);
  std::reverse(bodies.begin(), bodies.end());
  std::vector<SpherePair> reversed = find(bodies, 1e-3);
  for (SpherePair& pair : reversed) {
    pair.i = last - pair.i;
    pair.j = last - pair.j;
    pair.body_i = last - pair.body_i;
    pair.body_j = last - pair.body_j;
    std::swap(pair.i, pair.j);
    std::swap(pair.body_i, pair.body_j);
  }
  std::sort(reversed.begin(), reversed.end(), comes_before);
  ASSERT_EQ(reversed.size(), first.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(reversed[k].i, first[k].i);
    EXPECT_EQ(reversed[k].j, first[k].j);
    EXPECT_EQ(reversed[k].gap, first[k].gap);
    EXPECT_EQ(reversed[k].n_W, Vec3(-first[k].n_W));
  }
}

template <std::size_t capacity>
void expect_deepest_kept(const Bodies& bodies, Real margin) {
  const auto search = std::make_unique<Search<capacity>>();
  const auto found = search->find(bodies, margin);
  auto expected = brute_force(bodies, margin);
  EXPECT_EQ(search->out.num_found, expected.size());
  EXPECT_EQ(search->out.full(), expected.size() > capacity);
  const std::size_t kept = std::min(capacity, expected.size());
  std::sort(expected.begin(), expected.end(), is_deeper);
  expected.resize(kept);
  std::sort(expected.begin(), expected.end(), comes_before);
  expect_same(found, expected);
}

TEST_F(BroadPhase, AFullListIsReportedAndKeepsTheDeepest) {
  Random random(10);
  for (int scene = 0; scene < 50; ++scene) {
    const Bodies bodies = random_bodies(random, 30, 8, 0.1, 0.005, 0.02);
    expect_deepest_kept<1>(bodies, 1e-3);
    expect_deepest_kept<17>(bodies, 1e-3);
    expect_deepest_kept<200>(bodies, 1e-3);
  }
}

TEST_F(BroadPhase, AListThatJustFitsIsNotFull) {
  Random random(11);
  Bodies bodies;
  for (int b = 0; b < 5; ++b) bodies.push_back(one_sphere(0.1 * random.vector(), 1));
  expect_deepest_kept<9>(bodies, 0);
  expect_deepest_kept<10>(bodies, 0);
  expect_deepest_kept<11>(bodies, 0);
}

TEST_F(BroadPhase, OfEqualGapsTheFirstAreKept) {
  Bodies bodies;
  for (int b = 0; b < 10; ++b) bodies.push_back(one_sphere(Vec3::Ones(), 0.5));
  const auto search = std::make_unique<Search<12>>();
  const auto found = search->find(bodies, 0);
  ASSERT_EQ(found.size(), 12u);
  EXPECT_EQ(search->out.num_found, 45u);
  for (std::uint32_t k = 0; k < 12; ++k) {
    EXPECT_EQ(found[k].i, k < 9 ? 0u : 1u);
    EXPECT_EQ(found[k].j, k < 9 ? k + 1 : k - 7);
  }
}

TEST_F(BroadPhase, ABodyThatIsNotFiniteIsLeftOutAndReported) {
  Random random(12);
  Bodies bodies(30);
  for (SphereBody& body : bodies)
    for (int k = 0; k < 6; ++k) body.spheres.push_back({.p_W = 0.05 * random.vector(), .r = 0.01});
  Bodies without = bodies;
  for (Sphere& s : without[7].spheres) s.p_W = Vec3::Constant(100);
  const auto expected = brute_force(without, 1e-3);
  ASSERT_GT(expected.size(), 20u);

  for (std::size_t k = 0; k < 6; ++k) {
    for (int c = 0; c < 4; ++c) {
      for (Real bad : {nan, infinity, -infinity}) {
        Bodies broken = bodies;
        Sphere& s = broken[7].spheres[k];
        (c < 3 ? s.p_W[c] : s.r) = bad;
        expect_same(find(broken, 1e-3), expected);
        EXPECT_EQ(search_->out.num_left_out, 1u);
      }
    }
  }
  find(bodies, 1e-3);
  EXPECT_EQ(search_->out.num_left_out, 0u);
  for (SphereBody& body : bodies) body.spheres[2].p_W.y() = nan;
  EXPECT_TRUE(find(bodies, 1e-3).empty());
  EXPECT_EQ(search_->out.num_left_out, 30u);
}

TEST_F(BroadPhase, BodiesFarAwayDisturbNothing) {
  Random random(13);
  const Bodies near_by = random_bodies(random, 40, 8, 0.2, 0.01, 0.02);
  const auto expected = brute_force(near_by, 0);
  ASSERT_GT(expected.size(), 20u);
  for (Real far : {1e9, 1e100, 1e200, 1e300}) {
    for (int c = 0; c < 3; ++c) {
      Bodies bodies = near_by;
      bodies.push_back(one_sphere(far * Vec3::Unit(c), 0.01));
      bodies.push_back(one_sphere(-far * Vec3::Unit(c), 0.01));
      expect_same(find(bodies, 0), expected);
      EXPECT_EQ(search_->out.num_left_out, 0u);
    }
  }
}

TEST_F(BroadPhase, SpheresFarAwayStillCollide) {
  const Vec3 far(1e9, -1e9, 1e9);
  const auto found = find({one_sphere(far, 1), one_sphere(far + Vec3(1, 0, 0), 1)}, 0);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found[0].gap, -1, 1e-6);
  EXPECT_LT((found[0].n_W - Vec3::UnitX()).norm(), 1e-6);
}

TEST_F(BroadPhase, NothingIsFoundOfNothing) {
  EXPECT_TRUE(find({}, 1).empty());
  EXPECT_TRUE(find({SphereBody{}}, 1).empty());
  EXPECT_TRUE(find({SphereBody{}, one_sphere(Vec3::Zero(), 1), SphereBody{}}, 1).empty());
  EXPECT_EQ(search_->out.num_left_out, 0u);
}

TEST_F(BroadPhase, CapacitiesOfBodiesAndSpheresAreReported) {
  BodySpheres<2, 66> spheres;
  EXPECT_FALSE(spheres.add_sphere(1)) << "no body";
  ASSERT_TRUE(spheres.add_body());
  for (int k = 0; k < 64; ++k) ASSERT_TRUE(spheres.add_sphere(1));
  EXPECT_FALSE(spheres.add_sphere(1)) << "64 in a body";
  ASSERT_TRUE(spheres.add_body());
  ASSERT_TRUE(spheres.add_sphere(1));
  ASSERT_TRUE(spheres.add_sphere(1));
  EXPECT_FALSE(spheres.add_sphere(1)) << "66 in all";
  EXPECT_FALSE(spheres.add_body());
  EXPECT_EQ(spheres.num_bodies, 2u);
  EXPECT_EQ(spheres.num_spheres, 66u);
}

TEST_F(BroadPhase, NothingIsAllocatedEvenWhenFull) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  Random random(14);
  const auto search = std::make_unique<Search<100>>();
  search->load(random_bodies(random, 100, 8, 0.1, 0.01, 0.02));
  AllocationGuard guard;
  find_sphere_pairs(search->spheres, 1e-3, search->scratch, search->out);
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_TRUE(search->out.full());
}

}  // namespace
}  // namespace godobject::test_broad_phase
