// `godobject simulate` simulates a tracker on a pseudo-terminal, `godobject run` follows it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/support/background_program.h"
#include "tests/support/held_run.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_trackers {
namespace {

using testing::HasSubstr;

class CliTrackers : public ProgramTest {
 protected:
  /// Starts the simulation; returns the path of its tracker.
  std::string start() {
    far_.emplace(std::vector<std::string>{"simulate", "sim/scenes/tracked.toml", "--control", "-"});
    const std::string first = far_->line();
    EXPECT_THAT(first, testing::StartsWith("tracker polaris: /dev/"));
    EXPECT_EQ(far_->line(), "ready");
    return first.substr(first.find('/'));
  }
  /// Runs the scene. Returns the report.
  nlohmann::json run(const std::string& arguments) {
    return run_unless_held("sim/scenes/tracked.toml " + arguments, path("report.json"), result_);
  }

  std::optional<BackgroundProgram> far_;
  ProgramResult result_;
};

TEST_F(CliTrackers, RunFollowsTheTrackerThatSimulatePlays) {
  const std::string port = start();
  const nlohmann::json report = run("--tracker polaris=" + port + " --duration 2");
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_EQ(report["bus_mode"], "real");
  EXPECT_EQ(report["mode"], "realtime");
  EXPECT_EQ(report["cycles"], 2000);
  ASSERT_EQ(report["trackers"].size(), 1u);
  const nlohmann::json& tracker = report["trackers"][0];
  EXPECT_EQ(tracker["port"], port);
  EXPECT_EQ(tracker["state"], "tracking");
  EXPECT_EQ(tracker["bad_crc"], 0);
  EXPECT_GT(tracker["samples"], 50);
  EXPECT_EQ(tracker["tools"][0]["state"], "valid");
  EXPECT_LT(tracker["tools"][0]["age_s"], 0.1);
  EXPECT_FALSE(report.contains("sensing")) << "nobody knows where the tool is";
  EXPECT_THAT(result_.output, HasSubstr("tracking"));
}

TEST_F(CliTrackers, TheirRunIsRepeatedBitForBitWithoutThem) {
  const std::string port = start();
  EXPECT_THAT(far_->say("fault corrupt tracker=polaris value=0.1"), HasSubstr(R"("ok":true)"));
  const nlohmann::json report = run("--tracker polaris=" + port + " --duration 2 --record " +
                                    path("run.godo") + " --trace " + path("run.csv"));
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_EQ(report["bus_mode"], "real");
  EXPECT_GT(report["trackers"][0]["samples"], 50);
  far_.reset();
  ProgramResult replayed = run_program("replay " + path("run.godo") + " --trace " + path("again.csv"));
  EXPECT_EQ(replayed.exit_code, 0) << replayed.output;
  EXPECT_THAT(replayed.output, HasSubstr("replayed 2000 cycles, t = 0.001 to 2 s, identical"));
  EXPECT_TRUE(read_file(path("run.csv")) == read_file(path("again.csv")));
  replayed = run_program("replay " + path("run.godo") + " --from 1.5");
  EXPECT_EQ(replayed.exit_code, 0) << replayed.output;
  EXPECT_THAT(replayed.output, HasSubstr("replayed 501 cycles, t = 1.5 to 2 s, identical"));
}

TEST_F(CliTrackers, FaultsComeFromTheSimulationAndAreNoFaultsOfTheRun) {
  const std::string port = start();
  EXPECT_THAT(far_->say("fault corrupt tracker=polaris value=0.1"), HasSubstr(R"("ok":true)"));
  EXPECT_THAT(far_->say("fault missing tracker=vega"), HasSubstr("unknown tracker 'vega'"));
  EXPECT_THAT(far_->say("fault emcy tracker=polaris"), HasSubstr("no fault of a tracker"));
  EXPECT_THAT(far_->say("fault drop bus=can0"), HasSubstr(R"("ok":false)"));
  nlohmann::json report = run("--tracker " + port + " --duration 2");
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_GT(report["trackers"][0]["bad_crc"], 0);
  EXPECT_THAT(far_->say("status"), HasSubstr(R"("verb":"corrupt","tracker":"polaris")"));
  EXPECT_THAT(far_->say("clear"), HasSubstr(R"("ok":true)"));
  EXPECT_THAT(far_->say("fault missing tracker=polaris"), HasSubstr(R"("ok":true)"));
  report = run("--tracker polaris=" + port + " --duration 0.5");
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_EQ(report["trackers"][0]["tools"][0]["state"], "missing");
  EXPECT_EQ(report["limits"]["held"], 500);
}

TEST_F(CliTrackers, OneThatIsNotThereIsAFaultOfTheRunThatSaysWhy) {
  std::string scene = read_file(GODOBJECT_SOURCE_DIR "/sim/scenes/tracked.toml");
  scene.replace(scene.find("stale_after = 0.1"), 17, "boot_timeout = 0.5");
  const ProgramResult result =
      run_program("run " + write("scene.toml", scene) + " --tracker polaris=/dev/no-such-port --duration 1");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("tracker_not_ready"));
  EXPECT_THAT(result.output, HasSubstr("/dev/no-such-port"));
  EXPECT_THAT(result.output, HasSubstr(": 0 cycles"));
}

TEST_F(CliTrackers, InProcessTheRunIsTheSameEachTime) {
  const nlohmann::json first = run("--duration 3"), second = run("--duration 3");
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_EQ(first["state_hash"], second["state_hash"]);
  EXPECT_EQ(first["bus_mode"], "sim");
  EXPECT_TRUE(first["trackers"][0]["port"].is_null());
  EXPECT_GT(first["sensing"]["rms_m"], 1e-4);
}

TEST_F(CliTrackers, ErrorsOfTheOptionAreReported) {
  for (const auto& [arguments, expected] :
       {std::pair{"run sim/scenes/tracked.toml --tracker vega=/dev/x", "the scene's trackers are 'polaris'"},
        {"run sim/scenes/tracked.toml --tracker polaris=/dev/x --tracker polaris=/dev/y", "given twice"},
        {"run sim/scenes/tracked.toml --tracker scene --bus direct", "or remove --tracker"},
        {"run sim/scenes/tracked.toml --tracker scene --fast", "real buses and trackers run in wall time"},
        {"run sim/scenes/rigid.toml --tracker scene", "has no trackers"},
        {"simulate sim/scenes/pendulum.toml", "no trackers to simulate"}}) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 2) << arguments << "\n" << result.output;
    EXPECT_THAT(result.output, HasSubstr(expected)) << arguments;
  }
}

}  // namespace
}  // namespace godobject::test::test_cli_trackers
