// Keys and wheel in the page move the joints of an instrument: limits, staleness, ranges, one page at a time.
#include "platform/view/pointer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_joint_pointer {
namespace {

constexpr Nanoseconds ms = 1'000'000;
Nanoseconds now_ns = 0;

SceneConfig driven_by_page(const std::string& name) {
  SceneConfig scene = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/" + name).scene.value();
  lead_by_pointer(scene);
  return scene;
}

/// A session with a page's keys as its device, and a clock of the test's own.
struct Played {
  explicit Played(const std::string& name) : scene(driven_by_page(name)) {
    now_ns = 1'000 * ms;
    made = make_session(scene, Motion(scene), BusChoice::direct);
    EXPECT_TRUE(made.errors.empty());
    made.session->add(page);
    made.session->start(1);
    record = made.session->at_start();
  }

  std::size_t joint(const std::string& name) const {
    const std::vector<DeviceJoint>& joints = device_tree(scene)->joints;
    return static_cast<std::size_t>(std::ranges::find(joints, name, &DeviceJoint::name) - joints.begin());
  }
  const BodyView& body(const std::string& name) const { return record.bodies[*body_named(scene, name)]; }

  bool say(const std::string& moved, double dq, bool holds = true, std::uint64_t client = 1) {
    JointsMessage message{.number = ++number,
                          .holds = holds,
                          .num_joints = static_cast<std::uint32_t>(device_tree(scene)->joints.size())};
    message.dq[joint(moved)] = dq;
    return page.take(client, message);
  }
  /// Runs periods of the loop, with a message of the page every 16 of them.
  void run(int periods, const std::string& moved = "", double dq_per_message = 0) {
    for (int i = 0; i < periods; ++i) {
      now_ns += ms;
      if (!moved.empty() && i % 16 == 0) say(moved, dq_per_message);
      static_cast<void>(made.session->advance(record));
      if (has(record.limited, Limited::held)) ++periods_held;
      EXPECT_EQ(record.fault, Fault::none);
    }
  }

  SceneConfig scene;
  JointPointer page{scene, []() noexcept { return now_ns; }};
  Session::Made made;
  CycleRecord record;
  std::uint32_t number = 0;
  int periods_held = 0;
};

TEST(JointPointer, MovesNothingByItself) {
  for (const char* name : {"grasper.toml", "organ-soft.toml", "organ.toml"}) {
    Played played(name);
    const Pose before = played.body("tube").target.X_WD;
    played.run(300);
    EXPECT_LT((played.body("tube").target.X_WD.p - before.p).norm(), 1e-12) << name;
    EXPECT_EQ(played.periods_held, 0) << name;
  }
}

TEST(JointPointer, PushesTheTubeAlongItsAxis) {
  for (const char* name : {"grasper.toml", "organ-soft.toml"}) {
    Played played(name);
    played.run(700);  // engaged
    const Pose before = played.body("tube").X_WB;
    played.run(1600, "insertion", -0.0005);
    played.say("insertion", 0, false);
    played.run(800);
    const Vec3 way = played.body("tube").X_WB.p - before.p, axis = before.q * Vec3::UnitZ();
    EXPECT_NEAR(way.dot(axis), -0.0495, 1e-3) << name << ": 99 shifts; the first message takes hold";
    EXPECT_LT((way - way.dot(axis) * axis).norm(), 2e-3) << name;
    EXPECT_EQ(played.periods_held, 0) << name;
  }
}

/// The jaws of the grasper close by their own coordinates, each alone.
TEST(JointPointer, ClosesAJaw) {
  Played played("grasper.toml");
  played.run(700);
  const auto turned = [&](const char* jaw, const Quat& from) {
    return 2 * std::acos(std::min(1.0, std::abs((from.conjugate() * played.body(jaw).X_WB.q).w())));
  };
  const Quat left = played.body("left").X_WB.q, right = played.body("right").X_WB.q;
  played.run(800, "left", -0.005);
  played.run(300, "left", 0);
  EXPECT_NEAR(turned("left", left), 0.245, 0.01);
  EXPECT_LT(turned("right", right), 0.02);
}

TEST(JointPointer, KeepsRatesAndRanges) {
  Played played("organ-soft.toml");
  const std::vector<CoordinateRange> ranges = page_ranges(played.scene);
  const CoordinateRange jaw = ranges[played.joint("left")];
  EXPECT_NEAR(jaw.lower, -0.35, 1e-12);
  EXPECT_NEAR(jaw.upper, 1.05, 1e-12);
  played.run(700);
  double fastest = 0;
  for (int i = 0; i < 500; ++i) {
    const Vec3 before = played.body("tube").target.X_WD.p;
    played.run(1, "insertion", -1);
    fastest = std::max(fastest, (played.body("tube").target.X_WD.p - before).norm() / played.scene.step);
  }
  EXPECT_LT(fastest, (1 + 1e-6) * max_page_slide_rate) << "of 1000 m/s that were asked for";
  EXPECT_GT(fastest, 0.9 * max_page_slide_rate);
  played.run(16000, "insertion", -1);
  const Vec3 p = played.body("tube").target.X_WD.p;
  const double start = Motion(played.scene).joints(0).q[static_cast<Eigen::Index>(played.joint("insertion"))];
  EXPECT_NEAR(ranges[played.joint("insertion")].lower, start - 0.5, 1e-12);
  EXPECT_NEAR(p.norm(), std::abs(start - 0.5 - 0.175), 1e-3) << "tip at the lower end of the range";
}

/// A busy page sends late and several at once: no displacement is lost, and the target is not faster.
TEST(JointPointer, LosesNothingOfMessagesThatComeAtOnce) {
  Played played("grasper.toml");
  played.run(700);
  const Vec3 before = played.body("tube").target.X_WD.p;
  ASSERT_TRUE(played.say("insertion", 0));
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(played.say("insertion", -0.0025));
  double fastest = 0;
  for (int i = 0; i < 250; ++i) {
    const Vec3 last = played.body("tube").target.X_WD.p;
    played.run(1);
    fastest = std::max(fastest, (played.body("tube").target.X_WD.p - last).norm() / played.scene.step);
  }
  played.say("insertion", 0, false);
  played.run(500);
  EXPECT_NEAR((played.body("tube").target.X_WD.p - before).norm(), 0.02, 1e-4);
  EXPECT_LT(fastest, (1 + 1e-6) * max_page_slide_rate);
}

TEST(JointPointer, HoldsWhereSamplesAreStale) {
  Played played("grasper.toml");
  played.run(700, "insertion", 0.0005);
  played.periods_held = 0;
  played.run(static_cast<int>(pointer_stale_ns / ms) - 20);
  EXPECT_EQ(played.periods_held, 0);
  played.run(200);
  EXPECT_GT(played.periods_held, 150);
  const Vec3 held = played.body("tube").target.X_WD.p;
  played.page.leave(1);
  played.periods_held = 0;
  played.run(500);
  EXPECT_LT(played.periods_held, 20) << "a page that is gone leaves the instrument at rest";
  EXPECT_LT((played.body("tube").target.X_WD.p - held).norm(), 1e-3);
}

TEST(JointPointer, ListensToOnePageAtATime) {
  Played played("grasper.toml");
  played.run(100);
  EXPECT_TRUE(played.say("left", 0.01));
  EXPECT_FALSE(played.say("left", 0.01, true, 2)) << "another page";
  EXPECT_FALSE(played.page.take(1, {.number = 1, .holds = true, .num_joints = 6})) << "an old number";
  EXPECT_FALSE(played.page.take(1, {.number = 100, .holds = true, .num_joints = 5})) << "another instrument";
  played.page.leave(2);
  EXPECT_FALSE(played.say("left", 0.01, true, 2));
  EXPECT_TRUE(played.say("left", 0, false));
  EXPECT_TRUE(played.say("left", 0.01, true, 2));
}

TEST(JointPointer, LeavesOtherScenesToThePointer) {
  for (const char* name : {"wall.toml", "lego.toml"}) {
    const SceneConfig scene = driven_by_page(name);
    EXPECT_FALSE(scene.device->unmeasured_tree) << name;
    EXPECT_TRUE(scene.device->grab_radius) << name;
  }
}

TEST(JointPointer, TouchesNeitherHeapNorSystemInTheLoop) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  Played played("grasper.toml");
  played.run(300);
  const std::string moved = "left";
  AllocationGuard guard;
  played.run(300, moved, 0.001);
  EXPECT_EQ(guard.calls(), 0) << guard.report();
}

}  // namespace
}  // namespace godobject::test_joint_pointer
