// A run with its device on hold for much of the time: shown by the status line, the faults and the summary.
#include <gmock/gmock.h>

#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "platform/cli/report/console.h"
#include "platform/cli/report/report.h"
#include "platform/rig/log_link.h"
#include "platform/scene/toml.h"

namespace godobject::test_held_run {
namespace {

using testing::Contains;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

SceneConfig rigid() {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  return *std::move(loaded.scene);
}

/// Prepares a session on buses without a simulation.
PreparedRun on_a_device(const SceneConfig& scene) {
  PreparedRun run;
  auto link = std::make_unique<LogLink>(*scene.device->rig, to_ns(scene.step));
  run.session = Session::make(scene, Motion(scene), std::move(link)).session;
  run.buses.real.texts = {"slcan:/dev/ttyACM0", "slcan:/dev/ttyACM1"};
  return run;
}

RunResult held(std::uint64_t cycles, std::uint64_t of) {
  RunResult result;
  result.ready = true;
  result.statistics.cycles = of;
  result.statistics.hold_cycles = result.statistics.held_cycles = cycles;
  result.statistics.holds = 1;
  return result;
}

std::string summary_of(const RunReport& report) {
  char* text = nullptr;
  std::size_t size = 0;
  std::FILE* const out = open_memstream(&text, &size);
  print_summary(out, report);
  std::fclose(out);
  std::string summary(text, size);
  std::free(text);
  return summary;
}

TEST(HeldRun, MoreThanFivePercentIsAFault) {
  const SceneConfig scene = rigid();
  const PreparedRun run = on_a_device(scene);
  ASSERT_TRUE(run.session);
  ASSERT_EQ(run.session->bus(), BusChoice::real);
  const RunOptions options;
  const auto is_held = Contains(Field(&FaultReport::name, "held"));
  for (const std::uint64_t few : {0u, 50u, 300u})
    EXPECT_THAT(make_report(options, run, held(few, 6000), {}).faults, Not(is_held)) << few;
  for (const std::uint64_t many : {301u, 3973u, 5988u}) {
    const RunResult result = held(many, 6000);
    RunReport report = make_report(options, run, result, {});
    ASSERT_THAT(report.faults, is_held) << many;
    EXPECT_THAT(summary_of(report), HasSubstr(std::to_string(many) + " of 6000 cycles"));
    EXPECT_THAT(summary_of(report), HasSubstr("docs/running.md"));
  }
}

/// Faults of the rig, which are reported anyway, begin with missing samples.
TEST(HeldRun, MissingSamplesCountUnlessTheRigHasAFault) {
  const SceneConfig scene = rigid();
  const PreparedRun run = on_a_device(scene);
  RunResult result;
  result.ready = true;
  CycleRecord record = run.session->at_start();
  for (int i = 0; i < 1000; ++i) {
    record.limited = i % 10 == 0 ? Limited::held : Limited::none;
    result.statistics.add(record);
  }
  const RunOptions options;
  const auto is_held = Contains(Field(&FaultReport::name, "held"));
  const std::vector<FaultReport> faults = make_report(options, run, result, {}).faults;
  ASSERT_THAT(faults, is_held);
  EXPECT_THAT(faults,
              Contains(Field(&FaultReport::text, HasSubstr("100 of 1000 cycles (10.0 %), 0 after missed "
                                                           "deadlines, 100 for want of a sample"))));
  record.rig_faults = RigFault::sample_stale;
  result.statistics.add(record);
  EXPECT_EQ(result.statistics.held_cycles, 100u);
  EXPECT_THAT(make_report(options, run, result, {}).faults, Not(is_held));
}

TEST(HeldRun, WhatTheKernelKeptIsInTheSummary) {
  const SceneConfig scene = rigid();
  const PreparedRun run = on_a_device(scene);
  const RunResult result = held(0, 6000);
  const RunOptions options;
  RunReport report = make_report(options, run, result, {});
  ASSERT_FALSE(report.buses.empty());
  EXPECT_THAT(summary_of(report), Not(HasSubstr("WARNING                    can0: /dev")));
  report.buses[0].slowness = "/dev/ttyACM0: 7 reads or writes of this terminal were delayed";
  EXPECT_THAT(summary_of(report), HasSubstr("7 reads or writes"));
}

TEST(HeldRun, TheStatusLineHasTheShare) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const SceneConfig scene = rigid();
  const PreparedRun run = on_a_device(scene);
  {
    BackgroundFile console(ends[1], 1 << 16);
    StatusLine line(console, false);
    CycleRecord record = run.session->at_start();
    for (int i = 1; i <= 4000; ++i) {
      record.t = 1e-3 * i;
      record.on_hold = i > 2000 && i <= 2250;
      record.limited = i > 2250 && i <= 2500 ? Limited::held : Limited::none;
      line.update(record, 0);
    }
    static_cast<void>(console.close(BackgroundFile::Clock::now() + std::chrono::seconds(2)));
  }
  ::close(ends[1]);
  std::string text;
  std::array<char, 4096> buffer{};
  for (ssize_t n = 0; (n = read(ends[0], buffer.data(), buffer.size())) > 0;)
    text.append(buffer.data(), static_cast<std::size_t>(n));
  ::close(ends[0]);
  EXPECT_THAT(text, testing::ContainsRegex("t    2.00 s.*ok\n"));
  EXPECT_THAT(text, testing::ContainsRegex("t    3.00 s.*HELD 17 %\n"));
  EXPECT_THAT(text, testing::ContainsRegex("t    4.00 s.*HELD 12 %\n"));
}

}  // namespace
}  // namespace godobject::test_held_run
