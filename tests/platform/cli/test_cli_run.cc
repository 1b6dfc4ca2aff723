// Successful runs: their output, their files, and bitwise repetition.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include <nlohmann/json.hpp>

#include "hal/can/candump.h"
#include "platform/rt/stages.h"
#include "platform/scene/text/csv.h"
#include "platform/scene/toml.h"
#include "platform/trace/trace.h"
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

TEST_F(CliRun, TraceEveryKeepsEveryNthRow) {
  ASSERT_EQ(run("all", rigid + " --duration 0.2").exit_code, 0);
  ASSERT_EQ(run("some", rigid + " --duration 0.2 --trace-every 7").exit_code, 0);
  const CsvResult all = read_csv(path("all.csv")), some = read_csv(path("some.csv"));
  ASSERT_TRUE(all.table && some.table);
  ASSERT_EQ(some.table->num_rows(), (all.table->num_rows() + 6) / 7);
  for (std::size_t i = 0; i < some.table->num_rows(); ++i)
    for (std::size_t c = 0; c < all.table->columns().size(); ++c)
      ASSERT_EQ(some.table->at(i, c), all.table->at(7 * i, c)) << i << ", " << all.table->columns()[c];
}

TEST_F(CliRun, NodesOfNetsAreWrittenEveryNthStep) {
  const std::string small = "sim/scenes/net-small.toml";
  ASSERT_EQ(
      run_program("run " + small + " --fast --duration 0.1 --nets " + path("nets.csv") + " --nets-every 20")
          .exit_code,
      0);
  const CsvResult nets = read_csv(path("nets.csv"));
  ASSERT_TRUE(nets.table.has_value()) << nets.errors.front();
  EXPECT_EQ(nets.table->columns().size(), 1U + 3 * 25);
  EXPECT_EQ(nets.table->columns()[1], "tube.0.x");
  ASSERT_EQ(nets.table->num_rows(), 6U);
  EXPECT_DOUBLE_EQ(nets.table->at(5, 0), 0.1);
  const Vec3 p_W(nets.table->at(0, 1), nets.table->at(0, 2), nets.table->at(0, 3));
  EXPECT_NEAR(p_W.norm(), std::hypot(0.02, 0.0433), 1e-9) << "a corner of the tube";
  EXPECT_EQ(
      run("b", "sim/scenes/pendulum.toml --bus direct --duration 0.1 --nets " + path("no.csv")).exit_code, 2)
      << "it has no nets";
}

/// Returns the sum of the forces in a file of contacts for each time and body.
std::map<std::pair<double, std::string>, Vec3> contact_forces(const std::string& file) {
  std::map<std::pair<double, std::string>, Vec3> sums;
  std::istringstream lines(file);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "t,body,on,x,y,z,nx,ny,nz,fx,fy,fz");
  while (std::getline(lines, line)) {
    std::istringstream fields(line);
    std::vector<std::string> row;
    for (std::string field; std::getline(fields, field, ',');) row.push_back(field);
    EXPECT_EQ(row.size(), 12u) << line;
    const Vec3 f(std::stod(row[9]), std::stod(row[10]), std::stod(row[11]));
    for (const auto& [body, sign] : {std::pair{row[1], 1.0}, {row[2], -1.0}})
      sums.try_emplace({std::stod(row[0]), body}, Vec3::Zero()).first->second += sign * f;
  }
  return sums;
}

TEST_F(CliRun, ContactsAreListedWithTheirForces) {
  const std::string grasp = "sim/scenes/grasp.toml";
  ASSERT_EQ(run("a", grasp + " --duration 0.6 --contacts " + path("contacts.csv")).exit_code, 0);
  const auto forces = contact_forces(read_file(path("contacts.csv")));
  const CsvResult trace = read_csv(path("a.csv"));
  ASSERT_TRUE(trace.table);
  const std::set<std::string> touched = {"lower", "upper"};
  std::size_t num_checked = 0;
  for (std::size_t i = 1; i < trace.table->num_rows(); ++i)
    for (const std::string& body : touched) {
      const auto column = [&](const char* name) {
        return trace.table->at(i, trace.table->find(body + ".contact." + name).value());
      };
      const auto sum = forces.find({trace.table->at(i, 0), body});
      const Vec3 f = sum == forces.end() ? Vec3(Vec3::Zero()) : sum->second;
      ASSERT_NEAR((f - Vec3(column("fx"), column("fy"), column("fz"))).norm(), 0, 1e-9)
          << body << ", row " << i;
      num_checked += f.norm() > 0 ? 1 : 0;
    }
  EXPECT_GT(num_checked, 100u);
}

TEST_F(CliRun, ContactsAreRefusedWhereNothingCanTouch) {
  const ProgramResult result = run_program("run " + rigid + " --duration 0.1 --contacts " + path("c.csv"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("--contacts: nothing in scene 'rigid' can touch"));
}

TEST_F(CliRun, PlotsAreOfWhatThereIs) {
  if (std::system("command -v gnuplot > /dev/null && command -v python3 > /dev/null") != 0)
    GTEST_SKIP() << "gnuplot or python3 is not installed";
  const auto plotted = [&](const std::string& scene, const std::string& options) {
    EXPECT_EQ(run_program("run " + scene + " " + options + " --trace " + path("trace.csv")).exit_code, 0);
    for (const char* name : {"following", "force", "joints", "contacts", "energy"})
      std::filesystem::remove(path(std::string(name) + ".png"));
    EXPECT_EQ(std::system(
                  ("cd '" GODOBJECT_SOURCE_DIR "' && ./dev plot " + path("") + " > " + path("log") + " 2>&1")
                      .c_str()),
              0)
        << read_file(path("log"));
    std::set<std::string> names;
    for (const char* name : {"following", "force", "joints", "contacts", "energy"})
      if (std::filesystem::exists(path(std::string(name) + ".png"))) names.insert(name);
    return names;
  };
  EXPECT_EQ(plotted("sim/scenes/lego.toml",
                    "--bus direct --motion sim/scenes/lego-motion.csv --duration 0.6 --trace-every 20"),
            (std::set<std::string>{"following", "force", "contacts", "energy"}))
      << "hand.* is no joint's";
  EXPECT_EQ(plotted("sim/scenes/grasp.toml", "--duration 0.2"),
            (std::set<std::string>{"following", "force", "joints", "contacts", "energy"}));
  EXPECT_EQ(plotted("sim/scenes/pendulum.toml", "--duration 0.2"),
            (std::set<std::string>{"joints", "energy"}));
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
  EXPECT_GT(num_syncs, 2u * 500);  // with those of the boot
}

TEST_F(CliRun, ReportHasWhatTheSummaryShows) {
  const ProgramResult result = run("a", rigid + " --duration 1 --integrator implicit-euler");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part :
       {"following error", "sensing error", "with no encoders", "encoders add", "bus load", "cycle  ",
        "compute", "  decode", "limits hit", "faults", "state hash", "a.csv", "a.log", "a.json"})
    EXPECT_THAT(result.output, HasSubstr(part));
  const nlohmann::json json = report("a");
  EXPECT_EQ(json["cycles"], 1000);
  EXPECT_EQ(json["step_s"], 1e-3);
  EXPECT_EQ(json["integrator"], "implicit-euler");
  EXPECT_EQ(json["scene"], "rigid");
  EXPECT_TRUE(json["faults"].empty());
  EXPECT_EQ(json["limits"]["ramp"], 501);  // 0.5 s, and the step in which it begins
  std::uint64_t counted = 0;
  for (const auto& bin : json["timing"]["compute_us"]["histogram"]) counted += bin[1].get<std::uint64_t>();
  EXPECT_EQ(counted, 1000u);
  std::vector<std::string> stages;
  for (const auto& stage : json["timing"]["stages_us"].items()) {
    stages.push_back(stage.key());
    EXPECT_GT(stage.value()["max"], 0) << stage.key();
  }
  EXPECT_EQ(stages.size(), stage_names.size());
  EXPECT_GT(json["timing"]["cycle_us"]["p50"], json["timing"]["compute_us"]["p50"]) << "the simulated device";
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

/// Frames at the end of a run's log.
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

/// Every drive is disabled without torque, every node out of Operational; also after a fault.
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
  // because the profile's own heartbeat, 50 ms, would be too slow for it
  const std::string profile = "profile = \"generic-402\"", none = "watchdog = \"none\"";
  for (std::size_t at = 0; (at = scene.find(profile, at)) != std::string::npos;)
    scene.replace(at, profile.size(), none);
  const ProgramResult result = run_program("run " + write("watched.toml", scene) + " --duration 1");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const ProgramResult check = run_program("check --full " + path("watched.toml"));
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

/// A cycle takes 1.5 ms under ThreadSanitizer, 5 ms on a busy machine: the period of 10 ms leaves a margin.
TEST_F(CliRun, RealtimeGivesTheStatesOfFast) {
  const std::string slow = rigid + " --step 0.01 --duration 1";
  ASSERT_EQ(run("fast", slow + " --fast").exit_code, 0);
  // Missed deadlines are held, which changes the states: such a run is repeated.
  ProgramResult result;
  int holds = 1;
  for (int attempt = 0; holds > 0 && attempt < 10; ++attempt) {
    result = run("rt", slow + " --realtime");
    for (const char* part : {"real-time set-up", "missed deadlines", "wake-up", "lost to the files"})
      EXPECT_THAT(result.output, HasSubstr(part));
    EXPECT_FALSE(report("rt")["machine"]["rt_setup"].empty());
    holds = report("rt")["timing"]["holds"];
  }
  ASSERT_EQ(holds, 0) << result.output;
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(read_file(path("rt.csv")), read_file(path("fast.csv")));
  EXPECT_EQ(read_file(path("rt.log")), read_file(path("fast.log")));
  EXPECT_EQ(report("rt")["state_hash"], report("fast")["state_hash"]);
}

/// The signal is sent once the run has written rows: before its loop a shell ignores it for the program.
TEST_F(CliRun, AnInterruptedRunEndsWithItsSummaryAndCompleteFiles) {
  const ProgramResult result = run_program(
      "run " + rigid + " --realtime --step 0.01 --duration 100 --trace " + path("a.csv") + " --report " +
      path("a.json") + " & p=$!; for i in $(seq 300); do test $(cat " + path("a.csv") +
      " 2> /dev/null | wc -l) -gt 20 && break; sleep 0.1; done; kill -INT $p; wait $p");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("state hash"));
  EXPECT_THAT(result.output, testing::ContainsRegex("stopped by +SIGINT"));
  EXPECT_EQ(report("a")["stopped_by"], "SIGINT");
  const CsvResult trace = read_csv(path("a.csv"));
  ASSERT_TRUE(trace.table.has_value());
  EXPECT_GT(trace.table->num_rows(), 10u);
}

TEST_F(CliRun, QuietSaysOnlyWhatIsWrong) {
  const ProgramResult well =
      run_program("run sim/scenes/non-haptic.toml --quiet --duration 0.1 --report " + path("q.json"));
  EXPECT_EQ(well.exit_code, 0);
  EXPECT_EQ(well.output, "");
  EXPECT_EQ(report("q")["cycles"], 100);
  EXPECT_THAT(run_program("run " + rigid + " --quiet --realtime --duration 0.1").output,
              testing::Not(HasSubstr("real-time set-up")));
  const std::string motion = write("far.csv",
                                   "t,tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz\n"
                                   "0,0.05,0.04,0.03,1,0,0,0\n0.5,5,0,0,1,0,0,0\n");
  const ProgramResult ill = run_program("run " + rigid + " --quiet --motion " + motion);
  EXPECT_EQ(ill.exit_code, 1);
  EXPECT_THAT(ill.output, HasSubstr("unreachable"));
  EXPECT_THAT(ill.output, testing::Not(HasSubstr("state hash")));
}

TEST_F(CliRun, AnOutputsFolderIsMade) {
  const ProgramResult result =
      run_program("run " + rigid + " --duration 0.1 --trace " + path("out/t.csv") + " --record " +
                  path("logs/b.log") + " --report " + path("out/r.json"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  for (const char* file : {"out/t.csv", "logs/b.log", "out/r.json"})
    EXPECT_GT(read_file(path(file)).size(), 100u) << file;
  EXPECT_EQ(run_program("check " + rigid + " --trace " + path("never/t.csv")).exit_code, 0);
  EXPECT_FALSE(std::filesystem::exists(path("never")));
}

TEST_F(CliRun, StandardOutputThatCannotBeWrittenIsAnError) {
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  for (const std::string& arguments : {"run " + rigid + " --duration 0.1", "check --full " + rigid,
                                       std::string("faults"), std::string("--help")}) {
    const ProgramResult result = run_program(arguments, "sh -c 'exec \"$0\" \"$@\" 2>&1 > /dev/full' ");
    EXPECT_EQ(result.exit_code, 1) << arguments;
    EXPECT_THAT(result.output, HasSubstr("could not be written: ")) << arguments;
  }
}

TEST_F(CliRun, CheckSaysInADozenLinesWhatRuns) {
  const ProgramResult result = run_program("check " + rigid);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const ProgramResult lines = run_program("check " + rigid, "sh -c 'exec \"$0\" \"$@\" 2> /dev/null' ");
  EXPECT_LE(std::ranges::count(lines.output, '\n'), 19) << lines.output;
  for (const char* part :
       {"'rigid', 1 body", "'rigid-1 tr-bdf2'", "10 s in steps of 0.001 s", "6 encoders, 3 drives",
        "5 N, 0.2 N m", "can0: load 63.0 % at worst", "above 50 %", "--full"})
    EXPECT_THAT(result.output, HasSubstr(part));
  EXPECT_EQ(run_program("check --quiet sim/scenes/s1.toml").output, "");
}

TEST_F(CliRun, CheckPrintsConfigurationPartsBytesAndBusLoad) {
  const ProgramResult result = run_program("check --full " + rigid);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part :
       {"[scene]", "damping", "composition 'rigid-1 tr-bdf2'", "coupling", "feedback", "scratch", "total",
        "compiled in", "bus can0", "bus can1", "0x181", "worst case", "above 50 %"})
    EXPECT_THAT(result.output, HasSubstr(part));
}

TEST_F(CliRun, CheckPrintsCapacitiesAndTheTopSpeedOfContacts) {
  const std::string scene =
      "[scene]\nname = \"foil\"\n[[body]]\nname = \"ball\"\nmass = 0.1\ninertia = [1e-5, 1e-5, 1e-5]\n"
      "[[body.sphere]]\nradius = 0.001\n[[obstacle]]\nname = \"foil\"\nkind = \"box\"\n"
      "half_extents = [0.1, 0.1, 0.0005]\n[[contact]]\nmaterials = [\"default\", \"default\"]\nstiffness = "
      "1e7\n";
  const ProgramResult result = run_program("check --full " + write("foil.toml", scene));
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* part : {"composition 'contacts-1 tr-bdf2'", "capacities used", "1 of 64",
                           "top speed up to which nothing passes through a solid: 1.5 m/s", "warning: ",
                           "foil.toml: above 1.5 m/s", "sphere of body 'ball' and obstacle 'foil'"})
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
