// A run on real buses is repeated bit for bit, without them.
#include <gmock/gmock.h>

#include "tests/support/background_program.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_recorded_inputs {
namespace {

class RecordedInputs : public ProgramTest {};

TEST_F(RecordedInputs, OfARunOnPtysAreRepeated) {
  const std::string scene = write("scene.toml", patient_toml());
  BackgroundProgram far({"simulate", scene, "--realtime", "--bus", "can0=pty", "--bus", "can1=pty"});
  std::string arguments =
      "run " + scene + " --duration 2.5 --quiet --trace " + path("run.csv") + " --record " + path("run.godo");
  for (std::string line = far.line(); line != "ready" && !line.empty(); line = far.line())
    arguments += " --bus " + line.substr(4, 4) + "=slcan:" + line.substr(line.find(": ") + 2);
  // On a busy machine the run may miss deadlines, which are inputs, too.
  static_cast<void>(run_program(arguments));
  const ProgramResult result = run_program("replay " + path("run.godo") + " --trace " + path("again.csv"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output,
              testing::ContainsRegex("replayed [0-9]+ cycles, t = .* to 2\\.[45][0-9]* s, identical"));
  EXPECT_TRUE(read_file(path("run.csv")) == read_file(path("again.csv")));
  const ProgramResult jump = run_program("replay " + path("run.godo") + " --from 1.5");
  EXPECT_EQ(jump.exit_code, 0) << jump.output;
  EXPECT_THAT(jump.output, testing::HasSubstr("t = 1.5 to "));
}

}  // namespace
}  // namespace godobject::test::test_recorded_inputs
