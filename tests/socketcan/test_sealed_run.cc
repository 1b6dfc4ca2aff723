// A sealed run of the program on interfaces of the kernel, with its files, on a rig that another program
// simulates.
#include <gmock/gmock.h>

#include "tests/socketcan/can_test.h"
#include "tests/support/background_program.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/sealed_run.h"

namespace godobject::test::test_sealed_run {
namespace {

class SealedOnSocketCan : public ProgramTest {
 protected:
  void SetUp() override {
    if (const std::string reason = why_no_interfaces(); !reason.empty()) GTEST_SKIP() << reason;
    if (const std::string reason = why_not_sealed(); !reason.empty()) GTEST_SKIP() << reason;
  }
};

TEST_F(SealedOnSocketCan, WithTraceAndRecord) {
  // user-mode-linux takes up to 5 ms for the calls of a cycle, beside the simulated rig
  constexpr double step = 1e-2;
  std::string text = patient_toml();
  text.replace(text.find("5e-3"), 4, "1e-2");
  const std::string scene = write("scene.toml", text);
  const int seconds = sealed_seconds(6, step);
  BackgroundProgram far({"simulate", scene, "--control", "-", "--bus", "can0=socketcan:vcan0", "--bus",
                         "can1=socketcan:vcan1"});
  for (std::string line = far.line(); line != "ready"; line = far.line()) ASSERT_NE(line, "");
  const LoopGuard guard(path("calls.txt"));
  const ProgramResult result = run_program(
      "run " + scene + " --bus can0=socketcan:vcan0 --bus can1=socketcan:vcan1 --seal --duration " +
      std::to_string(seconds) + " --trace " + path("trace.csv") + " --record " + path("bus.log") +
      " --record " + path("run.godo") + " --report " + path("report.json"));
  expect_sealed(path("report.json"), seconds, step, guard, result.output);
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
  EXPECT_GT(report["answers"]["frames"], report["cycles"]);
  const ProgramResult again = run_program("replay " + path("run.godo"));
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, testing::HasSubstr("replayed " + report["cycles"].dump() + " cycles"));
  EXPECT_THAT(again.output, testing::HasSubstr("identical, also the rig"));
}

}  // namespace
}  // namespace godobject::test::test_sealed_run
