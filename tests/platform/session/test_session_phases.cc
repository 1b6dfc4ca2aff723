// The phases of a run, period by period, on simulated buses: their order, and the state after a restart.
#include <gtest/gtest.h>

#include <vector>

#include "platform/scene/toml.h"
#include "platform/simulated/session.h"

namespace godobject::test_session_phases {
namespace {

class SessionPhases : public testing::Test {
 protected:
  SessionPhases() { make(*load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml").scene); }
  void make(const SceneConfig& scene) {
    Session::Made made = make_session(scene, Motion(scene), BusChoice::sim);
    session_ = std::move(made.session);
    record_ = session_->at_start();
  }
  /// Runs periods until the phase changes; returns the number of steps.
  int run_phase(int limit = 20'000) {
    const RunPhase phase = session_->phase();
    int steps = 0;
    for (int i = 0; i < limit && session_->phase() == phase; ++i) steps += session_->advance(record_) ? 1 : 0;
    return steps;
  }

  std::unique_ptr<Session> session_;
  CycleRecord record_;
};

TEST_F(SessionPhases, FollowOneAnother) {
  EXPECT_EQ(session_->phase(), RunPhase::off);
  session_->start(5);
  EXPECT_EQ(session_->phase(), RunPhase::booting);
  EXPECT_EQ(run_phase(), 0);
  ASSERT_EQ(session_->phase(), RunPhase::running);
  EXPECT_EQ(session_->rig()->state(), RigState::armed);
  EXPECT_EQ(run_phase(700), 700);
  session_->stop();
  EXPECT_EQ(session_->phase(), RunPhase::running_down);
  EXPECT_EQ(run_phase(), 0);
  EXPECT_EQ(session_->phase(), RunPhase::closing);
  EXPECT_EQ(session_->rig()->state(), RigState::off);
  EXPECT_EQ(run_phase(), 0);
  EXPECT_EQ(session_->phase(), RunPhase::ended);
  EXPECT_FALSE(session_->advance(record_));
}

TEST_F(SessionPhases, StoppedWhileBootingNeverArms) {
  session_->start(5);
  for (int i = 0; i < 3; ++i) session_->advance(record_);
  session_->stop();
  session_->shut_down();
  EXPECT_EQ(session_->phase(), RunPhase::ended);
  EXPECT_EQ(record_.cycle, 0u);
}

/// A device that is never ready.
class DeadDevice final : public HandDevice {
 public:
  explicit DeadDevice(double boot_limit_s) : boot_limit_s_(boot_limit_s) {}
  std::optional<double> boot_limit_s() const noexcept override { return boot_limit_s_; }
  bool ready() const noexcept override { return false; }
  void read(Period&, std::span<BodySample>) noexcept override {}
  bool makes_torque() const noexcept override { return true; }

 private:
  double boot_limit_s_;
};

TEST(DevicePhases, BootIsGivenUpAfterTheLongestLimit) {
  for (const double boot_limit_s : {0.0, 2e-3, 5e-3}) {
    DeadDevice device(boot_limit_s);
    DevicePhases phases(1e-3);
    phases.add(device);
    phases.start(2e-3);
    int periods = 0;
    for (; phases.phase() == RunPhase::booting && periods < 100; ++periods) phases.advance(0);
    EXPECT_EQ(periods, boot_limit_s == 5e-3 ? 5 : 2);
    EXPECT_EQ(phases.phase(), RunPhase::running_down);
  }
}

/// A shorter limit of the caller does not end the boot before the fault of the rig, which names the node.
TEST_F(SessionPhases, BootLastsUntilTheRigReportsTheMissingNode) {
  for (const double boot_timeout_s : {0.5, 12.0}) {
    SceneConfig scene = *load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml").scene;
    scene.device->rig->boot_timeout_s = boot_timeout_s;
    scene.faults = {{.verb = "unplug", .bus = "can0", .node_id = 2, .at = 0}};
    make(scene);
    EXPECT_FALSE(session_->boot(2e-3));
    const Rig& rig = *session_->rig();
    EXPECT_TRUE(any(rig.faults() & RigFault::boot_timeout));
    EXPECT_EQ(rig.fault_log().first(RigFault::boot_timeout).place.node_id, 2);
    EXPECT_NEAR(1e-9 * static_cast<double>(session_->bus_time_ns()), boot_timeout_s, shut_down_limit_s);
  }
}

/// The engine keeps its state; the coupling engages with the ramp again.
TEST_F(SessionPhases, RestartEngagesByTheRamp) {
  ASSERT_TRUE(session_->boot(5));
  run_phase(900);
  ASSERT_FALSE(has(record_.limited, Limited::ramp));
  const std::uint64_t syncs = session_->rig_counters().syncs;
  session_->shut_down();
  const std::uint64_t hash = session_->engine().state_hash();
  session_->restart();
  EXPECT_EQ(session_->phase(), RunPhase::off);
  ASSERT_TRUE(session_->boot(5));
  EXPECT_EQ(session_->engine().state_hash(), hash);
  EXPECT_GT(session_->rig_counters().syncs, syncs) << "those of the first rig count";
  session_->advance(record_);
  EXPECT_EQ(record_.cycle, 901u);
  EXPECT_FALSE(record_.engaged);
  session_->advance(record_);
  EXPECT_TRUE(record_.engaged);
  EXPECT_TRUE(has(record_.limited, Limited::ramp));
  EXPECT_EQ(record_.rig_faults, RigFault::none);
}

}  // namespace
}  // namespace godobject::test_session_phases
