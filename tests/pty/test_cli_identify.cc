// `godobject identify` against `godobject simulate` over pseudo-terminals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/background_program.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_identify {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string plant =
    "\n[device.plant]\ninertia = 5e-3\ndamping = 0.02\nfriction = 0.05\nhand_stiffness = 0\nhand_damping = "
    "0\n";

class CliIdentify : public ProgramTest {
 protected:
  /// Starts the simulated rig. Returns the arguments of `identify` on it, with its consent.
  std::string rig() {
    const std::string scene = write("scene.toml", patient_toml() + plant);
    far_.reset();
    far_.emplace(std::vector<std::string>{"simulate", scene, "--realtime", "--control", "-", "--bus",
                                          "can0=pty", "--bus", "can1=pty"});
    std::string arguments = "identify " + scene + " --period 1 --cycles 2 --torque 0.9";
    for (std::string line = far_->line(); line != "ready" && !line.empty(); line = far_->line())
      arguments += " --bus " + line.substr(4, 4) + "=slcan:" + line.substr(line.find(": ") + 2);
    return arguments + " --hand-on-the-stop";
  }
  /// Expects no torque, and that the drives of these joints had some.
  void expect_no_torque_after(const std::vector<std::string>& excited) {
    const nlohmann::json status = nlohmann::json::parse(far_->say("status"));
    std::vector<std::string> moved;
    for (const nlohmann::json& drive : status.at("drives")) {
      EXPECT_EQ(drive["torque_Nm"], 0) << drive;
      if (drive["max_torque_Nm"] > 0) moved.push_back(drive["joint"]);
    }
    EXPECT_THAT(moved, testing::UnorderedElementsAreArray(excited));
  }
  static double value(const std::string& output, const std::string& key) {
    return std::stod(output.substr(output.find(key + " = ") + key.size() + 3));
  }

  std::optional<BackgroundProgram> far_;
};

TEST_F(CliIdentify, PrintsThePlantAsKeys) {
  ProgramResult result;
  for (int i = 0; i < 4 && result.exit_code != 0; ++i)  // drives of a late host switch off
    result = run_program(rig() + " --joint turret=0.3 --joint elbow=0.2");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("[[device.plant.joint]]\njoint = \"turret\"\n"));
  EXPECT_THAT(result.output, HasSubstr("joint = \"elbow\"\n"));
  EXPECT_NEAR(value(result.output, "inertia"), 5e-3, 5e-4);
  EXPECT_NEAR(value(result.output, "damping"), 0.02, 5e-3);
  EXPECT_NEAR(value(result.output, "friction"), 0.05, 5e-3);
  expect_no_torque_after({"turret", "elbow"});

  const std::size_t keys = result.output.find("[[device.plant.joint]]");
  const std::string scene = write("pasted.toml", patient_toml() + plant + result.output.substr(keys));
  const LoadResult loaded = load_scene(scene);
  EXPECT_THAT(loaded.errors, testing::IsEmpty());
}

TEST_F(CliIdentify, ASignalEndsItWithoutTorque) {
  ProgramResult result;
  for (int i = 0; i < 4 && result.output.find("interrupted by SIGTERM") == std::string::npos; ++i)
    result = run_program(rig() + " --joint turret=0.3", "timeout -s TERM 4 ");
  EXPECT_THAT(result.output, HasSubstr("interrupted by SIGTERM"));
  EXPECT_THAT(result.output, Not(HasSubstr("inertia =")));
  expect_no_torque_after({"turret"});
}

TEST_F(CliIdentify, RefusesWithoutConsentAndUnknownJoints) {
  const std::string scene = write("scene.toml", patient_toml());
  const std::string start =
      "identify " + scene + " --bus can0=slcan:/dev/null --bus can1=slcan:/dev/null --joint ";
  ProgramResult result = run_program(start + "turret=0.3");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("give --hand-on-the-stop"));

  const std::string arguments = rig();
  result = run_program(arguments + " --joint wrist=0.3");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("--joint wrist=0.3: the device's joints are 'turret'"));
  result = run_program(arguments + " --joint turret=1e-5");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("counts of its sensor"));
}

}  // namespace
}  // namespace godobject::test::test_cli_identify
