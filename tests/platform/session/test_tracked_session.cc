// A body that follows a simulated tracker, in the same loop as with real ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_tracked_session {
namespace {

using testing::HasSubstr;

SceneConfig tracked_scene() { return *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/tracked.toml").scene; }

FaultConfig fault(const std::string& verb, double at) {
  FaultConfig config;
  config.verb = verb;
  config.tracker = "polaris";
  config.at = at;
  return config;
}

struct TrackedSession {
  explicit TrackedSession(const SceneConfig& scene = tracked_scene()) {
    Session::Made made = make_session(scene, Motion(scene), BusChoice::sim);
    EXPECT_THAT(made.errors, testing::IsEmpty());
    session = std::move(made.session);
    record = session->at_start();
  }
  void run(int cycles) {
    for (int i = 0; i < cycles; ++i) {
      ASSERT_TRUE(session->advance(record));
      EXPECT_EQ(record.fault, Fault::none);
    }
  }

  std::unique_ptr<Session> session;
  CycleRecord record;
};

TEST(TrackedSession, TheBodyFollowsTheHandAsLateAsATrackerIs) {
  TrackedSession tracked;
  ASSERT_TRUE(tracked.session->boot(10)) << tracked.session->trackers()->report(0).text.data();
  EXPECT_EQ(tracked.session->bus(), BusChoice::sim);
  tracked.run(1500);
  double worst_m = 0, least_m = 1;
  for (int i = 0; i < 2000; ++i) {
    tracked.run(1);
    EXPECT_TRUE(tracked.record.engaged);
    worst_m = std::max(worst_m, tracked.record.sensing.m);
    least_m = std::min(least_m, tracked.record.exact_following.m);
  }
  EXPECT_GT(worst_m, 1e-3) << "poses are some 30 ms old";
  EXPECT_LT(worst_m, 0.03) << "of a hand that moves 0.4 m/s";
  EXPECT_LT(tracked.record.exact_following.m, worst_m);
  const TrackerCounters& counters = tracked.session->trackers()->report(0).counters;
  EXPECT_GT(counters.samples, 200u);
  EXPECT_EQ(counters.bad_crc, 0u);
}

TEST(TrackedSession, TwoRunsAreTheSameBitForBit) {
  SceneConfig scene = tracked_scene();
  scene.faults = {fault("corrupt", 0.5)};
  std::array<std::uint64_t, 2> hashes{};
  for (std::uint64_t& hash : hashes) {
    TrackedSession tracked(scene);
    ASSERT_TRUE(tracked.session->boot(10));
    tracked.run(2000);
    EXPECT_GT(tracked.session->trackers()->report(0).counters.bad_crc, 0u);
    hash = tracked.session->engine().state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(TrackedSession, AHiddenToolIsNoFault) {
  SceneConfig scene = tracked_scene();
  scene.faults = {fault("missing", 1)};
  scene.faults[0].duration = 0.5;
  TrackedSession tracked(scene);
  ASSERT_TRUE(tracked.session->boot(10));
  tracked.run(1300);
  EXPECT_TRUE(has(tracked.record.limited, Limited::held));
  EXPECT_EQ(tracked.session->trackers()->poses()[0].state, ToolState::missing);
  tracked.run(700);
  EXPECT_FALSE(has(tracked.record.limited, Limited::held));
  EXPECT_EQ(tracked.session->trackers()->poses()[0].state, ToolState::valid);
}

TEST(TrackedSession, ATrackerThatDoesNotComeUpEndsTheBoot) {
  SceneConfig scene = tracked_scene();
  scene.faults = {fault("unplug", 0)};
  scene.device->trackers[0].boot_timeout_s = 3;
  TrackedSession tracked(scene);
  EXPECT_FALSE(tracked.session->boot(1));
  EXPECT_EQ(tracked.session->phase(), RunPhase::ended);
  const TrackerReport& report = tracked.session->trackers()->report(0);
  EXPECT_NE(report.state, TrackerState::tracking);
  EXPECT_GT(std::string(report.text.data()).size(), 15u) << report.text.data();
  const double t = 1e-9 * static_cast<double>(tracked.session->bus_time_ns());
  EXPECT_GE(t, 3);
  EXPECT_LE(t, 5.1) << "its last try may still be going on";
}

TEST(TrackedSession, ReachesNoBodyWithoutATracker) {
  const SceneConfig scene = tracked_scene();
  const Session::Made made = Session::make(scene, Motion(scene), DeviceParts{});
  EXPECT_FALSE(made.session);
  ASSERT_EQ(made.errors.size(), 1u);
  EXPECT_THAT(made.errors[0], HasSubstr("--tracker polaris=PORT"));
}

TEST(TrackedSession, DirectHasNoTracker) {
  const SceneConfig scene = tracked_scene();
  const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  ASSERT_TRUE(made.session);
  EXPECT_EQ(made.session->trackers(), nullptr);
  EXPECT_TRUE(made.session->boot(1));
}

TEST(TrackedSession, DoesNotAllocate) {
  SceneConfig scene = tracked_scene();
  scene.faults = {fault("drop", 0.2), fault("delay", 0.3), fault("disabled", 0.4)};
  scene.faults[0].value = 0.2;
  TrackedSession tracked(scene);
  tracked.session->start(10);
  AllocationGuard guard;
  for (int i = 0; i < 5000; ++i) static_cast<void>(tracked.session->advance(tracked.record));
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_GT(tracked.record.cycle, 1000u);
}

}  // namespace
}  // namespace godobject::test_tracked_session
