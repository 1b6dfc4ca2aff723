// The bus tools of the command line, run as by a user: bus-load, monitor, faults.
#include <gmock/gmock.h>

#include <regex>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include <nlohmann/json.hpp>

#include "platform/cli/fault_texts.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_bus_tools {
namespace {

using testing::ContainsRegex;
using testing::ElementsAreArray;
using testing::HasSubstr;
using testing::Not;

const std::string rigid = "sim/scenes/rigid.toml";

class CliBusLoad : public ProgramTest {
 protected:
  /// Returns rigid.toml with another bit rate of its first bus.
  std::string with_bit_rate(const std::string& bit_rate) const {
    std::string scene = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
    const std::string rate = "bit_rate = 1e6";
    scene.replace(scene.find(rate), rate.size(), "bit_rate = " + bit_rate);
    return write("scene.toml", scene);
  }
};

TEST_F(CliBusLoad, ListsEveryMessageAndRefusesNothingBelowThePlannedLoad) {
  const ProgramResult result = run_program("bus-load " + rigid);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, ContainsRegex("# bus can0: [0-9.]+ % nominal, [0-9.]+ % worst case"));
  EXPECT_THAT(result.output, ContainsRegex("SYNC +0x080 +1 +47 +55"));
  EXPECT_THAT(result.output, HasSubstr("# bus can1"));
}

TEST_F(CliBusLoad, JsonHasTheSameNumbers) {
  const ProgramResult result = run_program("bus-load " + rigid + " --json 2> /dev/null | cat");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const nlohmann::json json = nlohmann::json::parse(result.output);
  ASSERT_EQ(json.size(), 2u);
  EXPECT_EQ(json[0]["bus"], "can0");
  EXPECT_GT(json[0]["worst_percent"], json[0]["nominal_percent"]);
  EXPECT_EQ(json[0]["messages"][0]["name"], "SYNC");
  EXPECT_EQ(json[0]["messages"][0]["worst_bits"], 55);
}

TEST_F(CliBusLoad, RefusesABusAboveThePlannedLoadUnlessForced) {
  const std::string scene = with_bit_rate("7e5");
  const ProgramResult refused = run_program("bus-load " + scene);
  EXPECT_EQ(refused.exit_code, 1) << refused.output;
  EXPECT_THAT(refused.output, HasSubstr("warning: above 70 %"));
  EXPECT_THAT(refused.output, HasSubstr("--allow-overload accepts it"));
  const ProgramResult allowed = run_program("bus-load " + scene + " --allow-overload");
  EXPECT_EQ(allowed.exit_code, 0);
  EXPECT_THAT(allowed.output, HasSubstr("warning: above 70 %"));
  EXPECT_THAT(allowed.output, Not(HasSubstr("accepts it")));
}

TEST_F(CliBusLoad, AScenesMistakesAndASceneWithoutBusesAreUsage) {
  EXPECT_EQ(run_program("bus-load missing.toml").exit_code, 2);
  const ProgramResult none = run_program("bus-load sim/scenes/s1.toml");
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.output, HasSubstr("describes no buses"));
}

class CliFaults : public ProgramTest {};

TEST_F(CliFaults, EveryFaultIsListedWithMeaningAndRemedy) {
  const ProgramResult result = run_program("faults");
  EXPECT_EQ(result.exit_code, 0);
  const auto expect_shown = [&](std::string_view name, std::string_view meaning, std::string_view remedy) {
    for (const std::string_view text : {name, meaning, remedy}) {
      EXPECT_FALSE(text.empty()) << name;
      EXPECT_THAT(result.output, HasSubstr(std::string(text)));
    }
  };
  for (const CoreFaultText& f : core_fault_texts) expect_shown(f.text.name, f.text.meaning, f.text.remedy);
  for (const RigFaultText& f : rig_fault_texts()) expect_shown(f.name, f.meaning, f.remedy);
  for (const FaultText& f : run_fault_texts) expect_shown(f.name, f.meaning, f.remedy);
}

TEST_F(CliFaults, OneFaultAloneAndAMistypedOne) {
  const ProgramResult one = run_program("faults sample_stale");
  EXPECT_EQ(one.exit_code, 0);
  EXPECT_THAT(one.output, HasSubstr("sample_stale"));
  EXPECT_THAT(one.output, Not(HasSubstr("boot_timeout")));
  const ProgramResult mistyped = run_program("faults sample_stall");
  EXPECT_EQ(mistyped.exit_code, 2);
  EXPECT_THAT(mistyped.output, HasSubstr("did you mean 'sample_stale'?"));
}

/// Returns the first column of the table below the heading that begins with `title`.
std::vector<std::string> documented_names(const std::string& title) {
  std::istringstream page(read_file(GODOBJECT_SOURCE_DIR "/docs/faults.md"));
  std::vector<std::string> names;
  bool in_section = false;
  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("## ")) in_section = line.starts_with("## " + title);
    std::smatch match;
    if (in_section && std::regex_search(line, match, std::regex("^\\| `([a-z_]+)` \\|")))
      names.push_back(match[1]);
  }
  return names;
}

TEST(FaultDocumentation, HasTheFaultsOfTheTablesInTheirOrder) {
  std::vector<std::string> core, rig, run;
  for (const CoreFaultText& f : core_fault_texts) core.emplace_back(f.text.name);
  for (const RigFaultText& f : rig_fault_texts()) rig.emplace_back(f.name);
  for (const FaultText& f : run_fault_texts) run.emplace_back(f.name);
  EXPECT_THAT(documented_names("Core faults"), ElementsAreArray(core));
  EXPECT_THAT(documented_names("Rig faults"), ElementsAreArray(rig));
  EXPECT_THAT(documented_names("Faults of a run"), ElementsAreArray(run));
}

class CliMonitor : public ProgramTest {
 protected:
  /// Records a run of rigid.toml on its two simulated buses.
  std::string recorded_run() const {
    EXPECT_EQ(run_program("run " + rigid + " --duration 0.3 --record " + path("run.log")).exit_code, 0);
    return path("run.log");
  }
};

TEST_F(CliMonitor, NamesAndDecodesTheMessagesOfARecordedRun) {
  const std::string log = recorded_run();
  const ProgramResult result = run_program("monitor --plain --scene " + rigid + " --bus replay:" + log +
                                           ",can0 --bus replay:" + log + ",can1");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("end of the log"));
  EXPECT_THAT(result.output, ContainsRegex("can0 +000 +NMT .* enter pre-operational: "));
  EXPECT_THAT(result.output, ContainsRegex("can0 +080 +SYNC +[0-9]+ +[0-9.]+ +[0-9]\\.[0-9]+ 1\\.0[0-9]+ "));
  EXPECT_THAT(result.output, ContainsRegex("can1 +080 +SYNC "));
  EXPECT_THAT(result.output, ContainsRegex("TPDO1 of [a-z_0-9]+ encoder .* counts, [+-][0-9.]+ rad"));
  EXPECT_THAT(result.output,
              ContainsRegex("RPDO1 of [a-z_0-9]+ drive .*controlword 0000h, torque [+]0.0000 Nm"));
  EXPECT_THAT(result.output,
              ContainsRegex("TPDO1 of [a-z_0-9]+ drive .* operation enabled, .* rad, torque "));
  EXPECT_THAT(result.output, ContainsRegex("77F +heartbeat of host "));
  EXPECT_THAT(result.output, ContainsRegex("heartbeat of [a-z_0-9]+ encoder .*operational"));
  EXPECT_THAT(result.output, ContainsRegex("load [1-9][0-9]\\.[0-9] % of 1000 kbit/s"));
}

TEST_F(CliMonitor, DecodesCanopenWithoutAScene) {
  const std::string log = write("a.log",
                                "(1.000000) can0 085#2082010000000000\n"
                                "(1.000000) can0 604#40 \n"
                                "(1.000100) can0 605#4041600000000000\n"
                                "(1.000200) can0 585#8041600000000206\n"
                                "(1.000300) can0 605#2B17100064000000\n"
                                "(1.000400) can0 705#00\n"
                                "(1.000500) can0 00012345#0102\n");
  const ProgramResult result = run_program("monitor --plain --bit-rate 500000 --bus replay:" + log);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, ContainsRegex("085 +EMCY of node 5 .*8220h PDO too long, register 01h"));
  EXPECT_THAT(result.output, ContainsRegex("605 +SDO request of node 5 +2 .*write 1017h:00 = 0x0064"));
  EXPECT_THAT(result.output, ContainsRegex("585 +SDO answer of node 5 .*6041h:00 abort 06020000: "));
  EXPECT_THAT(result.output, ContainsRegex("604 +SDO request of node 4 .*not 8 bytes"));
  EXPECT_THAT(result.output, ContainsRegex("705 +heartbeat of node 5 .*boot-up"));
  EXPECT_THAT(result.output, ContainsRegex("00012345 .*01 02"));
  EXPECT_THAT(result.output, HasSubstr("of 500 kbit/s"));
}

/// A multi-turn encoder without a modulus counts below zero in two's complement, as in the rig.
TEST_F(CliMonitor, CountsBelowZeroAreNegative) {
  std::string scene = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
  for (const std::string& line :
       {std::string("offset_counts = 131072\n"), std::string("modulus_counts = 262144\n")}) {
    const std::size_t first = scene.find("[[device.encoder]]");
    scene.erase(scene.find(line, first), line.size());
  }
  const std::string log = write("a.log", "(1.000000) can0 181#FEFFFFFF\n(1.001000) can0 182#FEFFFFFF\n");
  const ProgramResult result =
      run_program("monitor --plain --scene " + write("s.toml", scene) + " --bus can0=replay:" + log);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, ContainsRegex("TPDO1 of turret encoder .* -2 counts, -0.00005 rad"));
  EXPECT_THAT(result.output, ContainsRegex("TPDO1 of shoulder encoder .* 4294967294 counts, "));
}

TEST_F(CliMonitor, DecodesTheBusesOfOtherDrives) {
  const auto scene_with = [&](const std::string& drive, const std::string& bus) {
    std::string scene = two_joints_toml;
    const std::string profile = "profile = \"generic-402\"\n";
    for (std::size_t at = 0; (at = scene.find(profile, at)) != std::string::npos; at += drive.size())
      scene.replace(at, profile.size(), drive);
    const std::string second_bus = "name = \"can1\"\n";
    return write("scene.toml", scene.insert(scene.find(second_bus) + second_bus.size(), bus));
  };
  const auto table_of = [&](const std::string& scene) {
    const std::string log = path("drives.log");
    EXPECT_EQ(run_program("run " + scene + " --duration 0.3 --record " + log).exit_code, 0);
    return run_program("monitor --plain --scene " + scene + " --bus can1=replay:" + log + ",can1").output;
  };
  const std::string odrive = table_of(scene_with("protocol = \"odrive\"\nwatchdog = \"drive\"\n", ""));
  EXPECT_THAT(odrive, ContainsRegex("029 +estimates of turret drive .* [+-][0-9.]+ rad, velocity "));
  EXPECT_THAT(odrive, ContainsRegex("029 +estimates request of turret drive .* remote "));
  EXPECT_THAT(odrive, ContainsRegex("04E +torque command of elbow drive .* torque [+-][0-9.]+ Nm"));
  EXPECT_THAT(odrive, ContainsRegex("041 +heartbeat of elbow drive .* closed loop"));
  const std::string moteus = table_of(scene_with("protocol = \"moteus\"\n", "data_bit_rate = 5e6\n"));
  EXPECT_THAT(moteus, ContainsRegex(" 100 +reply of turret drive .* rad, position mode, torque [+-]"));
  EXPECT_THAT(moteus,
              ContainsRegex("00008002 +command and query of elbow drive .* position mode, torque [+-]"));
}

TEST_F(CliMonitor, StopsAfterItsDuration) {
  const std::string log = write("a.log", "(0.000000) can0 080#\n(1000.000000) can0 081#\n");
  const ProgramResult result = run_program("monitor --plain --duration 0.05 --bus replay:" + log);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, ContainsRegex("080 +SYNC +1 "));
  EXPECT_THAT(result.output, Not(HasSubstr("end of the log")));
}

TEST_F(CliMonitor, OffersAPseudoTerminal) {
  const ProgramResult result = run_program("monitor --plain --duration 0.05 --bus pty:");
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, HasSubstr("slcan:/dev/pts/"));
}

TEST_F(CliMonitor, SaysWhatIsWrongWithABus) {
  for (const auto& [arguments, exit_code, expected] :
       {std::tuple{std::string("--bus socketcam:can0"), 2, "did you mean 'socketcan'?"},
        {"--bus replay:" + path("missing.log"), 2, "No such file"},
        {"--bus slcan:/dev/ttyNone", 3, "plugged in"},
        {"--bus can7=replay:a.log", 2, "give --scene"},
        {"--scene " + rigid + " --bus can7=replay:a.log", 2, "no bus of that name"},
        {"--scene sim/scenes/s1.toml --bus pty:", 2, "describes no buses"},
        {"", 2, "--bus is required"}}) {
    const ProgramResult result = run_program("monitor " + arguments);
    EXPECT_EQ(result.exit_code, exit_code) << arguments << '\n' << result.output;
    EXPECT_THAT(result.output, HasSubstr(expected)) << arguments;
  }
}

}  // namespace
}  // namespace godobject::test::test_cli_bus_tools
