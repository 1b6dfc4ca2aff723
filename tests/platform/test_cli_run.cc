// Runs that go well: what they print, what they write, and that they repeat bit for bit.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "hal/candump.h"
#include "sim/csv.h"
#include "sim/scene_toml.h"
#include "sim/trace.h"
#include "tests/support/program.h"

namespace godobject::test::test_cli_run {
namespace {

using testing::HasSubstr;

const std::string rigid = "sim/scenes/rigid.toml";

class CliRun : public ProgramTest {
 protected:
  /// Runs the scene with every output, named `name`.*.
  ProgramResult run(const std::string& name, const std::string& options) const {
    return run_program("run " + options + " --trace " + path(name + ".csv") + " --record " +
                       path(name + ".log") + " --report " + path(name + ".json"));
  }
  nlohmann::json report(const std::string& name) const {
    return nlohmann::json::parse(read_file(path(name + ".json")));
  }
};

TEST_F(CliRun, EveryVerbHasHelp) {
  for (const char* arguments : {"--help", "run --help", "check --help", "study --help", "bus-load --help",
                                "monitor --help", "faults --help"}) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 0) << arguments;
    EXPECT_THAT(result.output, HasSubstr("Usage: godobject"));
    EXPECT_THAT(result.output, HasSubstr("Exit codes: 0 ok, 1 fault")) << arguments;
  }
  EXPECT_EQ(run_program("--version").exit_code, 0);
}

TEST_F(CliRun, FastIsBitIdentical) {
  for (const char* name : {"a", "b"}) ASSERT_EQ(run(name, rigid + " --fast --duration 1").exit_code, 0);
  EXPECT_EQ(read_file(path("a.csv")), read_file(path("b.csv")));
  EXPECT_EQ(read_file(path("a.log")), read_file(path("b.log")));
  EXPECT_EQ(report("a")["state_hash"], report("b")["state_hash"]);
  EXPECT_GT(read_file(path("a.log")).size(), 100'000u);
}

TEST_F(CliRun, TraceHasItsColumnsAndOneRowPerStep) {
  ASSERT_EQ(run("a", rigid + " --duration 0.2 --step 2e-3").exit_code, 0);
  const CsvResult trace = read_csv(path("a.csv"));
  ASSERT_TRUE(trace.table.has_value()) << trace.errors.front();
  const LoadResult scene = load_scene(GODOBJECT_SOURCE_DIR "/" + rigid);
  EXPECT_EQ(trace.table->columns(), trace_columns(*scene.scene));
  ASSERT_EQ(trace.table->num_rows(), 101u);
  EXPECT_EQ(trace.table->at(0, 0), 0);
  EXPECT_DOUBLE_EQ(trace.table->at(100, 0), 0.2);
}

TEST_F(CliRun, RecordIsACandumpLogOfBothBusesInTheOrderOfTime) {
  ASSERT_EQ(run("a", rigid + " --duration 0.5").exit_code, 0);
  std::istringstream log(read_file(path("a.log")));
  std::set<std::string, std::less<>> buses;
  Nanoseconds last_ns = 0;
  std::size_t num_syncs = 0;
  for (std::string line; std::getline(log, line);) {
    ReceivedFrame received;
    std::string_view bus;
    ASSERT_EQ(parse_candump(line, received, bus), CandumpResult::ok) << line;
    ASSERT_GE(received.t_ns, last_ns) << line;
    last_ns = received.t_ns;
    if (!buses.contains(bus)) buses.emplace(bus);
    num_syncs += received.frame.id == 0x080 ? 1 : 0;
  }
  EXPECT_EQ(buses, (std::set<std::string, std::less<>>{"can0", "can1"}));
  EXPECT_GT(num_syncs, 2u * 500);  // and those of the boot
}

TEST_F(CliRun, ReportHasWhatTheSummaryShows) {
  const ProgramResult result = run("a", rigid + " --duration 1 --integrator implicit-euler");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part : {"following error", "sensing error", "with no encoders", "encoders add", "bus load",
                           "compute (with simulation)", "the step alone", "limits hit", "faults",
                           "state hash", "a.csv", "a.log", "a.json"})
    EXPECT_THAT(result.output, HasSubstr(part));
  const nlohmann::json json = report("a");
  EXPECT_EQ(json["cycles"], 1000);
  EXPECT_EQ(json["step_s"], 1e-3);
  EXPECT_EQ(json["integrator"], "implicit-euler");
  EXPECT_EQ(json["scene"], "rigid");
  EXPECT_TRUE(json["faults"].empty());
  EXPECT_EQ(json["limits"]["ramp"], 501);  // 0.5 s, and the step at which it begins
  std::uint64_t counted = 0;
  for (const auto& bin : json["timing"]["compute_us"]["histogram"]) counted += bin[1].get<std::uint64_t>();
  EXPECT_EQ(counted, 1000u);
  EXPECT_TRUE(json["timing"]["wake_us"].is_null());
  EXPECT_TRUE(json["stopped_by"].is_null());
  ASSERT_EQ(json["bus"].size(), 2u);
  for (const auto& bus : json["bus"]) {
    EXPECT_GT(bus["measured_percent"], 20);
    EXPECT_LE(bus["measured_percent"], bus["worst_percent"]);
  }
  EXPECT_EQ(json["answers"]["incomplete_syncs"], 0);
  EXPECT_GT(json["following"]["rms_m"], json["sensing"]["rms_m"]);
  EXPECT_LT(json["sensing"]["max_m"], 2e-5);  // some counts of 2 pi / 262144 on 0.36 m of arm
  EXPECT_THAT(json["state_hash"].get<std::string>(), testing::MatchesRegex("[0-9a-f]{16}"));
}

/// What the log of a run's frames says of its end.
struct LastFrames {
  std::map<std::pair<std::string, std::uint32_t>, std::uint32_t> commands;  // RPDO1: controlword and torque
  std::set<std::pair<std::string, int>> pre_operational;
  std::size_t commands_with_torque = 0;
};

LastFrames last_frames(const std::string& text) {
  LastFrames last;
  std::istringstream log(text);
  for (std::string line; std::getline(log, line);) {
    ReceivedFrame received;
    std::string_view bus;
    EXPECT_EQ(parse_candump(line, received, bus), CandumpResult::ok) << line;
    const CanFrame& frame = received.frame;
    if (frame.id == 0x000 && frame.data[0] == 0x80) last.pre_operational.emplace(bus, frame.data[1]);
    if ((frame.id & 0x780u) != 0x200) continue;
    std::uint32_t command = 0;
    for (int i = 3; i >= 0; --i) command = command << 8 | frame.data[static_cast<std::size_t>(i)];
    last.commands[{std::string(bus), frame.id}] = command;
    last.commands_with_torque += command >> 16 != 0 ? 1 : 0;
  }
  return last;
}

/// Every drive disabled with no torque, every node out of Operational; also where a fault came up.
TEST_F(CliRun, EndsWithTheMotorsOff) {
  std::string faulty = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
  const std::string encoder = "[[device.encoder]]\n";
  faulty.insert(faulty.find(encoder) + encoder.size(), "max_speed = 0.05\n");
  const RigParams rig = *load_scene(GODOBJECT_SOURCE_DIR "/" + rigid).scene->device->rig;
  for (const auto& [scene, exit_code] : {std::pair{rigid, 0}, {write("faulty.toml", faulty), 1}}) {
    const ProgramResult result = run("a", scene + " --duration 1");
    ASSERT_EQ(result.exit_code, exit_code) << result.output;
    const LastFrames last = last_frames(read_file(path("a.log")));
    EXPECT_TRUE(exit_code == 1 || last.commands_with_torque > 100);
    EXPECT_EQ(last.commands.size(), rig.drives.size());
    for (const auto& [drive, command] : last.commands) EXPECT_EQ(command, 0u) << drive.first << drive.second;
    EXPECT_EQ(last.pre_operational.size(), rig.drives.size() + rig.encoders.size());
  }
}

TEST_F(CliRun, WithoutACountedCycleThereIsNoFollowingError) {
  const ProgramResult result = run("a", rigid + " --duration 0.1");  // the ramp takes 0.5 s
  ASSERT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, HasSubstr("not measured"));
  EXPECT_TRUE(report("a")["following"].is_null());
}

TEST_F(CliRun, NodesKeepTheHeartbeatTimeoutOfTheScene) {
  std::string scene = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
  const std::string before = "[device.chain]";
  scene.insert(scene.find(before), "[device.supervision]\nheartbeat_timeout = 0.05\nhost_node_id = 100\n");
  // the profile's own heartbeat, 50 ms, would be too slow for it
  const std::string profile = "profile = \"generic-402\"", none = "watchdog = \"none\"";
  for (std::size_t at = 0; (at = scene.find(profile, at)) != std::string::npos;)
    scene.replace(at, profile.size(), none);
  const ProgramResult result = run_program("run " + write("watched.toml", scene) + " --duration 1");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const ProgramResult check = run_program("check " + path("watched.toml"));
  EXPECT_THAT(check.output, testing::ContainsRegex("host heartbeat +0x764 +10 "));
}

TEST_F(CliRun, AMotionMayBeginWithAByteOrderMark) {
  const std::string motion = write("motion.csv", "\xEF\xBB\xBFt,tool.engaged\n0,1\n");
  const ProgramResult result = run_program("run " + rigid + " --duration 0.1 --motion " + motion);
  EXPECT_EQ(result.exit_code, 0) << result.output;
}

TEST_F(CliRun, DirectHasNoSensingError) {
  ASSERT_EQ(run_program("run " + rigid + " --bus direct --duration 1 --report " + path("a.json")).exit_code,
            0);
  EXPECT_EQ(report("a")["sensing"]["max_m"], 0.0);
  EXPECT_FALSE(report("a").contains("encoders"));
  EXPECT_TRUE(report("a")["bus"].empty());
}

TEST_F(CliRun, EveryShippedSceneRuns) {
  for (const auto& entry : std::filesystem::directory_iterator(GODOBJECT_SOURCE_DIR "/sim/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    const ProgramResult result = run_program("run " + entry.path().string() + " --duration 1");
    EXPECT_EQ(result.exit_code, 0) << entry.path() << '\n' << result.output;
  }
}

TEST_F(CliRun, RealtimeGivesTheStatesOfFast) {
  ASSERT_EQ(run("fast", rigid + " --fast --duration 0.5").exit_code, 0);
  const ProgramResult result = run("rt", rigid + " --realtime --duration 0.5");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part : {"real-time set-up", "missed deadlines", "wake-up", "lost to the files"})
    EXPECT_THAT(result.output, HasSubstr(part));
  EXPECT_EQ(read_file(path("rt.csv")), read_file(path("fast.csv")));
  EXPECT_EQ(read_file(path("rt.log")), read_file(path("fast.log")));
  EXPECT_EQ(report("rt")["state_hash"], report("fast")["state_hash"]);
  EXPECT_FALSE(report("rt")["machine"]["rt_setup"].empty());
}

TEST_F(CliRun, AnInterruptedRunEndsWithItsSummaryAndCompleteFiles) {
  const ProgramResult result =
      run_program("run " + rigid + " --realtime --duration 100 --trace " + path("a.csv") + " --report " +
                  path("a.json") + " & p=$!; sleep 1; kill -INT $p; wait $p");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("state hash"));
  EXPECT_THAT(result.output, testing::ContainsRegex("stopped by +SIGINT"));
  EXPECT_EQ(report("a")["stopped_by"], "SIGINT");
  const CsvResult trace = read_csv(path("a.csv"));
  ASSERT_TRUE(trace.table.has_value());
  EXPECT_GT(trace.table->num_rows(), 10u);
}

TEST_F(CliRun, CheckPrintsConfigurationPartsBytesAndBusLoad) {
  const ProgramResult result = run_program("check " + rigid);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part :
       {"[scene]", "damping", "composition 'haptic-1 tr-bdf2'", "coupling", "feedback", "scratch", "total",
        "compiled in", "bus can0", "bus can1", "0x181", "worst case", "above 50 %"})
    EXPECT_THAT(result.output, HasSubstr(part));
}

TEST_F(CliRun, CheckPrintsCapacitiesAndTheTopSpeedOfContacts) {
  const std::string scene =
      "[scene]\nname = \"foil\"\n[[body]]\nname = \"ball\"\nmass = 0.1\ninertia = [1e-5, 1e-5, 1e-5]\n"
      "[[body.sphere]]\nradius = 0.001\n[[obstacle]]\nname = \"foil\"\nkind = \"box\"\n"
      "half_extents = [0.1, 0.1, 0.0005]\n[[contact]]\nmaterials = [\"default\", \"default\"]\nstiffness = "
      "1e7\n";
  const ProgramResult result = run_program("check " + write("foil.toml", scene));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part : {"composition 'free-contacts-1 implicit-euler'", "capacities used", "1 of 64",
                           "top speed at which nothing passes anything: 1.5 m/s", "warning: above 1.5 m/s",
                           "sphere of body 'ball' and obstacle 'foil'"})
    EXPECT_THAT(result.output, HasSubstr(part));
}

TEST_F(CliRun, CheckRefusesABusThatCannotCarryItsMessages) {
  std::string scene = read_file(GODOBJECT_SOURCE_DIR "/" + rigid);
  const std::string rate = "bit_rate = 1e6";
  scene.replace(scene.find(rate), rate.size(), "bit_rate = 5e5");
  const ProgramResult result = run_program("check " + write("slow.toml", scene));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("error: the bus cannot carry its messages"));
}

}  // namespace
}  // namespace godobject::test::test_cli_run
