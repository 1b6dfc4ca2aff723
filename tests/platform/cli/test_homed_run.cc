// Runs of a device with incremental encoders: their events, and that they are repeated.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/program.h"

namespace godobject::test::test_homed_run {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* home_button = R"(
[[device.button]]
use = "home"
bus = "can0"
node_id = 21
bit = 1
)";

class HomedRun : public ProgramTest {
 protected:
  /// Writes the rig of the hardware tests with incremental encoders. Returns its file in quotes.
  std::string scene(const std::string& more) {
    const std::string hil = GODOBJECT_SOURCE_DIR "/tests/hil/";
    write("patient-402.toml", read_file(hil + "patient-402.toml"));
    const std::regex absolute("offset_counts = 8192\nmodulus_counts = 16384");
    return "'" +
           write("rig.toml",
                 std::regex_replace(read_file(hil + "rig.toml"), absolute, "incremental = true") + more) +
           "'";
  }
  /// Returns the kinds of a run's events.
  std::vector<std::string> events() {
    std::vector<std::string> kinds;
    const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")));
    for (const auto& event : report["events"]) kinds.push_back(event["event"]);
    return kinds;
  }
  std::string files() { return " --record " + path("run.godo") + " --report " + path("report.json"); }
  void expect_replay() {
    const ProgramResult replayed = run_program("replay " + path("run.godo"));
    EXPECT_EQ(replayed.exit_code, 0) << replayed.output;
    EXPECT_THAT(replayed.output, HasSubstr("identical, also the rig"));
  }
};

TEST_F(HomedRun, TellsWhatItWaitsForAndIsRepeated) {
  const ProgramResult run = run_program("run " + scene(home_button) + " --duration 1" + files());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(
      run.output,
      HasSubstr("at 0.000 s: HOMING: the motors have no torque; put the device into its home pose (turret "
                "0 rad, elbow 0 rad), keep it at rest, then press the button of can0 node 21, input 2\n"));
  EXPECT_THAT(run.output, HasSubstr("at 0.000 s: homed: the zeros of the incremental sensors are set\n"));
  EXPECT_THAT(events(), ElementsAre("homing", "homed"));
  expect_replay();
}

TEST_F(HomedRun, IsHomedAgainAfterAPowerCycle) {
  const std::string fault =
      "\n[[fault]]\nverb = \"reboot-node\"\nbus = \"can0\"\nnode_id = 1\nat = 0.3\nduration = 0.05\n";
  const ProgramResult run =
      run_program("run " + scene(home_button + fault) + " --duration 1 --rearm auto" + files());
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_THAT(events(),
              ElementsAre("homing", "homed", "fault", "lost", "trying", "homing", "homed", "armed"));
  expect_replay();
}

TEST_F(HomedRun, CheckRefusesASceneWithoutTheButton) {
  const ProgramResult result = run_program("check " + scene(""));
  EXPECT_EQ(result.exit_code, 2) << result.output;
  for (const std::string joint : {"turret", "elbow"})
    EXPECT_THAT(result.output,
                HasSubstr("joint '" + joint +
                          "': its sensor is incremental, so the user must confirm the home pose: add "
                          "a [[device.button]] with use = \"home\""));
}

}  // namespace
}  // namespace godobject::test::test_homed_run
