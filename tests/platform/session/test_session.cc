// A running scene while the user releases, grips again and uses the clutch.
#include "platform/simulated/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "core/math/so3.h"
#include "platform/scene/text/key.h"
#include "platform/scene/toml.h"

namespace godobject::test_session {
namespace {

/// Cycles in which a switch changes; it begins on.
struct Flips {
  std::vector<std::uint64_t> cycles;

  bool on(std::uint64_t cycle) const {
    return std::ranges::count_if(cycles, [&](std::uint64_t c) { return c <= cycle; }) % 2 == 0;
  }
  bool flips(std::uint64_t cycle) const { return std::ranges::find(cycles, cycle) != cycles.end(); }
  /// Returns a table of this switch alone, each change half a step before its cycle.
  std::string csv(const std::string& column, double h) const {
    std::string text = "t," + column + "\n0,1\n";
    for (const std::uint64_t c : cycles)
      text += shortest((static_cast<double>(c) - 0.5) * h) + (on(c) ? ",1\n" : ",0\n");
    return text;
  }
};

/// Parameters: scene file, bus, integrator.
using Case = std::tuple<std::string, BusChoice, std::string>;

std::string name_of(const testing::TestParamInfo<Case>& info) {
  const auto& [scene, bus, integrator] = info.param;
  std::string name = scene + (bus == BusChoice::sim ? "_sim_" : "_direct_") + integrator;
  std::ranges::replace_if(
      name, [](char c) { return c == '-' || c == '.'; }, '_');
  return name;
}

class SessionSwitches : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    LoadResult loaded =
        load_scene(std::string(GODOBJECT_SOURCE_DIR "/sim/scenes/") + std::get<0>(GetParam()));
    ASSERT_TRUE(loaded.scene.has_value()) << loaded.errors.front();
    scene_ = *std::move(loaded.scene);
    scene_.integrator = std::get<2>(GetParam());
  }

  /// Returns a booted session with the scene's own motion and the switches of the table.
  std::unique_ptr<Session> session(const std::string& csv) const {
    const MotionResult motion = Motion::parse(csv, "switches.csv", scene_);
    if (!motion.motion) throw std::runtime_error(motion.errors.front());
    Session::Made made = make_session(scene_, *motion.motion, std::get<1>(GetParam()));
    if (!made.session) throw std::runtime_error(made.errors.front());
    if (!made.session->boot(5)) throw std::runtime_error("the rig does not boot");
    return std::move(made.session);
  }

  double h() const { return scene_.step; }

  SceneConfig scene_;
};

using SessionEngage = SessionSwitches;
using SessionFollow = SessionSwitches;
using SessionClutch = SessionSwitches;
using SessionShutDown = SessionSwitches;

/// Expects a step by the previous velocity. The position is exact; the attitude differs by the gyroscopic
/// torque. That changes the angular velocity of a body of revolution by less than w^2 per second.
void expect_moved_freely(const BodyView& before, const BodyView& after, double h) {
  const double w_sq = before.V_WB.w.squaredNorm();
  const Quat q = exp_so3(h * before.V_WB.w) * before.X_WB.q;
  EXPECT_LE((after.X_WB.p - before.X_WB.p - h * before.V_WB.v).norm(), 1e-14);
  EXPECT_LE((after.V_WB.v - before.V_WB.v).norm(), 1e-13);
  EXPECT_LE(rotation_error(after.X_WB.q, q, Vec3::Zero()).phi_B.norm(), h * h * w_sq + 1e-13);
  EXPECT_LE((after.V_WB.w - before.V_WB.w).norm(), h * w_sq + 1e-12);
}

void expect_within_rate(const Wrench& before, const Wrench& after, const LimitConfig& limits, double h) {
  EXPECT_LE((after.f - before.f).norm(), h * limits.force_rate * (1 + 1e-12));
  EXPECT_LE((after.tau - before.tau).norm(), h * limits.torque_rate * (1 + 1e-12));
}

/// Releases and grips in mid-motion: with the ramp complete and in progress, for long and for one cycle.
TEST_P(SessionEngage, NeverMovesTheBodyNorJumpsTheForce) {
  const Flips engaged{{600, 630, 700, 715, 1100, 1300, 1301, 1302}};
  const std::unique_ptr<Session> s = session(engaged.csv("tool.engaged", h()));
  CycleRecord before = s->at_start(), now;
  double fastest = 0, strongest = 0;
  for (std::uint64_t cycle = 1; cycle <= 2000; ++cycle) {
    SCOPED_TRACE("cycle " + std::to_string(cycle));
    s->cycle(now);
    ASSERT_EQ(now.fault, Fault::none);
    ASSERT_EQ(now.rig_faults, RigFault::none);
    const BodyView &x = before.bodies[0], &y = now.bodies[0];
    if (engaged.flips(cycle) || !engaged.on(cycle)) expect_moved_freely(x, y, h());
    if (engaged.flips(cycle)) fastest = std::max(fastest, y.V_WB.v.norm());
    expect_within_rate(x.feedback_D, y.feedback_D, scene_.device->limits, h());
    const double force = y.feedback_D.f.norm();
    EXPECT_TRUE(cycle < 1110 || cycle >= 1300 || force == 0) << force;  // 5 N at 500 N/s: 10 cycles
    if (engaged.on(cycle)) strongest = std::max(strongest, force);
    if (HasFailure()) return;
    before = now;
  }
  EXPECT_GT(fastest, 0.05) << "not in mid-motion";
  EXPECT_EQ(strongest > 0.1, scene_.bodies[0].feedback.has_value());
}

/// The body stops following when released, and follows again when gripped.
TEST_P(SessionFollow, ReleasesAndFollowsAgain) {
  const Flips engaged{{1000, 1300}};
  const std::unique_ptr<Session> s = session(engaged.csv("tool.engaged", h()));
  CycleRecord record;
  const auto run_to = [&](std::uint64_t cycle) {
    while (record.cycle < cycle) s->cycle(record);
    return record.following.m;
  };
  const double held = run_to(999), free = run_to(1299), again = run_to(2300);
  EXPECT_LT(held, 5e-3);
  EXPECT_GT(free, 10e-3);
  EXPECT_LT(again, 5e-3);
}

TEST_P(SessionEngage, SwitchesThatStayOnChangeNothing) {
  const std::unique_ptr<Session> with = session("t,tool.engaged,tool.clutch\n0,1,1\n");
  Session::Made without = make_session(scene_, Motion(scene_), std::get<1>(GetParam()));
  ASSERT_TRUE(without.session->boot(5));
  CycleRecord record;
  for (int i = 0; i < 300; ++i) {
    with->cycle(record);
    without.session->cycle(record);
  }
  EXPECT_EQ(with->engine().state_hash(), without.session->engine().state_hash());
}

auto on_both_buses(const std::vector<std::string>& scenes) {
  return testing::Combine(testing::ValuesIn(scenes), testing::Values(BusChoice::direct, BusChoice::sim),
                          testing::Values("implicit-euler", "tr-bdf2"));
}

const std::vector<std::string> followers{"rigid.toml", "non-haptic.toml", "relative.toml"};

INSTANTIATE_TEST_SUITE_P(Followers, SessionEngage, on_both_buses(followers), name_of);
INSTANTIATE_TEST_SUITE_P(Pushed, SessionEngage,
                         testing::Combine(testing::Values("admittance.toml"),
                                          testing::Values(BusChoice::direct),
                                          testing::Values("implicit-euler", "tr-bdf2")),
                         name_of);
INSTANTIATE_TEST_SUITE_P(Followers, SessionFollow, on_both_buses(followers), name_of);

/// With the clutch open the device moves and the target rests; closing it again causes no jump.
TEST_P(SessionClutch, OpenTheTargetRests) {
  const Flips clutch{{700, 900}};
  const std::unique_ptr<Session> s = session(clutch.csv("tool.clutch", h()));
  const Motion device(scene_);
  CycleRecord before, now;
  s->cycle(before);  // engages: from here on there is a target
  for (std::uint64_t cycle = 2; cycle <= 1200; ++cycle) {
    SCOPED_TRACE("cycle " + std::to_string(cycle));
    s->cycle(now);
    ASSERT_EQ(now.fault, Fault::none);
    const Target &x = before.bodies[0].target, &y = now.bodies[0].target;
    if (clutch.on(cycle)) {
      // The device's own step; the encoders round to 5 um and 0.1 mrad, the arm lags behind the hand.
      const Twist V = device.target(0, h() * static_cast<double>(cycle)).V_WD;
      EXPECT_LE((y.X_WD.p - x.X_WD.p).norm(), 1.2 * h() * V.v.norm() + 20e-6);
      EXPECT_LE(rotation_error(x.X_WD.q, y.X_WD.q, Vec3::Zero()).phi_B.norm(), 1.2 * h() * V.w.norm() + 4e-4);
    } else {
      EXPECT_EQ(y.X_WD.p, x.X_WD.p);
      EXPECT_EQ(y.X_WD.q.coeffs(), x.X_WD.q.coeffs());
      EXPECT_EQ(y.V_WD.v.norm() + y.V_WD.w.norm(), 0);
    }
    EXPECT_TRUE(cycle != 699 || now.bodies[0].V_WB.v.norm() > 0.05) << "not in mid-motion";
    EXPECT_TRUE(cycle != 899 || now.following.m < 1e-6) << "the body has not come to rest on it";
    if (HasFailure()) return;
    before = now;
  }
  const double missed = (device.target(0, 899 * h()).X_WD.p - device.target(0, 699 * h()).X_WD.p).norm();
  const double offset = (now.bodies[0].target.X_WD.p - device.target(0, 1200 * h()).X_WD.p).norm();
  EXPECT_GT(missed, 5e-3);
  EXPECT_NEAR(offset, missed, 0.1 * missed);
}

/// For any torque of the motors; the state does not change.
TEST_P(SessionShutDown, TurnsTheMotorsOff) {
  const std::unique_ptr<Session> s = session("t,tool.engaged\n0,1\n");
  CycleRecord record;
  const auto torque = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < s->rig()->num_drives(); ++i)
      sum += std::abs(s->rig()->commanded_torque_Nm(i));
    return sum;
  };
  for (int i = 0; i < 2000 && (i < 700 || torque() < 1e-3); ++i) s->cycle(record);
  ASSERT_GT(torque(), 1e-3);
  const std::uint64_t hash = s->engine().state_hash();
  const Nanoseconds motion_start = s->motion_start_ns();
  s->shut_down();
  EXPECT_EQ(torque(), 0);
  EXPECT_EQ(s->rig()->state(), RigState::off);
  EXPECT_EQ(s->rig()->faults(), RigFault::none);
  EXPECT_EQ(s->engine().state_hash(), hash);
  EXPECT_EQ(s->motion_start_ns(), motion_start);
  s->shut_down();  // a second call has no effect
  EXPECT_EQ(s->rig()->state(), RigState::off);
}

INSTANTIATE_TEST_SUITE_P(Haptic, SessionShutDown,
                         testing::Values(Case{"rigid.toml", BusChoice::sim, "tr-bdf2"}), name_of);
INSTANTIATE_TEST_SUITE_P(Relative, SessionClutch, on_both_buses({"relative.toml"}), name_of);

}  // namespace
}  // namespace godobject::test_session
