// Scenes with a device that grips and releases bodies: by script, by button, through a bus.
#include "platform/simulated/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <stdexcept>

#include "platform/scene/text/key.h"
#include "platform/scene/toml.h"
#include "tests/support/allocation_guard.h"

namespace godobject::test_grip {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns three bricks in a row, 0.1 m apart; the third cannot be held. The hand swings along y.
std::string bricks(const std::string& device, const std::string& motion = "",
                   const std::string& kind = "impedance") {
  std::string text = "[scene]\nname = \"bricks\"\n";
  for (const std::string name : {"red", "green", "post"}) {
    const std::string x = name == "red" ? "0.1" : name == "green" ? "0.2" : "0.3";
    text += "[[body]]\nname = \"" + name + "\"\nmass = 0.05\ninertia = [2e-5, 3e-5, 4e-5]\nposition = [" + x +
            ", 0.0, 0.0]\n";
    if (name != "post")
      text += "[body.coupling]\nstiffness = 500\nrotational_stiffness = 0.5\n[body.feedback]\nscale = 0.5\n";
  }
  return text + "[device]\nname = \"pen\"\nkind = \"" + kind + "\"\n" + device +
         "[motion]\nposition = [0.1, 0.0, 0.02]\namplitude = [0.0, 0.05, 0.0]\nfrequency_hz = [0.0, 1.0, "
         "0.0]\n"
         "angle_amplitude = [0.5, 0.0, 0.0]\nangle_frequency_hz = [0.8, 0.0, 0.0]\n" +
         motion;
}

SceneConfig scene_of(const std::string& text) {
  const LoadResult loaded = parse_scene(text, "a.toml");
  if (!loaded.scene) throw std::runtime_error(loaded.errors.front());
  return *loaded.scene;
}

std::vector<std::string> errors_of(const std::string& text) { return parse_scene(text, "a.toml").errors; }

Motion motion_of(const SceneConfig& scene, const std::string& csv) {
  const MotionResult result = Motion::parse(csv, "m.csv", scene);
  if (!result.motion) throw std::runtime_error(result.errors.front());
  return *result.motion;
}

std::vector<std::string> errors_of(const SceneConfig& scene, const std::string& csv) {
  return Motion::parse(csv, "m.csv", scene).errors;
}

std::unique_ptr<Session> session_of(const SceneConfig& scene, const Motion& motion,
                                    BusChoice bus = BusChoice::direct) {
  Session::Made made = make_session(scene, motion, bus);
  if (!made.session) throw std::runtime_error(made.errors.front());
  if (!made.session->boot(5)) throw std::runtime_error("the rig does not boot");
  return std::move(made.session);
}

const std::string reach = "grab_radius = 0.06\n";

TEST(HoldKeys, OnlyCoupledBodiesCanBeHeld) {
  EXPECT_THAT(errors_of(bricks("holds = \"red\"\n")), IsEmpty());
  EXPECT_THAT(errors_of(bricks("holds = \"post\"\n")),
              ElementsAre(HasSubstr("'holds' is \"post\", which has no [body.coupling]: add it")));
  EXPECT_THAT(errors_of(bricks("holds = \"blue\"\n")),
              ElementsAre(HasSubstr("is \"blue\", which is not a body")));
  EXPECT_THAT(errors_of(bricks("", "[[motion.hold]]\ntime = 1\nbody = \"post\"\n")),
              ElementsAre(HasSubstr("has no [body.coupling]")));
}

TEST(HoldKeys, BadHoldsAreRefusedWithTheirPlace) {
  const std::string twice = "[[motion.hold]]\ntime = 1\nbody = \"red\"\n[[motion.hold]]\ntime = 1\n";
  const std::string text = bricks("", twice);
  const auto line =
      1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.rfind("time")), '\n');
  EXPECT_THAT(errors_of(text), ElementsAre(HasSubstr("a.toml:" + std::to_string(line) + ":")));
  EXPECT_THAT(errors_of(text), ElementsAre(HasSubstr("must be later than that of the previous table")));
  EXPECT_THAT(errors_of(bricks("", "[[motion.hold]]\ntime = 1\nbody = \"nearest\"\n")),
              ElementsAre(HasSubstr("'grab_radius'")));
  EXPECT_THAT(errors_of(bricks(reach, "", "admittance")),
              ElementsAre(HasSubstr("has no pose at which it could hold a body")));
}

TEST(HoldKeys, AreWrittenAndReadBack) {
  const SceneConfig scene = scene_of(bricks("holds = \"red\"\n" + reach,
                                            "[[motion.hold]]\ntime = 1\nbody = \"green\"\n"
                                            "[[motion.hold]]\ntime = 2\n"));
  const SceneConfig again = scene_of(effective_config_toml(scene));
  EXPECT_EQ(again.device->holds, "red");
  EXPECT_EQ(again.device->grab_radius, 0.06);
  ASSERT_EQ(again.motion->holds.size(), 2u);
  EXPECT_EQ(again.motion->holds[0].body, "green");
  EXPECT_EQ(again.motion->holds[1].body, "");
  EXPECT_EQ(again.motion->holds[1].time, 2);
}

TEST(HoldColumn, HoldsFromItsSampleToTheNext) {
  const SceneConfig scene = scene_of(bricks(reach));
  const Motion motion = motion_of(scene, "t,hold\n0,-\n1,green\n2,nearest\n3,-\n");
  using Kind = HoldWish::Kind;
  EXPECT_EQ(motion.hold(0.5), HoldWish{});
  EXPECT_EQ(motion.hold(1), (HoldWish{.kind = Kind::body, .body = 1}));
  EXPECT_EQ(motion.hold(1.999), (HoldWish{.kind = Kind::body, .body = 1}));
  EXPECT_EQ(motion.hold(2), (HoldWish{.kind = Kind::nearest}));
  EXPECT_EQ(motion.hold(9), HoldWish{});
  EXPECT_EQ(motion.target(0, 0.25).X_WD.p.y(), 0.05);  // the pose is still that of [motion]
}

TEST(HoldColumn, StandsBesideThePoseOfTheDevice) {
  const SceneConfig scene = scene_of(bricks(reach));
  const Motion motion = motion_of(scene,
                                  "t,pen.x,pen.y,pen.z,pen.qw,pen.qx,pen.qy,pen.qz,hold,button\n"
                                  "0,1,2,3,1,0,0,0,red,0\n1,2,2,3,1,0,0,0,-,1\n");
  EXPECT_EQ(motion.num_bodies(), 1u);
  EXPECT_EQ(motion.target(0, 1).X_WD.p, Vec3(2, 2, 3));
  EXPECT_FALSE(motion.button(0.9));
  EXPECT_TRUE(motion.button(1));
  EXPECT_EQ(motion.hold(0.9).kind, HoldWish::Kind::body);
}

TEST(HoldColumn, BadOnesAreRefusedWithTheirPlace) {
  const SceneConfig scene = scene_of(bricks("holds = \"red\"\n"));
  EXPECT_THAT(
      errors_of(scene, "t,hold\n0,red\n1,blue\n2,post\n3,nearest\n"),
      ElementsAre(
          HasSubstr("m.csv:3:3: 'hold' is \"blue\", which is not a body of the scene; '-' holds nothing"),
          HasSubstr("m.csv:4:3: 'hold' is \"post\", which has no [body.coupling]"),
          HasSubstr("m.csv:5:3: 'hold' is \"nearest\", which requires [device] 'grab_radius'")));
  EXPECT_THAT(errors_of(scene, "t,button\n0,0\n"), ElementsAre(HasSubstr("'grab_radius'")));
  EXPECT_THAT(errors_of(scene_of(bricks(reach)), "t,button\n0,2\n"),
              ElementsAre(HasSubstr("m.csv:2:3: 'button'")));
  EXPECT_THAT(errors_of(scene_of(bricks("")), "t,hold\n0,red\n"),
              ElementsAre(HasSubstr("requires a device that grips bodies")));
}

void expect_within_rate(const Wrench& before, const Wrench& after, const LimitConfig& limits, double h) {
  EXPECT_LE((after.f - before.f).norm(), h * limits.force_rate * (1 + 1e-9));
  EXPECT_LE((after.tau - before.tau).norm(), h * limits.torque_rate * (1 + 1e-9));
  EXPECT_LE(after.f.norm(), limits.force * (1 + 1e-9));
  EXPECT_LE(after.tau.norm(), limits.torque * (1 + 1e-9));
}

class ScriptedHolds : public testing::TestWithParam<const char*> {
 protected:
  SceneConfig scene(const std::string& device, const std::string& motion = "") const {
    SceneConfig s = scene_of(bricks(device, motion));
    s.integrator = GetParam();
    return s;
  }
};

/// Grips red from the start, then in one step green, none, and red again: one body at a time, the other moves
/// freely.
TEST_P(ScriptedHolds, OneBodyIsDrivenAtATime) {
  const SceneConfig s = scene("holds = \"red\"\n",
                              "[[motion.hold]]\ntime = 0.5\nbody = \"green\"\n"
                              "[[motion.hold]]\ntime = 1.2\n"
                              "[[motion.hold]]\ntime = 1.7\nbody = \"red\"\n");
  const std::unique_ptr<Session> session = session_of(s, Motion(s));
  CycleRecord before = session->at_start(), now = before;
  double strongest = 0;
  while (now.cycle < 2400) {
    session->cycle(now);
    ASSERT_EQ(now.fault, Fault::none);
    const std::optional<std::size_t> held = now.t < 0.4995   ? std::optional<std::size_t>(0)
                                            : now.t < 1.1995 ? std::optional<std::size_t>(1)
                                            : now.t < 1.6995 ? std::nullopt
                                                             : std::optional<std::size_t>(0);
    ASSERT_EQ(now.held, held) << now.t;
    ASSERT_EQ(now.engaged, held.has_value());
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec3 dv = now.bodies[i].V_WB.v - before.bodies[i].V_WB.v;
      if (held != i || before.held != held) {
        EXPECT_LE(dv.norm(), 1e-14) << now.t << " body " << i;
      }
      EXPECT_LE(dv.norm(), 0.05) << now.t << " body " << i;  // no jump: 50 m/s^2 of a 0.05 kg brick, 2.5 N
    }
    expect_within_rate(before.hand_W, now.hand_W, s.device->limits, s.step);
    if (now.t > 1.25 && now.t < 1.6) {
      EXPECT_EQ(now.hand_W.f.norm() + now.hand_W.tau.norm(), 0);
    }
    strongest = std::max(strongest, now.hand_W.f.norm());
    if (held && (std::fmod(now.t, 0.5) > 0.45)) {
      EXPECT_LE(now.following.m, 0.01) << now.t;
    }
    if (HasFailure()) return;
    before = now;
  }
  EXPECT_GT(strongest, 0.05);
  EXPECT_GT(now.bodies[1].V_WB.v.norm(), 0.1) << "green was not thrown";
  EXPECT_EQ(now.bodies[2].X_WB.p, Vec3(0.3, 0, 0));
}

/// The displayed wrench is about the hand, though the brick is 0.1 m off.
TEST_P(ScriptedHolds, TheDisplayedWrenchIsAboutTheOriginOfTheHand) {
  const SceneConfig s = scene("holds = \"green\"\n");
  const std::unique_ptr<Session> session = session_of(s, Motion(s));
  CycleRecord record = session->at_start();
  while (record.cycle < 1150) session->cycle(record);
  const Wrench& F = record.bodies[1].feedback_D;
  const Vec3 arm = record.bodies[1].target.X_WD.p - Motion(s).target(0, record.t).X_WD.p;
  EXPECT_GT(arm.norm(), 0.09);
  EXPECT_GT(F.f.norm(), 0.01);  // the feedback's scale keeps the stiffness, without damping
  EXPECT_LE((record.hand_W.f - F.f).norm(), 1e-12);
  EXPECT_LE((record.hand_W.tau - F.tau - arm.cross(F.f)).norm(), 1e-12);
}

TEST_P(ScriptedHolds, TheButtonTakesTheNearestWithinReach) {
  const SceneConfig s = scene(reach);
  // at 0.1 s the hand is 35 mm from red; at 1.25 s it is at least 54 mm from where red was released
  const Motion motion = motion_of(s, "t,button\n0,0\n0.1,1\n0.6,0\n0.7,1\n0.8,0\n");
  const std::unique_ptr<Session> session = session_of(s, motion);
  CycleRecord record = session->at_start();
  const auto held_at = [&](double t) {
    while (record.t < t - 0.5 * s.step) session->cycle(record);
    return record.held;
  };
  EXPECT_EQ(held_at(0.099), std::nullopt);
  EXPECT_EQ(held_at(0.1), 0u);
  EXPECT_EQ(held_at(0.599), 0u);
  EXPECT_EQ(held_at(0.6), std::nullopt);
  const Pose thrown = record.bodies[0].X_WB;
  EXPECT_EQ(held_at(0.699), std::nullopt);
  EXPECT_GT((record.bodies[0].X_WB.p - thrown.p).norm(), 1e-3);
  const double distance = (record.bodies[0].X_WB.p - motion.target(0, 0.7).X_WD.p).norm();
  EXPECT_EQ(held_at(0.7), distance <= 0.06 ? std::optional<std::size_t>(0) : std::nullopt);
  EXPECT_EQ(held_at(0.8), std::nullopt);
}

TEST_P(ScriptedHolds, NothingWithinReachIsNothing) {
  SceneConfig s = scene("grab_radius = 0.01\n", "[[motion.hold]]\ntime = 0.1\nbody = \"nearest\"\n");
  const std::unique_ptr<Session> session = session_of(s, Motion(s));
  CycleRecord record = session->at_start();
  for (int n = 0; n < 300; ++n) {
    session->cycle(record);
    EXPECT_EQ(record.held, std::nullopt);
  }
}

TEST_P(ScriptedHolds, AllocatesNothing) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "a sanitizer has taken libc's functions";
  const SceneConfig s = scene(reach,
                              "[[motion.hold]]\ntime = 0.1\nbody = \"nearest\"\n[[motion.hold]]\ntime = 0.3\n"
                              "[[motion.hold]]\ntime = 0.4\nbody = \"green\"\n");
  const std::unique_ptr<Session> session = session_of(s, Motion(s));
  CycleRecord record = session->at_start();
  AllocationGuard guard;
  for (int n = 0; n < 600; ++n) session->cycle(record);
  guard.disarm();
  EXPECT_EQ(guard.calls(), 0) << guard.report();
  EXPECT_EQ(record.held, 1u);
}

INSTANTIATE_TEST_SUITE_P(Integrators, ScriptedHolds, testing::Values("implicit-euler", "tr-bdf2"),
                         [](const auto& test) {
                           return std::string(test.param == std::string("tr-bdf2") ? "TrBdf2"
                                                                                   : "ImplicitEuler");
                         });

/// A device of increments: grips the brick in place, keeps it at rest while the clutch is open, releases it,
/// grips it again.
TEST(RelativeHolds, GrabReleaseAndClutch) {
  const SceneConfig s = scene_of(bricks("", "", "relative"));
  SceneConfig holding = s;
  holding.device->holds = "green";
  const Motion motion = motion_of(
      holding, "t,pen.clutch,hold\n0,1,green\n0.3,0,green\n0.6,1,green\n0.8,1,-\n1.0,1,red\n1.3,1,red\n");
  const std::unique_ptr<Session> session = session_of(holding, motion);
  CycleRecord before = session->at_start(), now = before;
  while (now.cycle < 1500) {
    session->cycle(now);
    ASSERT_EQ(now.fault, Fault::none);
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec3 dv = now.bodies[i].V_WB.v - before.bodies[i].V_WB.v;
      if (now.held != i || before.held != now.held) {
        EXPECT_LE(dv.norm(), 1e-14) << now.t << " body " << i;
      }
      EXPECT_LE(dv.norm(), 0.05) << now.t;
    }
    if (now.t > 0.3 && now.t < 0.5995) {
      EXPECT_EQ(now.bodies[1].target.X_WD.p, before.bodies[1].target.X_WD.p) << now.t;
    }
    expect_within_rate(before.hand_W, now.hand_W, s.device->limits, s.step);
    if (HasFailure()) return;
    before = now;
  }
  EXPECT_EQ(now.held, 0u);
  EXPECT_LE(now.following.m, 5e-3);
  const Vec3 moved = motion.target(0, 1.5).X_WD.p - motion.target(0, 1.0).X_WD.p;
  EXPECT_LE((now.bodies[0].target.X_WD.p - Vec3(0.1, 0, 0) - moved).norm(), 1e-3);
}

/// The demo's arm, encoders, drives and buses: the held body swings with the handle, a released one displays
/// no force.
TEST(HoldsThroughABus, AreThoseOfTheHandle) {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  ASSERT_TRUE(loaded.scene);
  SceneConfig s = *loaded.scene;
  s.device->grab_radius = 1;
  const Motion motion = motion_of(s, "t,button\n0,0\n0.2,1\n1.2,0\n1.6,1\n");
  const std::unique_ptr<Session> session = session_of(s, motion, BusChoice::sim);
  CycleRecord before = session->at_start(), now = before;
  double strongest = 0;
  while (now.cycle < 2400) {
    session->cycle(now);
    ASSERT_EQ(now.fault, Fault::none);
    ASSERT_EQ(now.rig_faults, RigFault::none);
    ASSERT_EQ(now.held.has_value(), motion.button(now.t)) << now.t;
    expect_within_rate(before.hand_W, now.hand_W, s.device->limits, s.step);
    if (!now.held || before.held != now.held) {
      EXPECT_LE((now.bodies[0].V_WB.v - before.bodies[0].V_WB.v).norm(), 1e-13) << now.t;
    }
    if (now.t > 1.3 && now.t < 1.6) {
      EXPECT_EQ(now.hand_W.f.norm(), 0);
    }
    strongest = std::max(strongest, now.hand_W.f.norm());
    if (HasFailure()) return;
    before = now;
  }
  EXPECT_GT(strongest, 0.1);
  EXPECT_LE(now.following.m, 5e-3);
}

/// Returns the largest error of coupling "imposed" on a smooth motion of six coordinates, under a constant
/// 100 N.
PoseError worst_when_imposed(const std::string& integrator, double step, bool by_holding) {
  SceneConfig s = scene_of(
      "[scene]\nname = \"imposed\"\ncoupling = \"imposed\"\ngravity = [600.0, 0.0, -800.0]\nstep = " +
      shortest(step) + "\nintegrator = \"" + integrator +
      "\"\n[[body]]\nname = \"tool\"\nmass = 0.1\ninertia = [3.5e-4, 2e-4, 1e-4]\n"
      "[body.coupling]\nstiffness = 100\nrotational_stiffness = 0.1\n[device]\nname = \"pen\"\nkind = "
      "\"non-haptic\"\n" +
      (by_holding ? "holds = \"tool\"\n" : "") +
      "[motion]\namplitude = [0.1, 0.08, 0.06]\nfrequency_hz = [0.5, 0.7, 1.1]\nphase = [0.0, 0.5, 1.1]\n"
      "angle_amplitude = [1.0, 0.6, 0.8]\nangle_frequency_hz = [0.4, 0.9, 0.6]\nangle_phase = [0.7, 0.3, "
      "0.0]\n");
  const std::unique_ptr<Session> session = session_of(s, Motion(s));
  CycleRecord record = session->at_start();
  PoseError worst;
  while (record.t < 3) {
    session->cycle(record);
    EXPECT_EQ(record.fault, Fault::none);
    if (record.cycle == 1) continue;  // placed
    worst.m = std::max(worst.m, record.following.m);
    worst.rad = std::max(worst.rad, record.following.rad);
  }
  return worst;
}

TEST(ImposedCoupling, PlacesTheBodyAtTheDevice) {
  for (const char* integrator : {"implicit-euler", "tr-bdf2"})
    for (const double step : {1e-3, 4e-3})
      for (const bool by_holding : {false, true}) {
        const PoseError worst = worst_when_imposed(integrator, step, by_holding);
        EXPECT_LE(worst.m, 1e-9) << integrator << " " << step << " " << by_holding;
        EXPECT_LE(worst.rad, 1e-8) << integrator << " " << step << " " << by_holding;
      }
}

TEST(ImposedCoupling, NeedsABodyAndAPose) {
  const std::string head =
      "[scene]\nname = \"a\"\ncoupling = \"imposed\"\n[[body]]\nname = \"tool\"\nmass = 1\n"
      "inertia = [1, 1, 1]\n";
  EXPECT_THAT(errors_of(head), ElementsAre(HasSubstr("no body to place: add [body.coupling]")));
  EXPECT_THAT(
      errors_of(head + "[body.coupling]\nstiffness = 1\nrotational_stiffness = 1\n[device]\nname = \"d\"\n"
                       "kind = \"admittance\"\n"),
      ElementsAre(HasSubstr("has no pose for the bodies")));
}

}  // namespace
}  // namespace godobject::test_grip
