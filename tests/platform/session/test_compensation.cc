// Drives that compensate the weight, friction and delay of their own device, on simulated buses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <random>
#include <stdexcept>
#include <string>

#include "platform/scene/toml.h"
#include "platform/session/passivity.h"
#include "platform/simulated/session.h"
#include "sim/rig/plant.h"
#include "tests/support/desk_scene.h"

namespace godobject {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double mass = 0.2, gravity = 9.81, hand_stiffness = 500;  // kg, m/s^2, N/m

/// Returns a device of three slides whose last link weighs 0.2 kg.
std::string heavy_desk(const std::string& plant, const std::string& compensation,
                       const std::string& feedback = "stiffness = 20\n") {
  std::string text = test::desk_scene(
      feedback, plant + "inertia = 0.3\nhand_stiffness = 500\nhand_damping = 20\n[device.compensation]\n" +
                    compensation);
  const std::string name = "name = \"z\"\n";
  text.insert(text.find(name) + name.size(), "mass = 0.2\ncenter_of_mass = [0.0, 0.0, 0.05]\n");
  return text;
}

SceneConfig parsed(const std::string& text) {
  auto loaded = parse_scene(text, "desk.toml");
  if (!loaded.scene) throw std::runtime_error(loaded.errors.front());
  return *loaded.scene;
}

/// Differences between the device and the hand that moves it, by joint, in a run of 3 s.
struct Sag {
  Vec3 mean = Vec3::Zero();
  double against_x = 0;  // mean against the motion of the first joint, while it is fast
};

Sag sag(const std::string& text) {
  const SceneConfig scene = parsed(text);
  const Motion motion(scene);
  Session::Made made = make_session(scene, motion, BusChoice::sim);
  if (!made.session) throw std::runtime_error(made.errors.front());
  if (!made.session->boot(5)) throw std::runtime_error("the rig does not boot");
  CycleRecord record = made.session->at_start();
  Sag sag;
  int n = 0, n_fast = 0;
  while (record.cycle < 3000) {
    made.session->cycle(record);
    if (record.rig_faults != RigFault::none) throw std::runtime_error("the rig has faults");
    if (record.cycle < 1000) continue;  // ramps, and the sag itself comes to rest
    const JointTarget hand = motion.joints(record.t);
    const Vec3 apart(record.device_q[0] - hand.q(0), record.device_q[1] - hand.q(1),
                     record.device_q[2] - hand.q(2));
    sag.mean += apart;
    ++n;
    if (std::abs(hand.q_dot(0)) < 0.05) continue;
    sag.against_x -= hand.q_dot(0) > 0 ? apart.x() : -apart.x();
    ++n_fast;
  }
  sag.mean /= n;
  sag.against_x /= n_fast;
  return sag;
}

const std::string earth = "gravity = [0, 0, -9.81]\n", no_friction = "friction = 0\n";

TEST(Compensation, TheHandCarriesTheLinksWithoutIt) {
  EXPECT_NEAR(sag(heavy_desk(earth + no_friction, "")).mean.z(), -mass * gravity / hand_stiffness, 1e-4);
  EXPECT_NEAR(sag(heavy_desk(no_friction, "")).mean.z(), 0, 1e-4);
}

TEST(Compensation, TheDrivesCarryTheLinks) {
  const Sag compensated = sag(heavy_desk(earth + no_friction, "gravity = true\n"));
  EXPECT_NEAR(compensated.mean.z(), 0, 1e-4);
  EXPECT_NEAR(compensated.mean.x(), 0, 1e-4);
}

TEST(Compensation, FrictionIsFeltByItsShareThatRemains) {
  constexpr double friction = 2;  // N
  const auto felt_N = [](const std::string& share) {
    return hand_stiffness * sag(heavy_desk("friction = 2\ndamping = 0\n", share)).against_x;
  };
  const double without = felt_N("");
  EXPECT_GT(without, 0.9 * friction);
  for (const double share : {0.5, 0.9})
    EXPECT_NEAR(without - felt_N("friction = " + std::to_string(share) + "\n"), share * friction,
                0.08 * friction);
}

// The friction removes at least the power that its compensation adds, however late the measured speed is.
TEST(Compensation, FrictionNeverFeedsAFreeAxis) {
  std::mt19937 random(1);
  const auto between = [&](double a, double b) { return std::uniform_real_distribution(a, b)(random); };
  for (int trial = 0; trial < 300; ++trial) {
    const JointPlant plant{.inertia = std::pow(10, between(-4, 0)),
                           .damping = 0,
                           .friction = between(0.01, 1),
                           .hand_stiffness = 0,
                           .hand_damping = 0};
    const CompensationParams params{.friction = {between(0, 1) * plant.friction},
                                    .certain_speed = {std::pow(10, between(-4, 1))}};
    KinematicTreeParams tree;
    tree.joints = {{.name = "slide", .kind = DeviceJointKind::slider}};
    const TreeConfiguration at = KinematicTree(tree).at(JointVector::Zero(1));
    SimPlant axis(plant, 1, true, JointVector::Zero(1), 0);
    std::deque<double> measured(std::uniform_int_distribution<std::size_t>(1, 20)(random), 0.0);
    double before = 0;
    for (int k = 1; k < 1000; ++k) {
      measured.push_back(axis.q_dot()(0) + between(-1, 1) * 0.1 * params.certain_speed[0]);
      const JointVector late = JointVector::Constant(1, measured.front());
      measured.pop_front();
      const double kick = k <= 50 ? 3 * plant.friction : 0;
      axis.set_motor_torque(0, k <= 50 ? kick : compensating_torques(params, at, late)(0));
      axis.advance(k * 1'000'000, JointVector::Zero(1), JointVector::Zero(1));
      const double now = std::abs(axis.q_dot()(0));
      if (k > 50) {
        ASSERT_LE(now, before * (1 + 1e-12)) << trial << " at " << k;
      }
      before = now;
    }
  }
}

// The handle is displayed where it will be when the torque acts: (8) has more damping, which counts.
TEST(Compensation, HandlesArePredicted) {
  constexpr double stiffness = 200, ahead_s = 1.5e-3;
  const auto desk = [](const std::string& ahead) {
    return parsed(heavy_desk("", ahead, "stiffness = 200\ndamping = 1\n"));
  };
  const auto damping = [](const SceneConfig& scene) {
    return passivity(scene, joints_at_start(scene, Motion(scene))).joints.front().axis.B;
  };
  EXPECT_NEAR(damping(desk("ahead = 0.0015\n")) - damping(desk("")), stiffness * ahead_s, 1e-12);

  const SceneConfig scene = desk("ahead = 0.0015\n");
  const Motion motion(scene);
  Session::Made made = make_session(scene, motion, BusChoice::sim);
  ASSERT_TRUE(made.session && made.session->boot(5));
  CycleRecord record = made.session->at_start();
  double shown_ahead = 0, way_ahead = 0;  // m
  while (record.cycle < 2000) {
    made.session->cycle(record);
    if (record.cycle < 1000) continue;
    shown_ahead += record.sensing.m;
    way_ahead += ahead_s * motion.joints(record.t).q_dot.norm();
  }
  EXPECT_NEAR(shown_ahead, way_ahead, 0.1 * way_ahead);
}

// The weight is a spring of a joint that turns: compensated late, it needs damping as any displayed spring.
TEST(Compensation, ItsStiffnessCountsInThePassivityOfAnAxis) {
  SceneConfig scene = parsed(heavy_desk(earth, "gravity = true\n"));
  RigParams& rig = *scene.device->rig;
  rig.tree.joints.back() = {.name = "z", .axis_J = Vec3::UnitX(), .mass = 0.2, .p_LM = Vec3(0, 0.1, 0)};
  const auto stiffness = [&](double angle) {
    JointVector q = JointVector::Zero(3);
    q(2) = angle;
    return passivity(scene, q).joints.back().axis.K;
  };
  const double of_feedback = [&] {
    SceneConfig light = scene;
    light.device->rig->compensation = {};
    return passivity(light, JointVector::Zero(3)).joints.back().axis.K;
  }();
  const double moment = mass * gravity * 0.1;  // N m; the arm is level at 0, and falls to -pi/2
  for (const double angle : {-1.5, -0.7, 0.0, 0.4, 1.5})
    EXPECT_NEAR(stiffness(angle) - of_feedback, moment * std::sin(angle), 1e-6) << angle;
  // the controller acts on the displayed torque alone
  JointVector q = JointVector::Zero(3);
  q(2) = 0.4;
  EXPECT_NEAR(passivity_controllers(scene, q).back().stiffness, of_feedback, 1e-6);
}

std::vector<std::string> errors_of(const std::string& text) { return parse_scene(text, "desk.toml").errors; }

TEST(Compensation, KeysThatCannotActAreRefused) {
  EXPECT_THAT(errors_of(heavy_desk(earth, "gravity = true\nfriction = 0.9\nahead = 1e-3\n")), IsEmpty());
  EXPECT_THAT(errors_of(heavy_desk("", "gravity = true\n")),
              ElementsAre(HasSubstr("has nothing to carry: give `mass` in [[device.joint]]")));
  EXPECT_THAT(errors_of(heavy_desk("", "friction = 1.2\n")), ElementsAre(HasSubstr("'friction'")));
  EXPECT_THAT(errors_of("[scene]\nname = \"a\"\n[[body]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, 1]\n"
                        "[body.coupling]\nstiffness = 10\nrotational_stiffness = 1\n"
                        "[device]\nname = \"d\"\n[device.compensation]\nfriction = 0.5\n"),
              ElementsAre(HasSubstr("needs drives: add [[device.drive]]")));
}

}  // namespace
}  // namespace godobject
