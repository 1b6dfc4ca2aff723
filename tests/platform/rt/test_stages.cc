// The watch of a cycle's stages on a clock controlled by the test.
#include "platform/rt/stages.h"

#include <gmock/gmock.h>

namespace godobject::test_stages {
namespace {

using testing::ElementsAre;

/// Each reading is 1 ns after the last, besides the time that a test lets pass.
Nanoseconds t_ns = 0;
Nanoseconds ticking() noexcept GODOBJECT_NONBLOCKING { return ++t_ns; }

TEST(StageWatch, AddsTheTimeOfEachStageAndOfThoseWithinIt) {
  StageWatch watch;
  watch.set_clock(ticking);
  watch.start(Stage::decode);
  t_ns += 100;
  for (int frame = 0; frame < 2; ++frame) {
    const InStage stage(watch, Stage::receive);
    t_ns += 10;
    const InStage waiting(watch, Stage::wait);
    t_ns += 1000;
  }
  watch.enter(Stage::observe);
  t_ns += 5;
  const StageTimes& times = watch.stop();
  EXPECT_THAT(times, ElementsAre(2 * 1001, 2 * (11 + 1), 101 + 1 + 1, 0, 0, 0, 0, 6));
  EXPECT_EQ(compute_time(times), 24 + 103 + 6);
  EXPECT_EQ(watch.spent(Stage::receive), 24);
}

TEST(StageWatch, StartsEachCycleAtZero) {
  StageWatch watch;
  watch.set_clock(ticking);
  watch.start(Stage::step);
  t_ns += 100;
  watch.stop();
  watch.start(Stage::limit);
  EXPECT_THAT(watch.stop(), ElementsAre(0, 0, 0, 0, 1, 0, 0, 0));
}

TEST(StageWatch, MeasuresNothingWithoutAClock) {
  StageWatch watch;
  watch.start(Stage::step);
  EXPECT_THAT(watch.stop(), testing::Each(0));
}

}  // namespace
}  // namespace godobject::test_stages
