// A page starts a run without hardware again, with the same bits. Runs with hardware, and those whose steps
// are written to a file, refuse this.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "platform/cli/run/options.h"
#include "platform/simulated/session.h"
#include "platform/view/live.h"

namespace godobject::test_reset {
namespace {

constexpr std::uint64_t num_cycles = 300;

RunOptions options_of(const std::string& scene) {
  RunOptions options;
  options.scene = GODOBJECT_SOURCE_DIR "/sim/scenes/" + scene;
  options.quiet = true;
  options.parts.simulated = simulated_devices();
  return options;
}

/// Runs a prepared run for num_cycles. Returns the hash of its state.
std::uint64_t hash_after(PreparedRun& run) {
  run.plan.num_cycles = num_cycles;
  RunFiles files({}, run.session->scene(), 0);
  const RunResult result = run_fast(*run.session, run.plan, files);
  EXPECT_FALSE(result.is_reset);
  EXPECT_EQ(result.statistics.cycles, num_cycles);
  return run.session->engine().state_hash();
}

class Reset : public testing::TestWithParam<const char*> {};

TEST_P(Reset, StartsTheRunAgainWithTheSameBits) {
  const RunOptions options = options_of(GetParam());
  PreparedRun run = prepare(options);
  ASSERT_NE(run.session, nullptr);
  EXPECT_EQ(why_no_reset(options, run), "");
  const std::uint64_t at_start = run.session->engine().state_hash();
  const std::uint64_t hash = hash_after(run);
  EXPECT_NE(hash, at_start);

  ViewAbout about;
  about.no_reset = "";
  LiveView view(*run.session, about, nullptr);
  run.plan.tap = &view.tap();
  run.plan.num_cycles = 1'000'000;
  PreparedRun second = prepare_again(options, run);
  ASSERT_NE(second.session, nullptr);
  EXPECT_EQ(second.session->engine().state_hash(), at_start);
  EXPECT_EQ(view.reset(), "");
  RunFiles files({}, second.session->scene(), 0);
  EXPECT_TRUE(run_fast(*second.session, run.plan, files).is_reset) << "a reset ends the loop";

  PreparedRun third = prepare_again(options, run);
  ASSERT_NE(third.session, nullptr);
  view.restart(*third.session, nullptr, nullptr);
  third.plan.tap = &view.tap();
  EXPECT_EQ(hash_after(third), hash);
}

INSTANTIATE_TEST_SUITE_P(Scenes, Reset,
                         testing::Values("wall.toml", "grasper.toml", "tracked.toml", "organ.toml"));

TEST(ResetOfAPausedRun, EndsTheLoopAndStaysPaused) {
  RunOptions options = options_of("wall.toml");
  options.view = 0;
  options.view_input = true;
  PreparedRun run = prepare(options);
  ASSERT_NE(run.session, nullptr);
  ViewAbout about;
  about.takes_pace = true;
  about.no_reset = why_no_reset(options, run);
  LiveView view(*run.session, about, run.pointer.get());
  run.plan.tap = &view.tap();
  const std::atomic<bool> stop{false};
  Ring<CycleEntry> cycles(64, entry_of(*run.session));
  RealtimeCycle cycle(*run.session, run.plan, stop, cycles);
  run.session->start(5);
  EXPECT_TRUE(view.set_pace(1, {.steps = 0, .speed = 0}));
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(cycle(Wake{}));
  EXPECT_EQ(view.reset(), "");
  EXPECT_FALSE(cycle(Wake{}));
  EXPECT_TRUE(cycle.cycle().is_reset());

  PreparedRun again = prepare_again(options, run);
  ASSERT_NE(again.session, nullptr);
  ASSERT_NE(again.pointer, nullptr);
  view.restart(*again.session, again.pointer.get(), nullptr);
  EXPECT_FALSE(view.tap().is_reset());
  EXPECT_TRUE(view.tap().pace()->paused());
}

TEST(ResetOfARun, IsLeftToASignal) {
  PreparedRun run = prepare(options_of("wall.toml"));
  ASSERT_NE(run.session, nullptr);
  ViewTap tap(*run.session);
  run.plan.tap = &tap;
  std::atomic<bool> stop{false};
  RunCycle cycle(*run.session, run.plan, stop);
  EXPECT_FALSE(cycle.is_reset());
  tap.reset();
  EXPECT_TRUE(cycle.is_reset());
  stop = true;
  EXPECT_FALSE(cycle.is_reset());
}

TEST(ResetOfARun, IsRefusedWithItsReason) {
  const auto reason = [](RunOptions options) {
    const PreparedRun run = prepare(options);
    if (!run.session) return run.errors.empty() ? std::string("no session") : run.errors.front();
    const std::string why_not = why_no_reset(options, run);
    ViewAbout about;
    about.no_reset = why_not;
    LiveView view(*run.session, about, nullptr);
    EXPECT_EQ(view.reset(), why_not);
    EXPECT_EQ(view.tap().is_reset(), why_not.empty());
    return why_not;
  };
  RunOptions options = options_of("grasper.toml");
  options.buses = {"pty:"};
  EXPECT_EQ(reason(options), "this run has hardware, which cannot go back: stop the run, and start it again");
  for (const auto name : {&RunFileNames::trace, &RunFileNames::contacts, &RunFileNames::record,
                          &RunFileNames::inputs, &RunFileNames::on_fault}) {
    options = options_of(name == &RunFileNames::record ? "grasper.toml" : "wall.toml");  // frames need a bus
    options.files.*name = testing::TempDir() + "reset.godo";
    EXPECT_EQ(reason(options),
              "this run writes " + testing::TempDir() +
                  "reset.godo, whose steps follow one another: stop the run, and start it again");
  }
  options = options_of("grasper.toml");
  options.report = testing::TempDir() + "reset.json";
  EXPECT_EQ(reason(options), "");
  const PreparedRun run = prepare(options);
  LiveView of_another_program(*run.session, {}, nullptr);
  EXPECT_NE(of_another_program.reset(), "");
  EXPECT_FALSE(of_another_program.tap().is_reset());
}

}  // namespace
}  // namespace godobject::test_reset
