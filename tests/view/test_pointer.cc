// The page's pointer: its samples have limits, become stale, and come from one hand at a time; its tool stops
// at the wall.
#include "platform/view/pointer.h"

#include <gtest/gtest.h>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_pointer {
namespace {

constexpr Nanoseconds ms = 1'000'000;
Nanoseconds now_ns = 0;

SceneConfig wall_scene() {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/wall.toml");
  lead_by_pointer(*loaded.scene);
  return *loaded.scene;
}

/// A session with a pointer as its device, and a clock of the test's own.
class PointerTest : public testing::Test {
 protected:
  PointerTest() {
    now_ns = 1'000 * ms;
    made = make_session(scene, Motion(scene), BusChoice::direct);
    made.session->add(pointer);
    made.session->start(1);
    record = made.session->at_start();
  }

  /// Runs periods of the loop, with a message of the page every 16 of them.
  void run(int periods, const Vec3& shift_per_message = Vec3::Zero(),
           const Vec3& turn_per_message = Vec3::Zero()) {
    for (int i = 0; i < periods; ++i) {
      now_ns += ms;
      if (says && i % 16 == 0)
        say({.holds = true, .moves = true, .dp_W = shift_per_message, .dphi_W = turn_per_message});
      static_cast<void>(made.session->advance(record));
      if (has(record.limited, Limited::held)) ++periods_held;
    }
  }
  bool say(PointerMessage message, std::uint64_t client = 1) {
    message.number = ++number;
    return pointer.take(client, message, record.bodies[0].X_WB.p);
  }
  const Vec3& tool() const { return record.bodies[0].X_WB.p; }
  const Vec3& target() const { return record.bodies[0].target.X_WD.p; }

  SceneConfig scene = wall_scene();
  PointerDevice pointer{scene, []() noexcept { return now_ns; }};
  Session::Made made;
  CycleRecord record;
  std::uint32_t number = 0;
  bool says = true;
  int periods_held = 0;
};

constexpr double wall_x = 0.08, half_width = 0.015;

TEST_F(PointerTest, GripsWithoutMotion) {
  const Vec3 before = tool();
  run(500);
  EXPECT_EQ(record.held, 0u);
  EXPECT_LT((tool() - before).norm(), 1e-9);
}

TEST_F(PointerTest, MovesTheToolWhereItIsFree) {
  run(300);
  periods_held = 0;  // until there were enough samples to play
  run(800, Vec3(0, 0, 0.001));
  run(600);
  EXPECT_NEAR(target().z(), 0.05, 1e-6);
  EXPECT_NEAR(tool().z(), 0.05, 1e-4);
  EXPECT_EQ(periods_held, 0);
}

TEST_F(PointerTest, StopsTheToolAtTheWallAndNotTheDevice) {
  run(300);
  run(1600, Vec3(0.0015, 0, 0));
  run(600);
  EXPECT_NEAR(target().x(), 0.15, 1e-6);
  EXPECT_LT(tool().x(), wall_x - half_width + 0.002) << "a god-object is never inside the wall";
  EXPECT_GT(tool().x(), wall_x - half_width - 0.002);
  EXPECT_LT(record.hand_W.f.x(), -5) << "the hand is pushed back";
  EXPECT_LE(record.hand_W.f.norm(), scene.device->limits.force * (1 + 1e-9));
}

TEST_F(PointerTest, IsNoFasterThanAllowed) {
  run(300);
  double fastest = 0;
  for (int i = 0; i < 400; ++i) {
    const Vec3 before = target();
    run(1, Vec3(0, 0, -0.9));
    fastest = std::max(fastest, (target() - before).norm() / scene.step);
  }
  EXPECT_LT(fastest, (1 + 1e-6) * max_pointer_speed) << "of what was asked for, 56 m/s";
  EXPECT_GT(fastest, 0.9 * max_pointer_speed);
}

TEST_F(PointerTest, IsStaleAfterThreePeriods) {
  run(500);
  periods_held = 0;
  says = false;
  run(static_cast<int>(pointer_stale_ns / ms) - 20);
  EXPECT_EQ(periods_held, 0);
  run(100);
  EXPECT_GT(periods_held, 50);
  EXPECT_EQ(record.hand_W.f.norm(), 0);
}

TEST_F(PointerTest, ReleasesWhenItsPageIsGone) {
  run(500);
  ASSERT_EQ(record.held, 0u);
  pointer.leave(2);
  run(2);
  EXPECT_EQ(record.held, 0u) << "another page";
  says = false;
  pointer.leave(1);
  run(2);
  EXPECT_EQ(record.held, std::nullopt);
}

TEST_F(PointerTest, ListensToOneHandAtATime) {
  run(100);
  EXPECT_FALSE(say({.holds = true, .moves = true, .dp_W = Vec3(0.1, 0, 0)}, 2));
  EXPECT_FALSE(pointer.take(1, {.number = 1, .holds = true}, Vec3::Zero())) << "an old number";
  EXPECT_FALSE(say({.holds = true, .target = 1})) << "there is one body";
  EXPECT_TRUE(say({.holds = false}));
  EXPECT_TRUE(say({.holds = true}, 2));
}

TEST_F(PointerTest, WithItsClutchOpenMovesNothing) {
  run(300);
  const Vec3 before = target();
  for (int i = 0; i < 50; ++i) {
    now_ns += 16 * ms;
    ASSERT_TRUE(say({.holds = true, .moves = false, .dp_W = Vec3(0.01, 0, 0)}));
    static_cast<void>(made.session->advance(record));
  }
  EXPECT_LT((target() - before).norm(), 1e-12);
}

TEST_F(PointerTest, TouchesNeitherHeapNorSystemInTheLoop) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  run(300);
  AllocationGuard guard;
  run(300, Vec3(0.001, 0, 0), Vec3(0, 0.01, 0));
  EXPECT_EQ(guard.calls(), 0) << guard.report();
}

}  // namespace
}  // namespace godobject::test_pointer
