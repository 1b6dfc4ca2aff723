// All steps of the setup report a result, whatever this machine permits.
#include "platform/rt/setup.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

TEST(RtSetup, TableShowsResultDetailAndRemedy) {
  const std::vector<RtStep> steps{
      {.name = "priority", .result = RtResult::degraded, .detail = "EPERM text", .remedy = "do this"}};
  const std::string table = rt_table(steps);
  for (const char* part : {"priority", "degraded", "EPERM text", "-> do this"})
    EXPECT_THAT(table, testing::HasSubstr(part));
}

}  // namespace
}  // namespace godobject::test_rt_setup
