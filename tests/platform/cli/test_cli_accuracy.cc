// godobject accuracy: errors, orders and the front of accuracy and run time, of scenes whose order is known.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "platform/session/accuracy.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_accuracy {
namespace {

using testing::HasSubstr;

class CliAccuracy : public ProgramTest {
 protected:
  nlohmann::json accuracy(const std::string& arguments) const {
    const ProgramResult result = run_program("accuracy " + arguments + " --json " + path("a.json"));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return nlohmann::json::parse(read_file(path("a.json")));
  }
  static double error_m(const nlohmann::json& json, const std::string& integrator, double step_s) {
    for (const nlohmann::json& run : json["runs"])
      if (run["integrator"] == integrator && std::abs(run["step_s"].get<double>() - step_s) < 1e-9)
        return run["error"]["position_m"];
    ADD_FAILURE() << "no run of " << integrator << " at " << step_s << " s";
    return 0;
  }
};

TEST_F(CliAccuracy, ErrorsFallWithTheOrderOfTheIntegrator) {
  const nlohmann::json json = accuracy("sim/scenes/s1.toml --duration 1");
  ASSERT_EQ(json["runs"].size(), 12u);
  EXPECT_NEAR(error_m(json, "implicit-euler", 2e-3) / error_m(json, "implicit-euler", 1e-3), 2, 0.15);
  EXPECT_NEAR(error_m(json, "tr-bdf2", 2e-3) / error_m(json, "tr-bdf2", 1e-3), 4, 0.3);
  EXPECT_NEAR(error_m(json, "implicit-euler", 1e-3), 2.8e-5, 0.3e-5);
  EXPECT_LT(error_m(json, "tr-bdf2", 1e-3), 1e-7);
  EXPECT_LT(json["reference"]["error"]["position_m"].get<double>(), 0.1 * error_m(json, "tr-bdf2", 0.125e-3));
  for (const nlohmann::json& run : json["runs"]) {
    EXPECT_FALSE(run["fault"].get<bool>());
    EXPECT_GT(run["compute_ms_per_s"].get<double>(), 0);
    EXPECT_GT(run["error"]["rotation_rad"].get<double>(), 0);
  }
}

TEST_F(CliAccuracy, DisplayedForcesAreCompared) {
  const nlohmann::json json = accuracy("sim/scenes/rigid.toml --duration 0.5 --steps 0.002,0.001");
  EXPECT_EQ(json["runs"].size(), 4u);
  for (const nlohmann::json& run : json["runs"]) EXPECT_GT(run["error"]["force_N"].get<double>(), 0);
}

TEST_F(CliAccuracy, NodesOfNetsAreComparedInAScenesOwnSteps) {
  const nlohmann::json json = accuracy("sim/scenes/net-small.toml --duration 0.1 --steps 0.002,0.001");
  EXPECT_LT(error_m(json, "tr-bdf2", 1e-3), error_m(json, "implicit-euler", 2e-3));
}

TEST_F(CliAccuracy, ARunOfTheFrontIsBeatenByNoOther) {
  const nlohmann::json runs = accuracy("sim/scenes/s1.toml --duration 0.2 --steps 0.004,0.001")["runs"];
  int on_front = 0;
  for (const nlohmann::json& a : runs) {
    bool beaten = false;
    for (const nlohmann::json& b : runs)
      beaten = beaten || (a != b && b["error"]["position_m"] <= a["error"]["position_m"] &&
                          b["compute_ms_per_s"] <= a["compute_ms_per_s"]);
    EXPECT_EQ(a["on_front"].get<bool>(), !beaten) << a;
    on_front += a["on_front"].get<bool>() ? 1 : 0;
  }
  EXPECT_GE(on_front, 1);
}

TEST_F(CliAccuracy, TheQuickestRunWithinATolerance) {
  const std::string arguments =
      "accuracy sim/scenes/s1.toml --duration 0.2 --steps 0.004,0.002 --tolerance-m ";
  const ProgramResult within = run_program(arguments + "1e-5");
  EXPECT_EQ(within.exit_code, 0) << within.output;
  EXPECT_THAT(within.output, HasSubstr("quickest within 1e-05 m: integrator = \"tr-bdf2\", step = 0.004"));
  EXPECT_THAT(run_program(arguments + "1e-15").output, HasSubstr("no run is within 1e-15 m"));
}

TEST_F(CliAccuracy, WrongArgumentsAreNamed) {
  const ProgramResult steps = run_program("accuracy sim/scenes/s1.toml --steps 0.001,0.0003");
  EXPECT_EQ(steps.exit_code, 2);
  EXPECT_THAT(steps.output, HasSubstr("--steps: 3e-04 s does not divide the longest step, 0.001 s"));
  const ProgramResult duration = run_program("accuracy sim/scenes/s1.toml --duration 0.002");
  EXPECT_EQ(duration.exit_code, 2);
  EXPECT_THAT(duration.output, HasSubstr("--duration: 0.002 s is shorter than the longest step"));
  EXPECT_EQ(run_program("accuracy no-such.toml").exit_code, 2);
  EXPECT_EQ(run_program("accuracy sim/scenes/s1.toml --steps 0").exit_code, 2);
}

TEST(Accuracy, AReferenceThatIsNoBetterIsUnresolved) {
  Accuracy accuracy{.errors = {{.position_m = 1e-6}, {.position_m = 1e-4}}};
  accuracy.of_reference.position_m = 1e-9;
  EXPECT_FALSE(accuracy.is_unresolved());
  accuracy.of_reference.position_m = 1e-6;
  EXPECT_TRUE(accuracy.is_unresolved());
}

}  // namespace
}  // namespace godobject::test::test_cli_accuracy
