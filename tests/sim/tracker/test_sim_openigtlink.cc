// The tracker of OpenIGTLink against its simulated server, with faults of the line.
#include "sim/tracker/openigtlink.h"

#include <gtest/gtest.h>

#include "tests/support/simulated_tracker.h"

namespace godobject::test_sim_openigtlink {
namespace {

class SimulatedServer : public testing::Test {
 protected:
  static TrackerParams params() {
    return test::tracker_params(TrackerProtocol::openigtlink, {"probe", "reference"});
  }
  test::SimulatedTracker line_{make_tracker(params(), {}).tracker, make_sim_tracker(params(), 60, 1)};
};

TEST_F(SimulatedServer, ItsPosesAreFollowed) {
  const Pose X{.p = Vec3(0.1, 0.2, -0.3), .q = Quat(0.5, 0.5, -0.5, 0.5)};
  line_.far->set_pose(1, X);
  ASSERT_TRUE(line_.track(1));
  line_.run(1);
  EXPECT_EQ(line_.tool(0).state, ToolState::valid);
  EXPECT_LT((line_.tool(1).X_TH.p - X.p).norm(), 1e-7);
  EXPECT_NEAR(std::abs(line_.tool(1).X_TH.q.dot(X.q)), 1, 1e-7);
  EXPECT_NEAR(line_.tool(1).number, 60, 2);
  const TrackerCounters& counters = line_.tracker->report().counters;
  EXPECT_EQ(counters.bad_crc + counters.malformed + counters.repeated + counters.lost_frames, 0u);
}

TEST_F(SimulatedServer, AHiddenToolIsStaleAndTheOtherIsNot) {
  ASSERT_TRUE(line_.track(1));
  line_.far->faults.missing[0] = true;
  line_.run(0.3);
  EXPECT_EQ(line_.tool(0).state, ToolState::stale);
  EXPECT_EQ(line_.tool(1).state, ToolState::valid);
}

TEST_F(SimulatedServer, FlippedBitsAreCountedOrEndTheConnection) {
  line_.far->faults.corrupt_probability = 0.2;
  line_.run(10);
  const TrackerCounters& counters = line_.tracker->report().counters;
  EXPECT_GT(counters.bad_crc, 50u);
  EXPECT_GT(counters.samples, 500u);
  // No pose but that of the simulation arrives.
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(line_.tool(i).X_TH.p, Vec3(Vec3::Zero()));
}

}  // namespace
}  // namespace godobject::test_sim_openigtlink
