#include "core/math/componentwise.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

namespace godobject::test_componentwise {
namespace {

constexpr Real nan = std::numeric_limits<Real>::quiet_NaN(), infinity = std::numeric_limits<Real>::infinity();
constexpr std::array<Real, 8> numbers{0.0, -0.0, 1.0, -1.5, infinity, -infinity, nan, 1e-310};

std::array<std::uint64_t, 3> bits(const Vec3& a) {
  return {std::bit_cast<std::uint64_t>(a.x()), std::bit_cast<std::uint64_t>(a.y()),
          std::bit_cast<std::uint64_t>(a.z())};
}

/// Calls f for all vectors of `numbers`.
template <class F>
void for_each_vector(F f) {
  for (const Real x : numbers)
    for (const Real y : numbers)
      for (const Real z : numbers) f(Vec3(x, y, z));
}

TEST(Componentwise, GivesTheBitsOfEigen) {
  for_each_vector([](const Vec3& a) {
    for_each_vector([&](const Vec3& b) {
      ASSERT_EQ(bits(componentwise_min(a, b)), bits(a.cwiseMin(b)));
      ASSERT_EQ(bits(componentwise_max(a, b)), bits(a.cwiseMax(b)));
    });
    ASSERT_EQ(std::bit_cast<std::uint64_t>(min_component(a)), std::bit_cast<std::uint64_t>(a.minCoeff()));
    ASSERT_EQ(std::bit_cast<std::uint64_t>(max_component(a)), std::bit_cast<std::uint64_t>(a.maxCoeff()));
  });
}

TEST(Componentwise, TheNearestPointOfABoxIsWithinIt) {
  const Vec3 low(-1, -2, -3), high(1, 2, 3);
  EXPECT_EQ(nearest_in_box({5, 0, -7}, low, high), Vec3(1, 0, -3));
  EXPECT_EQ(nearest_in_box({0.5, -1, 2}, low, high), Vec3(0.5, -1, 2));
}

}  // namespace
}  // namespace godobject::test_componentwise
