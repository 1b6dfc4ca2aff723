// Equal runs have equal bits. Between compilers and optimisation levels: tests/determinism.
#include <gtest/gtest.h>

#include <memory>

#include "tests/core/one_body.h"

namespace godobject::test_determinism {
namespace {

using Scenes = ::testing::Types<OneBody<ImplicitEuler, PoseDevice, DampedSpring, LimitedFeedback>,
                                OneBody<TrBdf2, PoseDevice, DampedSpring, LimitedFeedback>>;

template <class S>
class Determinism : public ::testing::Test {
 protected:
  using Simulation = Running<S>;

  /// In fresh memory filled with `garbage`, so that nothing uninitialised can go unnoticed.
  static std::uint64_t hash_after(int steps, unsigned char garbage, Real p_x = 0.1) {
    alignas(Simulation) static std::array<unsigned char, sizeof(Simulation)> memory;
    memory.fill(garbage);
    auto* run = new (memory.data()) Simulation;
    set_up(*run);
    for (int n = 0; n < steps; ++n) move(*run, n, p_x);
    const std::uint64_t hash = run->hash();
    run->~Simulation();
    return hash;
  }

  static void set_up(Simulation& run) {
    run.constants().body = rigid_body(0.2, Vec3(2e-3, 1e-3, 1.5e-3).asDiagonal());
    run.constants().coupling = {.k = 2000, .g = 30, .k_r = 4, .g_r = 0.15};
    run.constants().feedback.gains = {.k = 1000, .g = 2, .k_r = 2, .g_r = 0.05};
  }
  static void move(Simulation& run, int n, Real p_x) {
    const Real a = 2e-3 * n;
    run.device().target.X_WD = {.p = Vec3(p_x, std::sin(a), 0), .q = Quat(std::cos(a), 0, std::sin(a), 0)};
    run.step();
  }
};
TYPED_TEST_SUITE(Determinism, Scenes);

TYPED_TEST(Determinism, TwoRunsHaveEqualHashes) {
  EXPECT_EQ(this->hash_after(5000, 0x00), this->hash_after(5000, 0xff));
}

TYPED_TEST(Determinism, HashSeesTheLastBitOfTheInput) {
  EXPECT_NE(this->hash_after(200, 0), this->hash_after(200, 0, std::nextafter(0.1, 1)));
  EXPECT_NE(this->hash_after(200, 0), this->hash_after(201, 0));
}

/// State is all that carries over: a copy of it, with fresh scratch and output, goes on alike.
TYPED_TEST(Determinism, ARestoredStateGoesOnAlike) {
  auto run = std::make_unique<Running<TypeParam>>(), other = std::make_unique<Running<TypeParam>>();
  this->set_up(*run);
  this->set_up(*other);
  for (int n = 0; n < 500; ++n) this->move(*run, n, 0.1);
  other->x = run->x;
  for (int n = 500; n < 1000; ++n) {
    this->move(*run, n, 0.1);
    this->move(*other, n, 0.1);
    ASSERT_EQ(run->hash(), other->hash()) << n;
  }
}

}  // namespace
}  // namespace godobject::test_determinism
