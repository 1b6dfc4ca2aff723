// godobject doctor and run --require-rt as run by a user, on this machine: the shape of their answers.
#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace godobject::test::test_cli_doctor {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsSupersetOf;

const std::string rigid = "sim/scenes/rigid.toml";

using CliDoctor = ProgramTest;

/// Returns the values of a key in all checks.
std::vector<std::string> values(const nlohmann::json& checks, const std::string& key) {
  std::vector<std::string> all;
  for (const nlohmann::json& check : checks) all.push_back(check[key]);
  return all;
}

TEST_F(CliDoctor, JsonHasEveryCheckWithItsRemedy) {
  const ProgramResult result = run_program(
      "doctor " + rigid + " --json --bus can0=socketcan:none0 --bus can1=slcan:/dev/none" + " 2> /dev/null");
  EXPECT_EQ(result.exit_code, 1) << result.output;  // its buses are missing
  const nlohmann::json json = nlohmann::json::parse(result.output);
  const nlohmann::json& checks = json["checks"];
  EXPECT_THAT(values(checks, "check"),
              IsSupersetOf({"kernel", "lock memory", "processor sleep", "priority", "governor", "throttling",
                            "isolated cores", "interrupts", "can0", "can1", "disk"}));
  EXPECT_EQ(json["result"], "failed");
  for (const nlohmann::json& check : checks) {
    EXPECT_THAT((std::vector<std::string>{"ok", "degraded", "failed"}), Contains(check["result"]));
    EXPECT_FALSE(check["detail"].get<std::string>().empty()) << check;
    EXPECT_EQ(check["remedy"].is_null(), check["result"] == "ok") << check;
    if (check["group"] == "devices") {
      EXPECT_EQ(check["result"], "failed");
    }
  }
}

TEST_F(CliDoctor, TheTableHasTheSameChecks) {
  const ProgramResult table = run_program("doctor --folder " + path(""));
  const nlohmann::json json = nlohmann::json::parse(run_program("doctor --json --folder " + path("")).output);
  EXPECT_EQ(table.exit_code, json["result"] == "failed" ? 1 : 0);
  for (const nlohmann::json& check : json["checks"])
    EXPECT_THAT(table.output, HasSubstr("  " + check["check"].get<std::string>() + " "));
}

TEST_F(CliDoctor, WrongOptionsAreUsage) {
  for (const auto& [arguments, message] :
       {std::pair<std::string, const char*>{"/no/such.toml", "cannot be read"},
        {"--bus can0=socketcan:can0", "require a scene"},
        {"sim/scenes/admittance.toml --bus can0=socketcan:can0", "describes no buses"},
        {rigid + " --bus can0=socketcan:a", "'can1' of the scene has no address"},
        {rigid + " --tracker x=/dev/none", "has no trackers"}}) {
    const ProgramResult result = run_program("doctor " + arguments);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    EXPECT_THAT(result.output, HasSubstr(message));
  }
}

TEST_F(CliDoctor, AMissingFolderOfRecordsIsFailed) {
  const ProgramResult result = run_program("doctor --folder " + path("none"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("-> mkdir -p " + path("none")));
}

/// Names of the real-time checks that are not ok on this machine.
std::vector<std::string> unmet() {
  std::vector<std::string> names;
  const nlohmann::json json = nlohmann::json::parse(run_program("doctor --json").output);
  for (const nlohmann::json& check : json["checks"])
    if (check["group"] == "real time" && check["result"] != "ok") names.push_back(check["check"]);
  return names;
}

TEST_F(CliDoctor, ARunThatRequiresRealTimeStartsOnlyWithEveryRequirement) {
  const std::vector<std::string> names = unmet();
  const std::string arguments = rigid + " --require-rt --quiet --duration 0.1 --trace " + path("t.csv");
  for (const std::string verb : {"check ", "run "}) {
    const ProgramResult result = run_program(verb + arguments);
    EXPECT_EQ(result.exit_code, names.empty() ? 0 : 3) << result.output;
    for (const std::string& name : names) EXPECT_THAT(result.output, HasSubstr(name + " ("));
    if (!names.empty()) {
      EXPECT_THAT(result.output, HasSubstr("--require-rt: this machine does not meet"));
    }
  }
  EXPECT_EQ(std::filesystem::exists(path("t.csv")), names.empty());
}

// Without the right to lock memory no machine meets the requirements.
TEST_F(CliDoctor, ARunThatRequiresRealTimeIsRefusedWithoutTheRights) {
  const std::string no_rights =
      "setpriv --bounding-set=-all --inh-caps=-all prlimit --memlock=65536 --rtprio=0 ";
  if (run_program("--version", no_rights).exit_code != 0) GTEST_SKIP() << "no setpriv or prlimit here";
  const ProgramResult result = run_program("run " + rigid + " --require-rt --duration 0.1", no_rights);
  EXPECT_EQ(result.exit_code, 3) << result.output;
  for (const char* part : {"lock memory (", "priority (", "rtprio 98", "memlock unlimited"})
    EXPECT_THAT(result.output, HasSubstr(part));
}

TEST_F(CliDoctor, RequireRtExcludesTheSimulatedClock) {
  const ProgramResult result = run_program("run " + rigid + " --require-rt --fast");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("--fast excludes --require-rt"));
}

}  // namespace
}  // namespace godobject::test::test_cli_doctor
