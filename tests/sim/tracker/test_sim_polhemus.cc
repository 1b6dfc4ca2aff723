#include "sim/tracker/polhemus.h"

#include <gtest/gtest.h>

#include "tests/support/simulated_tracker.h"

namespace godobject::test_sim_polhemus {
namespace {

using polhemus::Model;
using test::SimulatedTracker;

const Pose here{.p = Vec3(0.4, 0.1, -0.2), .q = Quat(0.5, 0.5, -0.5, 0.5)};

struct Hand : SimulatedTracker {
  explicit Hand(Model model) : SimulatedTracker(make_tracker(params(), {}).tracker, nullptr) {
    far = std::make_unique<SimPolhemus>(params(), 120, 1, model);
    far->set_pose(0, here);
    far->set_pose(1, {.p = -here.p, .q = here.q});
  }
  static TrackerParams params() { return test::tracker_params(TrackerProtocol::polhemus, {"1", "3"}); }
};

TEST(SimPolhemus, EitherModelIsFoundOut) {
  for (const Model model : {Model::fastrak, Model::liberty}) {
    Hand rig(model);
    ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
    rig.run(1);
    EXPECT_EQ(rig.tool(0).state, ToolState::valid);
    EXPECT_EQ(rig.tool(1).state, ToolState::valid);
    EXPECT_LT((rig.tool(0).X_TH.p - here.p).norm(), 1e-6);
    EXPECT_LT((rig.tool(1).X_TH.p + here.p).norm(), 1e-6);
    EXPECT_NEAR(rig.tool(0).number, 120, 4);
    EXPECT_LT(rig.now - rig.tool(0).t_ns, 20'000'000);
    EXPECT_EQ(rig.tracker->report().counters.malformed, 0u);
    EXPECT_EQ(rig.tracker->report().counters.lost_frames, 0u);
  }
}

TEST(SimPolhemus, AStationWithoutRecordsGoesStaleAndTheOtherDoesNot) {
  Hand rig(Model::fastrak);
  ASSERT_TRUE(rig.track());
  rig.run(0.2);
  rig.far->faults.missing[1] = true;
  rig.run(0.3);
  EXPECT_EQ(rig.tool(0).state, ToolState::valid);
  EXPECT_EQ(rig.tool(1).state, ToolState::stale);
  EXPECT_EQ(rig.tracker->report().state, TrackerState::tracking);
}

TEST(SimPolhemus, SilenceIsRecoveredFrom) {
  Hand rig(Model::liberty);
  ASSERT_TRUE(rig.track());
  rig.far->faults.silent = true;
  rig.run(1.5);
  EXPECT_EQ(rig.tool(0).state, ToolState::stale);
  EXPECT_EQ(rig.tracker->report().counters.restarts, 1u);
  rig.run(15);
  EXPECT_EQ(rig.tracker->report().state, TrackerState::failed);
  rig.far->faults.silent = false;
  EXPECT_TRUE(rig.track());
}

TEST(SimPolhemus, NoiseCostsRecords) {
  Hand rig(Model::fastrak);
  rig.far->faults.corrupt_probability = 0.2;
  ASSERT_TRUE(rig.track());
  rig.run(5);
  EXPECT_GT(rig.tracker->report().counters.malformed, 10u);
  EXPECT_GT(rig.tool(0).number, 400u);
}

}  // namespace
}  // namespace godobject::test_sim_polhemus
