// A feedback that the device cannot display in a stable way: `check` warns, and --strict refuses.
// The run has a fault within 0.6 s of the first oscillation. Also reasons for the limits of a run.
#include <gmock/gmock.h>

#include <algorithm>

#include <nlohmann/json.hpp>

#include "platform/scene/text/csv.h"
#include "tests/support/desk_scene.h"
#include "tests/support/program.h"

namespace godobject::test::test_force_oscillates {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

/// The light carriage without passivity controllers, which would keep it from chattering.
const std::string uncontrolled_plant = light_plant + "[device.limits]\npassivity_control = false\n";

class ForceOscillates : public ProgramTest {
 protected:
  nlohmann::json report() const { return nlohmann::json::parse(read_file(path("r.json"))); }
  std::string outputs() const { return " --report " + path("r.json") + " --trace " + path("t.csv"); }
};

TEST_F(ForceOscillates, ASceneOfDefaultsIsPassiveAndMeetsNoLimit) {
  const std::string scene = write("mine.toml", desk_scene("scale = 0.25\n"));
  const ProgramResult check = run_program("check --strict " + scene);
  EXPECT_EQ(check.exit_code, 0) << check.output;
  EXPECT_THAT(check.output, AllOf(HasSubstr("# passivity of the driven axes"), HasSubstr("passive\n"),
                                  Not(HasSubstr("not passive"))));
  const ProgramResult run = run_program("run --strict " + scene + outputs());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_FALSE(report()["limits"].contains("force_rate")) << run.output;
  EXPECT_THAT(report()["warnings"], IsEmpty());
}

TEST_F(ForceOscillates, CheckWarnsAndStrictRefuses) {
  const std::string scene = write("light.toml", desk_scene(heavy_feedback, light_plant));
  const ProgramResult check = run_program("check " + scene);
  EXPECT_EQ(check.exit_code, 0);
  EXPECT_THAT(check.output,
              AllOf(HasSubstr("warning: " + scene + ": axis x is not passive"), HasSubstr("margin")));
  for (const char* verb : {"check", "run"}) {
    const ProgramResult strict = run_program(std::string(verb) + " --strict " + scene);
    EXPECT_EQ(strict.exit_code, 2) << verb;
    EXPECT_THAT(strict.output, HasSubstr("--strict: axis x is not passive")) << verb;
  }
}

TEST_F(ForceOscillates, ChatterAtTheRateLimitIsAFaultWithin600Ms) {
  const std::string scene = write("light.toml", desk_scene(heavy_feedback, uncontrolled_plant));
  const ProgramResult run = run_program("run " + scene + outputs());
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_THAT(run.output, HasSubstr("FAULT                      force_oscillates"));
  EXPECT_EQ(report()["faults"][0]["name"], "force_oscillates");

  const CsvResult trace = read_csv(path("t.csv"));
  const auto column = [&](const std::string& name) {
    const auto& columns = trace.table->columns();
    return static_cast<std::size_t>(std::ranges::find(columns, name) - columns.begin());
  };
  const std::size_t limited = column("limited"), fault = column("rig_fault");
  constexpr int force_rate = 4;  // docs/faults.md
  std::size_t first_limited = 0, first_fault = 0;
  for (std::size_t row = 0; row < trace.table->num_rows(); ++row) {
    if (first_limited == 0 && (static_cast<int>(trace.table->at(row, limited)) & force_rate))
      first_limited = row;
    if (first_fault == 0 && trace.table->at(row, fault) != 0) first_fault = row;
  }
  ASSERT_GT(first_limited, 0u);
  ASSERT_GT(first_fault, first_limited);
  EXPECT_LE(first_fault - first_limited, 600u);  // ms
  EXPECT_GT(report()["limits_percent"]["force_rate"], 5);
  EXPECT_THAT(run.output, AllOf(HasSubstr("WARNING"), HasSubstr("limit force_rate in ")));
}

TEST_F(ForceOscillates, PassivityControllersKeepItFromChattering) {
  const ProgramResult run =
      run_program("run " + write("light.toml", desk_scene(heavy_feedback, light_plant)) + outputs());
  EXPECT_EQ(run.exit_code, 0) << run.output;
  EXPECT_THAT(report()["faults"], IsEmpty());
  EXPECT_GT(report()["drives"][0]["most_generated_energy_J"], 0);
}

TEST_F(ForceOscillates, WithoutARigItIsAFaultOfTheRun) {
  // the hand, measured exactly, shakes at 60 Hz: the force follows at its rate limit
  std::string scene = desk_scene("stiffness = 5000\n");
  scene.replace(scene.find("[motion]"), std::string::npos,
                "[motion]\namplitude = [0.01, 0, 0]\nfrequency_hz = [60, 0, 0]\n");
  const ProgramResult run =
      run_program("run --bus direct --duration 2 " + write("direct.toml", scene) + outputs());
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_EQ(report()["faults"][0]["name"], "force_oscillates");
}

TEST_F(ForceOscillates, AutomaticRearmingDoesNotRestartIt) {
  const std::string scene = write("light.toml", desk_scene(heavy_feedback, uncontrolled_plant));
  const ProgramResult run = run_program("run --rearm auto " + scene + outputs());
  EXPECT_EQ(run.exit_code, 1) << run.output;
  EXPECT_THAT(run.output, Not(HasSubstr("recovered")));
  EXPECT_LT(report()["cycles"], 3000);
}

TEST_F(ForceOscillates, ShippedScenesMeetNoLimitOften) {
  for (const char* name :
       {"rigid", "grasper", "organ", "scissors-imposed", "relative", "tracked", "non-haptic"}) {
    const ProgramResult run =
        run_program("run --duration 4 sim/scenes/" + std::string(name) + ".toml" + outputs());
    EXPECT_EQ(run.exit_code, 0) << name << run.output;
    EXPECT_THAT(report()["warnings"], IsEmpty()) << name;
  }
}

}  // namespace
}  // namespace godobject::test::test_force_oscillates
