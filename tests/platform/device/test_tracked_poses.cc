#include "platform/device/trackers.h"

#include <gtest/gtest.h>

#include "sim/tracker/link.h"
#include "tests/support/allocation_guard.h"
#include "tests/support/simulated_tracker.h"

namespace godobject::test_tracked_poses {
namespace {

constexpr Nanoseconds ms = 1'000'000;

Pose hand_at(double t) {
  const double angle = 0.5 * std::sin(3 * t);
  return {.p = Vec3(0.1 * std::sin(2 * t), 0.05, -0.02 * std::cos(2 * t)),
          .q = Quat(std::cos(angle / 2), 0, std::sin(angle / 2), 0)};
}

/// One NDI tracker, displaced and rotated in the world, with a tool with an offset target.
struct Tracked {
  explicit Tracked(double rate_hz = 60) {
    TrackerParams params = test::tracker_params(TrackerProtocol::ndi, {"probe.rom"});
    params.X_WT = {.p = Vec3(1, 2, 3), .q = Quat(0.5, 0.5, -0.5, 0.5)};
    params.tools[0].X_TH = {.p = Vec3(0, 0, -0.15), .q = Quat(Eigen::AngleAxisd(0.3, Vec3::UnitX()))};
    std::vector<std::string> errors;
    auto made = make_sim_tracker_link(params, rate_hz, 1, errors);
    EXPECT_TRUE(errors.empty());
    link = made.get();
    std::vector<std::unique_ptr<TrackerLink>> links;
    links.push_back(std::move(made));
    poses = std::make_unique<TrackedPoses>(std::move(links));
  }
  const TrackedPose& step() {
    now += ms;
    link->far().set_pose(0, tool_pose_for(link->params(), 0, hand_at(1e-9 * static_cast<double>(now))));
    poses->update(now);
    return poses->poses()[0];
  }
  bool boot() {
    for (int i = 0; i < 5000 && !step().valid; ++i) continue;
    return poses->ready() && poses->poses()[0].valid;
  }

  SimTrackerLink* link = nullptr;
  std::unique_ptr<TrackedPoses> poses;
  Nanoseconds now = 1000 * ms;
};

TEST(TrackedPoses, TheBodysTargetIsTheHandSomewhatEarlier) {
  Tracked rig;
  EXPECT_FALSE(rig.poses->ready());
  ASSERT_TRUE(rig.boot()) << rig.poses->report(0).text.data();
  for (int i = 0; i < 3000; ++i) {
    const TrackedPose& pose = rig.step();
    ASSERT_TRUE(pose.valid);
    EXPECT_EQ(pose.body, "body");
    double nearest = 1;
    for (Nanoseconds delay = 10 * ms; delay < 60 * ms; delay += ms / 2) {
      const Pose hand = hand_at(1e-9 * static_cast<double>(rig.now - delay));
      nearest = std::min(
          nearest, (pose.target.X_WD.p - hand.p).norm() + 0.1 * pose.target.X_WD.q.angularDistance(hand.q));
    }
    EXPECT_LT(nearest, 1e-3);
  }
}

TEST(TrackedPoses, AMissingToolIsHeldAndItsStateSaysWhy) {
  Tracked rig;
  ASSERT_TRUE(rig.boot());
  for (int i = 0; i < 500; ++i) static_cast<void>(rig.step());
  rig.link->far().faults.missing[0] = true;
  Pose last = rig.step().target.X_WD;
  for (int i = 0; i < 100; ++i) {
    const TrackedPose& pose = rig.step();
    EXPECT_LT((pose.target.X_WD.p - last.p).norm(), 1e-3);
    last = pose.target.X_WD;
  }
  EXPECT_FALSE(rig.poses->poses()[0].valid);
  EXPECT_EQ(rig.poses->poses()[0].state, ToolState::missing);
  EXPECT_EQ(rig.poses->poses()[0].target.V_WD.v.norm(), 0);
  EXPECT_TRUE(rig.poses->ready()) << "not a fault";
  rig.link->far().faults.missing[0] = false;
  for (int i = 0; i < 200; ++i) static_cast<void>(rig.step());
  EXPECT_TRUE(rig.poses->poses()[0].valid);
}

TEST(TrackedPoses, ACycleAllocatesNothing) {
  Tracked rig;
  ASSERT_TRUE(rig.boot());
  AllocationGuard guard;
  for (int i = 0; i < 500; ++i) static_cast<void>(rig.step());
  EXPECT_EQ(guard.calls(), 0) << guard.report();
}

}  // namespace
}  // namespace godobject::test_tracked_poses
