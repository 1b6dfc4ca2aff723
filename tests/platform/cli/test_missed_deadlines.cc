// Effects of missed deadlines on a run, period by period, without a clock.
#include <gtest/gtest.h>

#include "platform/cli/run/loop.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_missed_deadlines {
namespace {

class Watched {
 public:
  Watched(const char* name, BusChoice bus) {
    LoadResult loaded = load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + name);
    Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), bus);
    session = std::move(made.session);
    cycle.emplace(*session, RunPlan{.num_cycles = 100'000}, stop);
    record = session->at_start();
    session->start(5);
    while (session->phase() == RunPhase::booting) period({.skipped = 50});  // booting has no deadlines
  }

  void period(const Wake& wake = {}) {
    cycle->watch(wake);
    static_cast<void>(cycle->run(record));
  }
  void periods(int n) {
    for (int i = 0; i < n; ++i) period();
  }
  double force() const { return record.bodies[0].feedback_D.f.norm(); }
  double torque_Nm() const {
    double most = 0;
    for (std::size_t i = 0; i < session->rig()->num_drives(); ++i)
      most = std::max(most, std::abs(session->rig()->commanded_torque_Nm(i)));
    return most;
  }

  std::unique_ptr<Session> session;
  std::atomic<bool> stop = false;
  std::optional<RunCycle> cycle;
  CycleRecord record;
};

/// Without a rig they are faults of the run, each an event once.
TEST(MissedDeadlines, WithoutARigTheyAreAnEventAsIsAnOscillation) {
  Watched run("rigid.toml", BusChoice::direct);
  Ring<RunEventMark> marks(16);
  EventWatch watch(marks);
  run.cycle->tell(watch);
  run.periods(10);
  for (int i = 0; i < 30; ++i) run.period({.skipped = 1, .late_before = true});
  run.record.force_oscillates = true;
  watch.look(*run.session, run.record, true);
  watch.look(*run.session, run.record, true);
  std::vector<RunFault> seen;
  for (RunEventMark mark; marks.try_pop(mark);) {
    EXPECT_EQ(mark.kind, RunEventKind::run_fault);
    EXPECT_TRUE(is_fault(mark.kind));
    seen.push_back(mark.run_fault);
  }
  EXPECT_EQ(seen, (std::vector{RunFault::deadlines_missed, RunFault::force_oscillates}));
}

TEST(MissedDeadlines, FourOfThemAreNone) {
  Watched run("rigid.toml", BusChoice::sim);
  run.periods(2000);
  run.period({.skipped = 3, .late_before = true});
  for (int i = 0; i < 200; ++i) {
    run.period();
    EXPECT_FALSE(run.record.on_hold);
    EXPECT_FALSE(has(run.record.limited, Limited::held));
  }
  EXPECT_EQ(run.cycle->statistics().holds, 0u);
}

TEST(MissedDeadlines, FiveHoldThePoseAndTheForceFadesThenComesBack) {
  Watched run("rigid.toml", BusChoice::sim);
  run.periods(2200);
  ASSERT_GT(run.force(), 0.02);
  run.period({.skipped = 5});
  const double h = run.session->scene().step, rate = run.session->scene().device->limits.force_rate;
  int held = 0;
  for (; run.record.on_hold && held < 300; ++held) {
    const double before = run.force();
    run.period();
    EXPECT_LE(std::abs(run.force() - before), rate * h * (1 + 1e-9));
    if (!run.record.on_hold) continue;
    EXPECT_TRUE(held <= 3 || has(run.record.limited, Limited::held)) << held;
    EXPECT_TRUE(held <= 20 || run.force() == 0) << held;
  }
  EXPECT_NEAR(held, 95, 3) << "until 100 ms had fewer than five";
  double strongest = 0;
  for (int i = 0; i < 250; ++i) {
    run.period();
    strongest = std::max(strongest, run.force());
  }
  EXPECT_LT(strongest, 0.05) << "by the ramp";
  run.periods(1500);
  EXPECT_GT(run.force(), 0.01);
  EXPECT_EQ(run.cycle->statistics().holds, 1u);
  EXPECT_EQ(run.session->rig()->faults(), RigFault::none) << run.session->rig()->fault_text();
}

TEST(MissedDeadlines, TwentyInARowAreAFaultThatStays) {
  Watched run("rigid.toml", BusChoice::sim);
  run.periods(2200);
  ASSERT_GT(run.torque_Nm(), 0);
  for (int i = 0; i < 19; ++i) run.period({.late_before = true});
  EXPECT_EQ(run.session->rig()->faults(), RigFault::none);
  run.period({.late_before = true});
  EXPECT_EQ(run.session->rig()->faults(), RigFault::deadlines_missed);
  EXPECT_NE(run.session->rig()->fault_text().find("deadlines_missed (host)"), std::string::npos);
  run.periods(100);
  EXPECT_EQ(run.torque_Nm(), 0);
  run.periods(1000);
  EXPECT_EQ(run.torque_Nm(), 0);
  EXPECT_EQ(run.record.rig_faults, RigFault::deadlines_missed);
}

TEST(MissedDeadlines, AForceThatWasAwayFor2sDoesNotReturnUnasked) {
  Watched run("rigid.toml", BusChoice::sim);
  run.periods(2200);
  ASSERT_GT(run.torque_Nm(), 0);
  for (int i = 0; i < 1900; ++i) run.period({.late_before = i % 19 == 0});
  EXPECT_TRUE(run.record.on_hold);
  EXPECT_EQ(run.session->rig()->faults(), RigFault::none) << run.session->rig()->fault_text();
  for (int i = 0; i < 300; ++i) run.period({.late_before = i % 19 == 0});
  EXPECT_EQ(run.session->rig()->faults(), RigFault::deadlines_missed);
  for (int i = 0; i < 2000; ++i) {
    run.period();
    ASSERT_EQ(run.torque_Nm(), 0) << i;
  }
}

TEST(MissedDeadlines, WithoutARigTheRunHasTheFault) {
  for (const char* scene : {"rigid.toml", "tracked.toml"}) {
    Watched run(scene, BusChoice::direct);
    run.periods(500);
    run.period({.skipped = 20});
    EXPECT_TRUE(run.session->missed_deadlines());
    run.periods(500);
    EXPECT_TRUE(run.record.on_hold);
    EXPECT_TRUE(has(run.record.limited, Limited::held));
  }
}

}  // namespace
}  // namespace godobject::test_missed_deadlines
