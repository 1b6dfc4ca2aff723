// A view costs the loop only a copy of the record, and only on request.
#include "platform/view/frame.h"

#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <array>
#include <atomic>
#include <thread>

#include "platform/cli/run/loop.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "platform/view/live.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_tap {
namespace {

TEST(Latest, IsGivenOnRequestAndThenStays) {
  Latest<int> latest(0);
  EXPECT_FALSE(latest.wanted());
  EXPECT_EQ(latest.get(), nullptr);
  latest.ask();
  EXPECT_TRUE(latest.wanted());
  EXPECT_EQ(latest.get(), nullptr);
  latest.slot() = 7;
  latest.give();
  EXPECT_FALSE(latest.wanted());
  ASSERT_NE(latest.get(), nullptr);
  EXPECT_EQ(*latest.get(), 7);
}

TEST(Latest, IsNeverTornBetweenTwoThreads) {
  constexpr std::uint64_t num_values = 200'000;
  Latest<std::array<std::uint64_t, 64>> latest({});
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= num_values; ++i) {
      if (!latest.wanted()) continue;
      latest.slot().fill(i);
      latest.give();
    }
    done = true;
  });
  std::uint64_t last = 0;
  for (latest.ask(); !done;) {
    const auto* const value = latest.get();
    if (value == nullptr) continue;
    for (const std::uint64_t part : *value) ASSERT_EQ(part, value->front());
    ASSERT_GE(value->front(), last);
    last = value->front();
    latest.ask();
  }
  writer.join();
}

class TapOf : public testing::TestWithParam<const char*> {};

TEST_P(TapOf, LeavesTheLoopWithoutAllocationLockSystemCallAndFault) {
  const LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + GetParam());
  ASSERT_TRUE(loaded.scene.has_value());
  Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  LiveView view(*made.session, {}, nullptr);
  made.session->start(5);
  constexpr std::uint64_t num_cycles = 2000;
  Ring<CycleEntry> cycles(num_cycles, entry_of(*made.session));
  const std::atomic<bool> stop{false};
  RealtimeCycle cycle(*made.session, RunPlan{.num_cycles = num_cycles, .tap = &view.tap()}, stop, cycles);

  std::atomic<int> frames{0};
  std::atomic<bool> done{false};
  std::thread onlooker([&] {
    while (!done) {
      if (view.frame()) ++frames;
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  while (frames == 0 && cycle.cycle().left() > num_cycles / 2 && cycle(Wake{}))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  // as `run` does; otherwise code that was not yet used may have to come from the disk
  const bool is_locked = mlockall(MCL_CURRENT) == 0;
  rusage before{}, after{};
  getrusage(RUSAGE_THREAD, &before);
  long calls = 0;
  std::string report;
  {
    AllocationGuard guard;
    while (cycle(Wake{})) continue;
    guard.disarm();
    calls = guard.calls();
    report = guard.report();
  }
  getrusage(RUSAGE_THREAD, &after);
  munlockall();
  done = true;
  onlooker.join();
  if (AllocationGuard::works()) {
    EXPECT_EQ(calls, 0) << report;
    if (is_locked) {
      EXPECT_EQ(after.ru_majflt - before.ru_majflt, 0);
    }
  }
  EXPECT_GT(frames, 0);
}

INSTANTIATE_TEST_SUITE_P(Scenes, TapOf,
                         testing::Values("lego.toml", "organ.toml", "grasper.toml", "wall.toml"));

TEST(Tap, HoldsARunBackOnlyIfItMayBePaused) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/wall.toml");
  ASSERT_TRUE(loaded.scene.has_value());
  for (const bool paced : {false, true}) {
    Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
    ASSERT_NE(made.session, nullptr);
    ViewAbout about;
    about.takes_pace = paced;
    LiveView view(*made.session, about, nullptr);
    std::atomic<bool> stop{false};
    Ring<CycleEntry> cycles(64, entry_of(*made.session));
    RealtimeCycle cycle(*made.session, RunPlan{.num_cycles = 500, .tap = &view.tap()}, stop, cycles);
    made.session->start(5);
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(cycle(Wake{}));
    ASSERT_EQ(made.session->phase(), RunPhase::running);
    const std::uint64_t left = cycle.cycle().left();
    EXPECT_EQ(view.set_pace(1, {.steps = 3, .speed = 0}), paced);
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(cycle(Wake{}));
    EXPECT_EQ(cycle.cycle().left(), left - (paced ? 3 : 10));
    ViewBytes frame;
    for (int i = 0; i < 100 && !frame; ++i) {
      frame = view.frame();
      EXPECT_TRUE(cycle(Wake{}));
    }
    ASSERT_TRUE(frame) << "a paused run is shown";
    EXPECT_EQ((*frame)[25] & frame_paused, paced ? frame_paused : 0);
    view.leave(2);
    const std::uint64_t later = cycle.cycle().left();
    EXPECT_TRUE(cycle(Wake{}));
    EXPECT_EQ(cycle.cycle().left(), later - (paced ? 0 : 1)) << "another page leaves";
    if (paced) stop = true;
    static_cast<void>(cycle(Wake{}));
    EXPECT_NE(made.session->phase(), paced ? RunPhase::running : RunPhase::ended)
        << "a stop ends a paused run";
    view.leave(1);
  }
}

TEST(Tap, ChangesNothingOfTheRun) {
  const LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/organ.toml");
  ASSERT_TRUE(loaded.scene.has_value());
  std::array<std::uint64_t, 2> hashes{};
  for (const bool looks : {false, true}) {
    Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
    ASSERT_NE(made.session, nullptr);
    ViewTap tap(*made.session);
    const std::atomic<bool> stop{false};
    RunCycle cycle(*made.session, RunPlan{.num_cycles = 500, .tap = looks ? &tap : nullptr}, stop);
    made.session->start(5);
    CycleRecord record = made.session->at_start();
    for (int i = 0; !cycle.ended(); ++i) {
      if (i % 16 == 0) tap.ask();
      static_cast<void>(cycle.run(record));
      static_cast<void>(tap.get());
    }
    hashes[looks ? 1 : 0] = made.session->engine().state_hash();
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

}  // namespace
}  // namespace godobject::test_tap
