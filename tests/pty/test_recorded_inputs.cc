// A run on real buses is repeated bit for bit, without them.
#include <gmock/gmock.h>

#include <chrono>
#include <thread>
#include <vector>

#include "tests/support/background_program.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_recorded_inputs {
namespace {

class RecordedInputs : public ProgramTest {};

TEST_F(RecordedInputs, OfARunOnPtysAreRepeatedWithItsFrames) {
  const std::string scene = write("scene.toml", patient_toml());
  BackgroundProgram far({"simulate", scene, "--realtime", "--bus", "can0=pty", "--bus", "can1=pty"});
  std::string arguments = "run " + scene + " --duration 2.5 --quiet --trace " + path("run.csv") +
                          " --record " + path("run.godo") + " --record " + path("bus.log");
  for (std::string line = far.line(); line != "ready" && !line.empty(); line = far.line())
    arguments += " --bus " + line.substr(4, 4) + "=slcan:" + line.substr(line.find(": ") + 2);
  // On a busy machine the run may miss deadlines, which are inputs, too.
  static_cast<void>(run_program(arguments));
  const ProgramResult result = run_program("replay " + path("run.godo") + " --trace " + path("again.csv"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output,
              testing::ContainsRegex(
                  "replayed [0-9]+ cycles, t = .* to 2\\.[45][0-9]* s, identical, also the rig\n$"));
  EXPECT_TRUE(read_file(path("run.csv")) == read_file(path("again.csv")));
  EXPECT_THAT(read_file(path("bus.log")), testing::ContainsRegex("\\) can0 080#[^\n]*\n\\([0-9.]+\\) can"));
  const ProgramResult jump = run_program("replay " + path("run.godo") + " --from 1.5");
  EXPECT_EQ(jump.exit_code, 0) << jump.output;
  EXPECT_THAT(jump.output, testing::HasSubstr("t = 1.5 to "));
}

/// On real buses this needs no option; "none" switches it off.
TEST_F(RecordedInputs, OfTheSecondsBeforeAFaultAreKept) {
  const std::string scene = write("scene.toml", patient_toml());
  const auto fault_files = [this] {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(path("")))
      if (entry.path().extension() == ".godo") found.push_back(entry.path().string());
    return found;
  };
  for (const std::string option : {" --on-fault none", ""}) {
    BackgroundProgram far(
        {"simulate", scene, "--realtime", "--control", "-", "--bus", "can0=pty", "--bus", "can1=pty"});
    std::vector<std::string> arguments{"run",     scene,      "--duration",  "2",
                                       "--quiet", "--report", path("r.json")};
    if (!option.empty()) arguments.insert(arguments.end(), {"--on-fault", "none"});
    for (std::string line = far.line(); line != "ready" && !line.empty(); line = far.line())
      arguments.insert(arguments.end(),
                       {"--bus", line.substr(4, 4) + "=slcan:" + line.substr(line.find(": ") + 2)});
    BackgroundProgram host(arguments);
    std::this_thread::sleep_for(std::chrono::seconds(1));
    EXPECT_THAT(far.say("fault drop bus=can0 node=1"), testing::HasSubstr("\"ok\":true"));
    static_cast<void>(host.wait_status());
    ASSERT_EQ(fault_files().size(), option.empty() ? 1u : 0u);
  }
  const std::string file = fault_files().front();
  EXPECT_THAT(file, testing::ContainsRegex("/scene-fault-[0-9]{8}T[0-9]{6}\\.godo$"));
  const ProgramResult again = run_program("replay " + file);
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, testing::HasSubstr("identical, also the rig"));
}

}  // namespace
}  // namespace godobject::test::test_recorded_inputs
