// All steps of the setup report a result, whatever this machine permits.
#include "platform/rt/setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sched.h>

#include <thread>

namespace godobject::test_rt_setup {
namespace {

TEST(RtSetup, EveryStepSaysWhatIsInEffectAndWhatToDo) {
  // In a thread of its own, so that this one keeps its scheduling class.
  std::vector<RtStep> steps;
  std::thread([&] { steps = set_up_rt_thread(); }).join();
  {
    const RtProcess process;
    steps.insert(steps.end(), process.steps().begin(), process.steps().end());
  }
  EXPECT_EQ(steps.size(), 6u);
  for (const RtStep& step : steps) {
    EXPECT_FALSE(step.detail.empty()) << step.name;
    EXPECT_EQ(step.remedy.empty(), step.result == RtResult::ok) << step.name;
    EXPECT_THAT(rt_table(steps), testing::HasSubstr(step.name));
  }
}

TEST(RtSetup, TheLoopHasItsCoreAndOtherThreadsTheRest) {
  cpu_set_t before;
  ASSERT_EQ(sched_getaffinity(0, sizeof before, &before), 0);
  if (CPU_COUNT(&before) < 2) GTEST_SKIP() << "one core";
  unsigned core = CPU_SETSIZE - 1;
  while (!CPU_ISSET(core, &before)) --core;
  cpu_set_t of_loop, of_other, of_main;
  {
    const RtProcess process({}, {.core = core});
    EXPECT_EQ(process.steps().back().name, "other threads");
    EXPECT_EQ(process.steps().back().result, RtResult::ok) << process.steps().back().detail;
    std::thread([&] {
      EXPECT_NE(set_up_rt_thread({}, {.core = core}).front().result, RtResult::failed);
      sched_getaffinity(0, sizeof of_loop, &of_loop);
    }).join();
    std::thread([&] { sched_getaffinity(0, sizeof of_other, &of_other); }).join();
    sched_getaffinity(0, sizeof of_main, &of_main);
  }
  EXPECT_TRUE(CPU_ISSET(core, &of_loop));
  EXPECT_EQ(CPU_COUNT(&of_loop), 1);
  EXPECT_FALSE(CPU_ISSET(core, &of_other));
  EXPECT_FALSE(CPU_ISSET(core, &of_main));
  EXPECT_EQ(CPU_COUNT(&of_main), CPU_COUNT(&before) - 1);
  ASSERT_EQ(sched_setaffinity(0, sizeof before, &before), 0);
}

TEST(RtSetup, TheLoopHasSchedDeadlineWherePermitted) {
  constexpr int sched_deadline = 6;
  RtStep step;
  int policy = -1;
  std::thread([&] {
    step = set_up_rt_thread({}, {.runtime_ns = 200'000, .period_ns = 1'000'000}).front();
    policy = sched_getscheduler(0);
  }).join();
  EXPECT_EQ(step.name, "deadline");
  if (step.result == RtResult::failed) GTEST_SKIP() << step.detail << " -> " << step.remedy;
  EXPECT_EQ(policy, sched_deadline);
}

TEST(RtSetup, TableShowsResultDetailAndRemedy) {
  const std::vector<RtStep> steps{
      {.name = "priority", .result = RtResult::degraded, .detail = "EPERM text", .remedy = "do this"}};
  const std::string table = rt_table(steps);
  for (const char* part : {"priority", "degraded", "EPERM text", "-> do this"})
    EXPECT_THAT(table, testing::HasSubstr(part));
}

}  // namespace
}  // namespace godobject::test_rt_setup
