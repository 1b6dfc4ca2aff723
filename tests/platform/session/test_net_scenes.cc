// The shipped scenes with nets run without fault and show the documented behaviour.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_net_scenes {
namespace {

const std::string scenes = GODOBJECT_SOURCE_DIR "/sim/scenes/";

/// A shipped scene without a bus, with a motion file or its own motion.
class SceneRun {
 public:
  explicit SceneRun(const std::string& name, const std::string& integrator, const std::string& motion = "") {
    LoadResult loaded = load_scene(scenes + name);
    EXPECT_THAT(loaded.errors, testing::IsEmpty());
    EXPECT_THAT(loaded.warnings, testing::IsEmpty());
    scene_ = loaded.scene.value();
    scene_.integrator = integrator;
    Motion moves(scene_);
    if (!motion.empty()) {
      MotionResult read = Motion::read(scenes + motion, scene_);
      EXPECT_THAT(read.errors, testing::IsEmpty());
      moves = read.motion.value();
    }
    Session::Made made = make_session(scene_, std::move(moves), BusChoice::direct);
    if (!made.session) throw std::runtime_error(made.errors.front());
    session_ = std::move(made.session);
    session_->list_net_nodes();
    record_ = session_->at_start();
    began_ = record_.net_nodes;
  }

  template <class F>
  void until(double t, F look) {
    while (record_.t < t - scene_.step / 2) {
      session_->cycle(record_);
      ASSERT_EQ(record_.fault, Fault::none) << "at " << record_.t << " s";
      for (const Vec3& p_W : record_.net_nodes) ASSERT_LT(p_W.norm(), 1) << "at " << record_.t << " s";
      look(record_);
    }
  }
  void until(double t) {
    until(t, [](const CycleRecord&) {});
  }

  const BodyView& body(const std::string& name) const {
    return record_.bodies[body_named(scene_, name).value()];
  }
  const CycleRecord& record() const { return record_; }
  const SceneNets& nets() const { return session_->engine().nets(); }
  /// Returns the distance of each node from its start, m.
  std::vector<double> moved() const {
    std::vector<double> d;
    for (std::size_t i = 0; i < began_.size(); ++i) d.push_back((record_.net_nodes[i] - began_[i]).norm());
    return d;
  }
  /// Returns the largest distance of a node from its anchor, m.
  double farthest_from_anchor() const {
    double most = 0;
    for (std::size_t i = 0; i < began_.size(); ++i) {
      const NetNode& node = nets().nodes[i];
      const Pose X = node.body == world ? Pose{} : record_.bodies[node.body].X_WB;
      most = std::max(most, (record_.net_nodes[i] - X.p - X.q * node.p_B).norm());
    }
    return most;
  }

 private:
  SceneConfig scene_;
  std::unique_ptr<Session> session_;
  CycleRecord record_;
  std::vector<Vec3> began_;
};

class NetScenes : public testing::TestWithParam<std::string> {};

TEST_P(NetScenes, NetSmallSwingsAboutItsRod) {
  SceneRun run("net-small.toml", GetParam());
  EXPECT_EQ(run.nets().nodes.size(), 25U);
  EXPECT_EQ(run.record().net_nodes.size(), 25U);
  double most = 0;
  run.until(4, [&](const CycleRecord&) { most = std::max(most, run.farthest_from_anchor()); });
  std::printf("net-small: %.3g m from the anchors, stretch %.3g\n", most, run.record().net_stretch);
  EXPECT_GT(most, 2e-3);
  EXPECT_LT(most, 0.02);
}

TEST_P(NetScenes, EndobagIsDrawnRoundTheBarAndTheDeviceIsInside) {
  SceneRun run("endobag.toml", GetParam());
  double deepest = 0, stretch = 0, bag = 0;
  int iterations = 0;
  std::size_t contacts = 0;
  run.until(6, [&](const CycleRecord& r) {
    deepest = std::max(deepest, r.nets.deepest);
    stretch = std::max(stretch, r.net_stretch);
    iterations = std::max(iterations, r.nets.iterations);
    contacts = std::max(contacts, r.nets.num_contacts);
    bag = std::max(bag, run.farthest_from_anchor());
  });
  const Vec3 rod = run.body("rod").X_WB.p, device = run.body("rod").target.X_WD.p;
  std::printf(
      "endobag: rod %.4f %.4f device %.4f %.4f, deepest %.3g, contacts %zu, stretch %.3g, dent %.3g, "
      "iterations %d\n",
      rod.x(), rod.z(), device.x(), device.z(), deepest, contacts, stretch, bag, iterations);
  EXPECT_LT(std::hypot(device.x(), device.z()), 0.012) << "inside the bar";
  EXPECT_GT(rod.z(), 0.012) << "on it";
  EXPECT_GT(bag, 0.01);
  EXPECT_GT(contacts, 20U);
  EXPECT_LT(deepest, 2e-3);
}

TEST_P(NetScenes, TheGrasperDragsTheSheetAndReleasesIt) {
  SceneRun run("organ-soft.toml", GetParam(), "organ-soft-motion.csv");
  run.until(1.8);
  const auto most = [&] { return std::ranges::max(run.moved()); };
  std::printf("organ-soft: %.3g m before it is pinched, %zu contacts, tip %.4f\n", most(),
              run.record().nets.num_contacts, run.body("left").X_WB.p.z());
  run.until(3.1);
  std::printf("  %.3g m pinched, %zu contacts\n", most(), run.record().nets.num_contacts);
  EXPECT_GT(run.record().nets.num_contacts, 4U);
  run.until(5.0);
  const double dragged = most();
  std::printf("  %.3g m dragged, %zu contacts\n", dragged, run.record().nets.num_contacts);
  EXPECT_GT(dragged, 0.006);
  EXPECT_GT(run.record().nets.num_contacts, 4U);
  run.until(9.4);
  std::printf("  %.3g m at the end, %zu contacts\n", most(), run.record().nets.num_contacts);
  EXPECT_LT(most(), 0.3 * dragged) << "let go of";
}

TEST_P(NetScenes, TheFlexibleTipIsDentedByTheBall) {
  SceneRun run("flexible-tip.toml", GetParam());
  double dent = 0, deepest = 0;
  std::size_t contacts = 0;
  run.until(8, [&](const CycleRecord& r) {
    dent = std::max(dent, run.farthest_from_anchor());
    deepest = std::max(deepest, r.nets.deepest);
    contacts = std::max(contacts, r.nets.num_contacts);
  });
  std::printf("flexible-tip: dent %.3g, deepest %.3g, contacts %zu\n", dent, deepest, contacts);
  EXPECT_GT(dent, 2e-3);
  EXPECT_GT(contacts, 10U);
  EXPECT_LT(deepest, 2e-3);
}

TEST_P(NetScenes, TheHookLiftsTheTissueAndTheStoneWithIt) {
  SceneRun run("sewn.toml", GetParam());
  EXPECT_EQ(run.nets().attachments.size(), 7U);
  double swing = 0, pull = 0;
  const auto look = [&](const CycleRecord&) {
    swing = std::max(swing, std::abs(run.body("stone").X_WB.p.y()));
    pull = std::max(pull, run.body("hook").target.X_WD.p.z() - run.body("hook").X_WB.p.z());
  };
  run.until(2, look);
  const double low = run.body("stone").X_WB.p.z();
  run.until(3, look);
  const double high = run.body("stone").X_WB.p.z();
  run.until(6, look);
  std::printf("sewn: stone from %.4f to %.4f, aside %.4f, hook held back by %.4f m, %d iterations\n", low,
              high, swing, pull, run.record().nets.iterations);
  EXPECT_GT(high, low + 8e-3) << "the hook lifts it";
  EXPECT_GT(swing, 5e-4) << "and draws it aside";
  EXPECT_GT(300 * pull, 9.81 * (0.05 + 0.02 + 0.0108))
      << "the hand bears all of the weight, and what is stretched";
}

INSTANTIATE_TEST_SUITE_P(Both, NetScenes, testing::Values("implicit-euler", "tr-bdf2"), [](const auto& test) {
  return test.param == "tr-bdf2" ? std::string("TrBdf2") : std::string("ImplicitEuler");
});

}  // namespace
}  // namespace godobject::test_net_scenes
