// A user's step on a rig, RigRun, against `godobject simulate` over pseudo-terminals. However the run ends,
// the drives are off without torque, and the reason is reported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "platform/rig/run.h"
#include "tests/support/background_program.h"
#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_rig_run {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

class RigRunTest : public ProgramTest {
 protected:
  /// Starts the simulated rig; returns its addresses.
  std::vector<std::string> rig(const std::string& scene) {
    far_.emplace(std::vector<std::string>{"simulate", scene, "--realtime", "--control", "-", "--bus",
                                          "can0=pty", "--bus", "can1=pty"});
    std::vector<std::string> addresses;
    for (std::string line = far_->line(); line != "ready" && !line.empty(); line = far_->line())
      addresses.push_back(line.substr(4, 4) + "=slcan:" + line.substr(line.find(": ") + 2));
    return addresses;
  }
  /// Displays a force, and calls `then` after `num_steps` steps.
  RigRun::Result push(RigRun& run, int num_steps, const std::function<bool()>& then) {
    int steps = 0;
    return run.run([&](std::span<const BodySample> samples, std::span<Wrench> F_hand_W) {
      for (Wrench& F : F_hand_W) F.f = Vec3(0.3, 0.3, 0.3);
      valid_ += samples[0].valid ? 1 : 0;
      return ++steps < num_steps || then();
    });
  }
  /// Runs a rig as push() does, with the number of earlier calls for `then`. Repeats a run that has faults
  /// and missed deadlines, because drives of a late host must switch off.
  RigRun::Result push_in_time(int num_steps, const std::function<bool(int)>& then) {
    const std::string scene = write("scene.toml", patient_toml());
    RigRun::Result result;
    for (int i = 0; i < 4; ++i) {
      RigRun run(scene, rig(scene));
      EXPECT_THAT(run.errors(), IsEmpty());
      if (!run.errors().empty()) break;
      EXPECT_EQ(run.step_s(), 5e-3);
      int calls = 0;
      result = push(run, num_steps, [&] { return then(calls++); });
      if (result.missed_deadlines == 0 || result.faults.empty()) break;
    }
    return result;
  }
  nlohmann::json drives() { return nlohmann::json::parse(far_->say("status"))["drives"]; }
  void expect_no_torque() {
    for (const nlohmann::json& drive : drives()) {
      EXPECT_EQ(drive["torque_Nm"], 0) << drive;
      EXPECT_GT(drive["max_torque_Nm"], 0) << "it never pushed: this says nothing: " << drive;
    }
  }

  std::optional<BackgroundProgram> far_;
  int valid_ = 0;  // steps with a valid sample
};

TEST_F(RigRunTest, AfterItsLastStepTheTorqueIsGone) {
  const RigRun::Result result = push_in_time(200, [](int) { return false; });
  EXPECT_TRUE(result.is_good()) << result.why_not << result.faults;
  EXPECT_EQ(result.steps, 200u);
  EXPECT_GT(valid_, 0);
  EXPECT_EQ(result.signal, "");
  expect_no_torque();
}

TEST_F(RigRunTest, ASignalRunsTheTorqueDown) {
  const RigRun::Result result = push_in_time(200, [](int calls) {
    if (calls == 0) raise(SIGTERM);
    return true;
  });
  EXPECT_EQ(result.signal, "SIGTERM") << result.faults;
  EXPECT_LE(result.steps, 201u);
  EXPECT_EQ(result.faults, "");
  expect_no_torque();
}

// Simulated hardware has no fault unless it was set up: it is not late with its program.
TEST_F(RigRunTest, DrivesOfASimulatorThatIsHeldUpStayEnabled) {
  const RigRun::Result result = push_in_time(200, [&](int calls) {
    if (calls == 0) kill(far_->pid(), SIGSTOP);
    if (calls == 20) kill(far_->pid(), SIGCONT);  // five deadlines of a drive later
    return calls < 60;
  });
  EXPECT_TRUE(result.is_good()) << result.why_not << result.faults;
  kill(far_->pid(), SIGCONT);
  EXPECT_GT(nlohmann::json::parse(far_->say("status"))["held_s"], 0.08);
}

TEST_F(RigRunTest, AFaultOfTheRigEndsItAndIsNamed) {
  const std::string scene = write("scene.toml", patient_toml());
  RigRun run(scene, rig(scene));
  ASSERT_THAT(run.errors(), IsEmpty());
  bool done = false;
  const RigRun::Result result = push(run, 200, [&] {
    if (!std::exchange(done, true)) static_cast<void>(far_->say("fault unplug bus=can0 node=1"));
    return true;
  });
  EXPECT_FALSE(result.is_good());
  EXPECT_NE(result.faults, "");
  expect_no_torque();
}

// A terminal stamps frames when it reads them, so late answers look like fresh ones. The pause at the
// beginning of the delay alone is no fault.
TEST_F(RigRunTest, ADelayBeyondStaleAfterIsSampleStale) {
  std::string text = patient_toml();
  replace(text, "stale_after = 0.2", "stale_after = 0.05");
  for (std::size_t at = 0; (at = text.find("joint_per_motor_rad", at)) != std::string::npos; at += 40)
    text.insert(at, "max_slip = 0.0\n");  // else the drives may show it first
  const std::string scene = write("scene.toml", text);
  RigRun::Result result;
  constexpr int attempts = 4;  // a machine that is busy may leave the drives without a command for 20 ms
  for (int i = 0; i < attempts && result.faults.find("sample_stale (can0 node") == std::string::npos; ++i) {
    RigRun run(scene, rig(scene));
    ASSERT_THAT(run.errors(), IsEmpty());
    int more = 0;
    result = push(run, 200, [&] {
      if (more == 0) static_cast<void>(far_->say("fault delay bus=can0 value=0.1"));
      return ++more < 600;
    });
    EXPECT_NE(result.faults, "");
  }
  EXPECT_THAT(result.faults, HasSubstr("sample_stale (can0 node")) << result.why_not;
  expect_no_torque();
}

TEST_F(RigRunTest, WhatCannotBeSaysWhyAndSendsNothing) {
  const std::string scene = write("scene.toml", patient_toml());
  EXPECT_THAT(RigRun("no.toml", {}).errors(), Contains(HasSubstr("no.toml")));
  EXPECT_THAT(RigRun(GODOBJECT_SOURCE_DIR "/sim/scenes/net-small.toml", {}).errors(),
              Contains(HasSubstr("has no buses: add them")));
  const std::vector<std::string> one{"can0=slcan:/dev/null"};
  EXPECT_THAT(RigRun(scene, one).errors(),
              Contains(HasSubstr("bus 'can1' of the scene has no address: give can0=ADDRESS can1=ADDRESS")));
  std::string crowded = patient_toml();
  for (std::size_t at = 0; (at = crowded.find("[[bus]]\n", at)) != std::string::npos; at += 8)
    crowded.insert(at + 8, "bit_rate = 20e3\n");
  const std::vector<std::string> both{"can0=slcan:/dev/null", "can1=slcan:/dev/null"};
  EXPECT_THAT(RigRun(write("crowded.toml", crowded), both).errors(),
              Contains(HasSubstr("crowded.toml: bus can0: worst-case load")));
  const std::vector<std::string> closed{"can0=slcan:/dev/null", "can1=slcan:/nowhere"};
  EXPECT_THAT(RigRun(scene, closed).errors(), Contains(HasSubstr("bus can1 (slcan:/nowhere): ")));
}

}  // namespace
}  // namespace godobject::test::test_rig_run
