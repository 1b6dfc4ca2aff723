// Articulated tools in a session: their composition, the wrenches of their joints, prescribed joints, long
// chains.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "platform/scene/joint/joints.h"
#include "platform/simulated/session.h"
#include "tests/support/tool_scene.h"

namespace godobject::test::test_articulated_session {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(ArticulatedEngine, SmallestCompositionThatCoversTheSceneIsTaken) {
  const auto composition = [](const SceneConfig& scene) {
    std::string why_not;
    const std::vector<BodySample> samples(scene.bodies.size());
    const std::unique_ptr<Engine> engine = make_engine(scene, samples, why_not);
    return engine ? engine->composition().name : why_not;
  };
  SceneConfig scene = load_shipped("rigid.toml");
  EXPECT_EQ(composition(scene), "rigid-1 tr-bdf2");
  scene = load_shipped("chain.toml");
  EXPECT_EQ(composition(scene), "joints-8 tr-bdf2");
  scene.bodies.resize(9, scene.bodies.back());
  EXPECT_EQ(composition(scene), "joints-256 tr-bdf2");
  scene.bodies.resize(300, scene.bodies.back());
  EXPECT_THAT(composition(scene),
              AllOf(HasSubstr("joints"), HasSubstr("300 bodies"), HasSubstr("holds 256")));
  EXPECT_EQ(composition(load_shipped("scissors-imposed.toml")), "joints-8 tr-bdf2");
  EXPECT_EQ(composition(load_shipped("organ.toml")), "joints-contacts-64 tr-bdf2");
  EXPECT_EQ(composition(load_shipped("grasp.toml")), "joints-touching-64 implicit-euler");
  scene = load_shipped("grasp.toml");
  scene.integrator = "tr-bdf2";
  EXPECT_EQ(composition(scene), "joints-touching-64 tr-bdf2");
}

/// Joints work with every kind of device; a mouse may lead scissors, too.
TEST(ArticulatedEngine, FollowsDevicesOfEveryKind) {
  const Vec3 way(0.01, 0, 0);
  const double stiffness = 100;
  for (const char* kind : {"non-haptic", "impedance", "relative", "admittance"}) {
    const LoadResult loaded = parse_tool(
        body("handle",
             "[body.coupling]\nstiffness = 100.0\ndamping_ratio = 1.0\nrotational_stiffness = 0.1\n"
             "rotational_damping_ratio = 1.0\n") +
        body("blade", "position = [0.1, 0.0, 0.0]\n") +
        joint("hinge", "hinge", "handle", "blade",
              "parent_position = [0.05, 0.0, 0.0]\nchild_position = [-0.05, 0.0, 0.0]\n") +
        "[device]\nname = \"arm\"\nkind = \"" + kind + "\"\n");
    ASSERT_TRUE(loaded.scene) << loaded.errors.front();
    std::vector<BodySample> samples(2);
    std::string why_not;
    const std::unique_ptr<Engine> engine = make_engine(*loaded.scene, samples, why_not);
    ASSERT_TRUE(engine) << why_not;
    const auto steps = [&](int count) {
      for (int i = 0; i < count; ++i) EXPECT_EQ(engine->step(samples).fault, Fault::none);
    };
    steps(1000);  // engaged
    samples[0].target.X_WD.p += way;
    samples[0].F_WB.f =
        stiffness * way;  // of an admittance device: against the spring to the pose of engagement
    steps(2000);
    for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
      EXPECT_NEAR((engine->view(i).X_WB.p - loaded.scene->bodies[i].X_WB.p - way).norm(), 0, 1e-6) << kind;
  }
}

TEST(ArticulatedEngine, ParametersTheCoreDoesNotTakeAreRefused) {
  SceneConfig scene = load_shipped("pendulum.toml");
  scene.bodies.front().mass = 0;
  std::string why_not;
  const std::vector<BodySample> samples(1);
  EXPECT_EQ(make_engine(scene, samples, why_not), nullptr);
  EXPECT_THAT(why_not, HasSubstr("body 'rod': the mass must be finite and above 0 kg"));
}

/// A pendulum at rest below its hinge loads the joint by its weight.
TEST(ArticulatedSession, JointCarriesTheWeight) {
  SceneConfig scene = load_shipped("pendulum.toml");
  BodyConfig& rod = scene.bodies.front();
  rod.X_WB = {Vec3(0, 0, -0.15), Quat(0, 0, 1, 0)};
  const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  CycleRecord record = made.session->at_start();
  for (int i = 0; i < 100; ++i) made.session->cycle(record);
  EXPECT_LT((record.bodies[0].joint_C.f - Vec3(0, 0, 0.2 * 9.81)).norm(), 1e-12);
  EXPECT_LT(record.bodies[0].joint_C.tau.norm(), 1e-12);
}

TEST(ArticulatedSession, PrescribedJawsFollowTheDevice) {
  const SceneConfig scene = load_shipped("scissors-imposed.toml");
  const Motion motion(scene);
  for (const BusChoice bus : {BusChoice::direct, BusChoice::sim}) {
    const Session::Made made = make_session(scene, motion, bus);
    ASSERT_NE(made.session, nullptr) << made.errors.front();
    ASSERT_TRUE(made.session->boot(5));
    CycleRecord record = made.session->at_start();
    double worst = 0, moved = 0;
    for (int i = 0; i < 2000; ++i) {
      made.session->cycle(record);
      ASSERT_EQ(record.fault, Fault::none);
      if (record.t < scene.device->limits.ramp + 0.02) continue;  // the ramp ends with a velocity of its own
      const std::vector<BodyConfig> bodies = placed(scene, record);
      const JointVector q = motion.joints(record.t).q;  // pitch, yaw, roll, insertion, left, right
      const double left = coordinates_at_start(bodies, scene.joints[2])[0];
      const double right = coordinates_at_start(bodies, scene.joints[3])[0];
      worst = std::max({worst, std::abs(left - q[4]), std::abs(right - q[5])});
      moved = std::max(moved, std::abs(left - 0.55));
    }
    EXPECT_GT(moved, 0.4);
    // On the bus the arm lags behind the hand, and a count is 24 urad.
    EXPECT_LT(worst, bus == BusChoice::direct ? 1e-8 : 1e-2);
  }
}

/// Turns of joints and devices are counted: a prescribed joint follows the device beyond half a turn.
TEST(ArticulatedSession, PrescribedTurnGoesOnBeyondHalfATurn) {
  SceneConfig scene = load_shipped("scissors-imposed.toml");
  scene.device->limits.ramp = 0;
  const MotionResult motion = Motion::parse(
      "t,pitch,yaw,roll,insertion,left,right\n0,0,0,0,0.15,0,0\n0.5,0,0,0,0.15,3,0\n1,0,0,0,0.15,9,0\n",
      "m.csv", scene);
  ASSERT_TRUE(motion.motion.has_value());
  const Session::Made made = make_session(scene, *motion.motion, BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  CycleRecord record = made.session->at_start();
  double turned = 0, last = 0;
  for (int i = 0; i < 1000; ++i) {
    made.session->cycle(record);
    ASSERT_FALSE(has(record.limited, Limited::held));
    ASSERT_EQ(record.fault, Fault::none);
    const double left = coordinates_at_start(placed(scene, record), scene.joints[2])[0];
    turned += std::remainder(left - last, 2 * std::numbers::pi);
    last = left;
  }
  EXPECT_NEAR(turned, 9, 1e-6);
}

/// The tool of reference/grasper.toml hangs in its couplings. On every body the wrenches of joints, coupling
/// and weight cancel, and no joint has a force along its free axes.
TEST(ArticulatedSession, WrenchesOfALoadedGrasperAtRestBalance) {
  SceneConfig scene = load_shipped("reference/grasper.toml");
  scene.gravity = Vec3(1, 2, -9.81);
  for (BodyConfig& b : scene.bodies) b.V_WB = {};
  const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  CycleRecord record = made.session->at_start();
  for (int i = 0; i < 20000; ++i) made.session->cycle(record);
  ASSERT_EQ(record.fault, Fault::none);
  std::vector<Wrench> sums;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Wrench& F = record.bodies[i].coupling_B;
    sums.push_back({.tau = F.tau, .f = F.f + scene.bodies[i].mass * scene.gravity});
  }
  for (const JointConfig& j : scene.joints) {
    const std::size_t child = *body_named(scene, j.child);
    const BodyView& view = record.bodies[child];
    const Wrench& F = view.joint_C;
    const Vec3 a_W = view.X_WB.p + view.X_WB.q * j.X_BC.p;
    const Vec3 z = view.X_WB.q * j.X_BC.q * Vec3::UnitZ();
    sums[child].f += F.f;
    sums[child].tau += F.tau + (a_W - view.X_WB.p).cross(F.f);
    if (const auto parent = body_named(scene, j.parent)) {
      sums[*parent].f -= F.f;
      sums[*parent].tau -= F.tau + (a_W - record.bodies[*parent].X_WB.p).cross(F.f);
    }
    const bool turns = j.kind != JointKind::universal, slides = j.kind == JointKind::cylindrical;
    EXPECT_NEAR(turns ? F.tau.dot(z) : 0, 0, 1e-9) << j.name;
    EXPECT_NEAR(slides ? F.f.dot(z) : 0, 0, 1e-9) << j.name;
    EXPECT_GT(F.f.norm(), 1e-3) << j.name;
  }
  for (std::size_t i = 0; i < sums.size(); ++i) {
    EXPECT_LT(sums[i].f.norm(), 1e-9) << scene.bodies[i].name;
    EXPECT_LT(sums[i].tau.norm(), 1e-9) << scene.bodies[i].name;
  }
}

/// In a hand at rest, the sampled feedback keeps device and tool at rest.
TEST(ArticulatedSession, GrasperComesToRestInAHandAtRest) {
  SceneConfig scene = load_shipped("grasper.toml");
  for (CoordinateMotion& m : scene.motion->joints) m = {.coordinate = m.coordinate, .offset = m.offset};
  const Motion motion(scene);
  const Session::Made made = make_session(scene, motion, BusChoice::sim);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  ASSERT_TRUE(made.session->boot(5));
  CycleRecord record = made.session->at_start();
  double strongest = 0, fastest = 0;
  for (int i = 0; i < 4000; ++i) {
    made.session->cycle(record);
    ASSERT_EQ(record.fault, Fault::none);
    for (const BodyView& b : record.bodies) {
      strongest = std::max(strongest, b.feedback_D.f.norm());
      if (i >= 3000) fastest = std::max(fastest, b.V_WB.v.norm());
    }
  }
  EXPECT_GT(strongest, 0.05) << "the tool starts away from the hand: there was something to feel";
  EXPECT_LT(fastest, 1e-5);
}

/// Without encoders, drives and buses the same joints move a grasper to the same states.
TEST(ArticulatedSession, AnInstrumentWithoutBusesIsMovedByItsJoints) {
  for (const char* name : {"grasper.toml", "scissors-imposed.toml"}) {
    const SceneConfig with_rig = load_shipped(name);
    SceneConfig without = with_rig;
    without.device->unmeasured_tree = without.device->rig->tree;
    without.device->rig.reset();
    const LoadResult loaded = parse_scene(effective_config_toml(without), "without");
    ASSERT_THAT(loaded.errors, IsEmpty());
    const auto end_of = [](const SceneConfig& scene) {
      Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
      EXPECT_THAT(made.errors, IsEmpty());
      if (!made.session) return std::vector<Vec3>{};
      made.session->start(1);
      CycleRecord record = made.session->at_start();
      for (int i = 0; i < 500; ++i) static_cast<void>(made.session->advance(record));
      std::vector<Vec3> places;
      for (const BodyView& body : record.bodies) places.push_back(body.X_WB.p);
      return places;
    };
    const std::vector<Vec3> expected = end_of(with_rig), places = end_of(*loaded.scene);
    ASSERT_EQ(places.size(), with_rig.bodies.size());
    EXPECT_GT((places.back() - with_rig.bodies.back().X_WB.p).norm(), 1e-3) << name << ": it moves";
    for (std::size_t i = 0; i < places.size(); ++i)
      EXPECT_LT((places[i] - expected[i]).norm(), 1e-12) << name;
  }
}

TEST(ArticulatedSession, PrescribedJointNeedsAMotionOfJoints) {
  SceneConfig scene = load_shipped("scissors-imposed.toml");
  scene.motion.reset();
  const Session::Made made = make_session(scene, Motion(scene), BusChoice::direct);
  EXPECT_EQ(made.session, nullptr);
  EXPECT_THAT(made.errors, ElementsAre(HasSubstr("joint 'left_hinge' is imposed"),
                                       HasSubstr("joint 'right_hinge' is imposed")));
}

/// Returns the chain of chain.toml with n links.
SceneConfig chain_of(std::size_t n) {
  SceneConfig scene = load_shipped("chain.toml");
  const Vec3 step = scene.bodies[1].X_WB.p - scene.bodies[0].X_WB.p;
  for (std::size_t i = scene.bodies.size(); i < n; ++i) {
    BodyConfig link = scene.bodies.back();
    link.name = "link" + std::to_string(i);
    link.X_WB.p += step;
    JointConfig j = scene.joints.back();
    j.name = "joint" + std::to_string(i);
    j.parent = j.child;
    j.child = link.name;
    scene.bodies.push_back(link);
    scene.joints.push_back(j);
  }
  return scene;
}

TEST(ArticulatedSession, ChainOf256LinksHoldsTogetherAndReadsBack) {
  const std::string text = effective_config_toml(chain_of(256));
  const LoadResult loaded = parse_scene(text, "chain-256");
  ASSERT_THAT(loaded.errors, IsEmpty());
  EXPECT_THAT(loaded.warnings, IsEmpty());
  const Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::direct);
  ASSERT_NE(made.session, nullptr) << made.errors.front();
  EXPECT_EQ(made.session->engine().composition().name, "joints-256 tr-bdf2");
  CycleRecord record = made.session->at_start();
  for (int i = 0; i < 200; ++i) made.session->cycle(record);
  EXPECT_EQ(record.fault, Fault::none);
  const std::vector<BodyConfig> bodies = placed(*loaded.scene, record);
  double gap = 0;
  for (const JointConfig& j : loaded.scene->joints) gap = std::max(gap, gap_at_start(bodies, j).m);
  EXPECT_LT(gap, 1e-4);
}

}  // namespace
}  // namespace godobject::test::test_articulated_session
