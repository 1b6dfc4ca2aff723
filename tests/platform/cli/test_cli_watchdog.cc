// Messages of `godobject check` and `godobject run` about drives without a watchdog.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_watchdog {
namespace {

using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

class CliWatchdog : public ProgramTest {
 protected:
  /// Returns two_joints with `drive` in place of the drives' profile.
  std::string scene_with(const std::string& drive) const {
    const std::string profile = "profile = \"generic-402\"\n";
    std::string text = two_joints_toml;
    for (std::size_t at = 0; (at = text.find(profile, at)) != std::string::npos; at += drive.size())
      text.replace(at, profile.size(), drive);
    return write("scene.toml", text);
  }
};

TEST_F(CliWatchdog, DrivesThatNothingStopsAreRefused) {
  const std::string scene = scene_with("");
  for (const std::string& arguments : {"check " + scene, "run " + scene, "run --bus direct " + scene,
                                       "run --bus can0=pty --bus can1=pty " + scene}) {
    const ProgramResult result = run_program(arguments + " 2>&1 < /dev/null", "timeout 20 ");
    EXPECT_EQ(result.exit_code, 2) << arguments << '\n' << result.output;
    EXPECT_THAT(result.output,
                AllOf(HasSubstr("drive of joint 'turret' (can1 node 1) has no watchdog"),
                      HasSubstr("drive of joint 'elbow' (can1 node 2) has no watchdog"),
                      HasSubstr("profile = \"generic-402\""), HasSubstr("watchdog = \"none\"")))
        << arguments;
  }
}

TEST_F(CliWatchdog, UnlessTheSceneSaysSo) {
  const std::string scene = scene_with("watchdog = \"none\"\n");
  const ProgramResult checked = run_program("check " + scene);
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
  EXPECT_THAT(checked.output,
              ContainsRegex("turret \\(can1 node 1\\) +never +accepted by watchdog = \"none\""));
  const ProgramResult ran = run_program("run --duration 0.1 " + scene);
  EXPECT_EQ(ran.exit_code, 0) << ran.output;
}

TEST_F(CliWatchdog, SceneThatShowsNoForceMayHaveThem) {
  std::string text = read_file(scene_with(""));
  const std::string kind = "\"impedance\"";
  text.replace(text.find(kind), kind.size(), "\"non-haptic\"");
  text.erase(text.find("[body.feedback]"), text.find("[[bus]]") - text.find("[body.feedback]"));
  const ProgramResult checked = run_program("check " + write("scene.toml", text));
  EXPECT_EQ(checked.exit_code, 0) << checked.output;
}

TEST_F(CliWatchdog, CheckShowsTheTimeToZeroOfEachDrive) {
  const auto table_of = [&](const std::string& drive) {
    const ProgramResult result = run_program("check " + scene_with(drive));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return result.output;
  };
  EXPECT_THAT(table_of("profile = \"generic-402\"\n"),
              ContainsRegex("turret \\(can1 node 1\\) +20 ms +RPDO1 deadline, 1400h:05"));
  EXPECT_THAT(table_of("protocol = \"odrive\"\nwatchdog = \"drive\"\nwatchdog_ms = 30\n"),
              ContainsRegex("elbow \\(can1 node 2\\) +30 ms +the drive's own configuration"));
}

TEST_F(CliWatchdog, EveryShippedSceneIsStoppedInTwentyMilliseconds) {
  for (const char* const scene : {"grasp", "grasper", "organ", "rigid", "scissors-imposed"}) {
    const ProgramResult result = run_program("check sim/scenes/" + std::string(scene) + ".toml");
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_THAT(result.output, ContainsRegex("node 1\\) +20 ms +RPDO1 deadline")) << scene;
    EXPECT_THAT(result.output, Not(ContainsRegex("node [0-9]+\\) +never"))) << scene;
  }
}

TEST_F(CliWatchdog, AHeartbeatTooSlowForTheProfileIsReportedWithAFastEnoughOne) {
  const ProgramResult result = run_program("check " + scene_with("profile = \"epos4\"\n"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, AllOf(HasSubstr("epos4.toml:"), HasSubstr("heartbeat_period = 0.005")));
}

TEST_F(CliWatchdog, AFastHeartbeatOfTheHostIsNotThatOfTheNodes) {
  std::string text = read_file(scene_with("profile = \"epos4\"\n"));
  text.insert(text.find("[[device.joint]]"), "[device.supervision]\nheartbeat_period = 0.005\n");
  const ProgramResult result = run_program("check --full " + write("scene.toml", text));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(
      result.output,
      AllOf(ContainsRegex("turret \\(can1 node 1\\) +20 ms +host's heartbeat, 1016h:01"),
            ContainsRegex("host heartbeat +0x77F +5 "), ContainsRegex("drive heartbeat +0x701 +100 ")));
}

}  // namespace
}  // namespace godobject::test::test_cli_watchdog
