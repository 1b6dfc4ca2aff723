#include "sim/tracker/polhemus.h"

#include <gtest/gtest.h>

#include <random>

#include "sim/tracker/ndi.h"
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

/// A tool with an old calibration saved in the tracker.
TEST(SimPolhemus, FramesSavedInTheTrackerChangeNothing) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const auto turn = [&] {
    return Quat(normal(random), normal(random), normal(random), normal(random)).normalized();
  };
  const auto point = [&] { return Vec3(0.1 * normal(random), 0.1 * normal(random), 0.1 * normal(random)); };
  for (int n = 0; n < 12; ++n) {
    Hand rig(n % 2 == 0 ? Model::fastrak : Model::liberty);
    auto& far = static_cast<SimPolhemus&>(*rig.far);
    for (const std::size_t tool : {0u, 1u})
      far.save(tool, {.X_alignment = {.p = point(), .q = turn()},
                      .boresight = turn(),
                      .tip = point(),
                      .source = turn()});
    ASSERT_TRUE(rig.track()) << rig.tracker->report().text.data();
    rig.run(0.2);
    EXPECT_LT((rig.tool(0).X_TH.p - here.p).norm(), 1e-6);
    EXPECT_LT((rig.tool(1).X_TH.p + here.p).norm(), 1e-6);
    EXPECT_LT(rig.tool(0).X_TH.q.angularDistance(here.q), 1e-6);
    EXPECT_LT(rig.tool(1).X_TH.q.angularDistance(here.q), 1e-6);
  }
}

TEST(SimPolhemus, TheHemisphereIsThatOfTheScene) {
  for (const Model model : {Model::fastrak, Model::liberty}) {
    for (const Vec3& hemisphere : {Vec3(0, 0, -1), Vec3(0, 1, 0), Vec3(0.6, 0, -0.8), Vec3(-1, 0, 0)}) {
      TrackerParams params = test::tracker_params(TrackerProtocol::polhemus, {"2"});
      params.hemisphere = hemisphere;
      SimulatedTracker rig(make_tracker(params, {}).tracker, nullptr);
      auto far = std::make_unique<SimPolhemus>(params, 120, 1, model);
      far->set_half_space(true);
      rig.far = std::move(far);
      rig.far->set_pose(0, here);
      ASSERT_TRUE(rig.track());
      rig.run(0.1);
      const double sign = hemisphere.dot(here.p) < 0 ? -1 : 1;
      EXPECT_LT((rig.tool(0).X_TH.p - sign * here.p).norm(), 1e-6) << hemisphere.transpose();
    }
  }
}

/// Beyond the plane of the hemisphere the tracker reports the mirror image: the tool is lost, not displaced.
TEST(SimPolhemus, ASensorThatLeavesItsHemisphereIsLostUntilItIsBack) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Model model : {Model::fastrak, Model::liberty}) {
    for (int n = 0; n < 10; ++n) {
      TrackerParams params = test::tracker_params(TrackerProtocol::polhemus, {"1"});
      SimulatedTracker rig(make_tracker(params, {}).tracker, nullptr);
      auto far = std::make_unique<SimPolhemus>(params, n % 2 == 0 ? 120 : 30, 1, model);
      far->set_half_space(true);
      rig.far = std::move(far);
      const Vec3 side(0, 0.3 * uniform(random), 0.4);
      const double speed = 0.15 + 0.1 * uniform(random);
      double x = 0.1;
      const auto move = [&](double v, double s) {
        for (int i = 0; i < 1000 * s; ++i) {
          x += 0.001 * v;
          rig.far->set_pose(0, {.p = side + Vec3(x, 0, 0), .q = Quat::Identity()});
          rig.step();
          const ToolSample& tool = rig.tool(0);
          if (tool.state != ToolState::valid) continue;
          EXPECT_LT((tool.X_TH.p - side - Vec3(x, 0, 0)).norm(), 0.02) << "at x = " << x;
        }
      };
      rig.far->set_pose(0, {.p = side + Vec3(x, 0, 0), .q = Quat::Identity()});
      ASSERT_TRUE(rig.track());
      move(0, 0.2);
      EXPECT_EQ(rig.tool(0).state, ToolState::valid);
      move(-speed, 0.3 / speed);
      EXPECT_EQ(rig.tool(0).state, ToolState::missing) << x;
      EXPECT_NE(std::string(rig.tracker->report().text.data()).find("hemisphere"), std::string::npos);
      move(0, 1);
      EXPECT_EQ(rig.tool(0).state, ToolState::missing);
      move(speed, 0.3 / speed);
      EXPECT_EQ(rig.tool(0).state, ToolState::valid) << x;
      EXPECT_EQ(std::string(rig.tracker->report().text.data()).find("hemisphere"), std::string::npos);
    }
  }
}

TEST(SimPolhemus, RecordsOfTextAreNamed) {
  Hand rig(Model::fastrak);
  static_cast<SimPolhemus&>(*rig.far).set_text_only(true);
  ASSERT_TRUE(rig.run_until([&] { return rig.tracker->report().state == TrackerState::failed; }, 20));
  EXPECT_NE(std::string(rig.tracker->report().text.data()).find("text, not binary records"),
            std::string::npos)
      << rig.tracker->report().text.data();
}

TEST(SimPolhemus, AnotherProtocolAtTheOtherEndIsNamed) {
  const TrackerParams params = Hand::params();
  SimulatedTracker to_ndi(make_tracker(params, {}).tracker, nullptr);
  to_ndi.far = std::make_unique<SimNdi>(test::tracker_params(TrackerProtocol::ndi, {"0A"}), 60, 1);
  ASSERT_TRUE(to_ndi.run_until([&] { return to_ndi.tracker->report().state == TrackerState::failed; }, 20));
  EXPECT_NE(std::string(to_ndi.tracker->report().text.data()).find("protocol = \"ndi\""), std::string::npos)
      << to_ndi.tracker->report().text.data();
  for (const bool binary : {false, true}) {
    const TrackerParams ndi = test::tracker_params(TrackerProtocol::ndi, {"0A"});
    SimulatedTracker to_polhemus(make_tracker(ndi, {}).tracker, nullptr);
    to_polhemus.far = std::make_unique<SimPolhemus>(params, 60, 1, Model::fastrak);
    to_polhemus.far->set_pose(0, here);
    const std::string earlier_host = binary ? "O1,2,11,0\rfC" : "C";
    to_polhemus.far->receive(
        {reinterpret_cast<const std::uint8_t*>(earlier_host.data()), earlier_host.size()}, 0);
    ASSERT_TRUE(to_polhemus.run_until(
        [&] { return to_polhemus.tracker->report().state == TrackerState::failed; }, 40));
    EXPECT_NE(std::string(to_polhemus.tracker->report().text.data()).find("not recognised"),
              std::string::npos)
        << to_polhemus.tracker->report().text.data();
  }
}

}  // namespace
}  // namespace godobject::test_sim_polhemus
