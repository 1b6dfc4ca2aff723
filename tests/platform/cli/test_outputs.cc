// Files, pipes and names that must not disturb the program.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <sstream>
#include <thread>

#include <nlohmann/json.hpp>

#include "platform/cli/report/files.h"
#include "platform/rt/background_file.h"
#include "tests/support/background_program.h"
#include "tests/support/program.h"

namespace godobject::test::test_outputs {
namespace {

using std::chrono::milliseconds;
using testing::AnyOf;
using testing::HasSubstr;
using testing::Not;
using Clock = BackgroundFile::Clock;

constexpr std::size_t room = 1 << 16;

class OutputFiles : public ProgramTest {
 protected:
  std::string fifo() const {
    const std::string name = path("fifo");
    EXPECT_EQ(mkfifo(name.c_str(), 0600), 0);
    return name;
  }
};

TEST_F(OutputFiles, RowsOfAnInputLogThatNobodyReadsAreCounted) {
  InputLogOnDisk log(fifo(), room);
  log.add("head", 0, milliseconds(0));
  for (int i = 0; i < 5; ++i) log.add("a chunk", 20, milliseconds(0));
  const std::optional<FileLoss> loss = log.close(Clock::now());
  ASSERT_TRUE(loss.has_value());
  EXPECT_EQ(loss->lost_lines, 100u);
}

class Outputs : public ProgramTest {};

constexpr const char* short_run = "run sim/scenes/rigid.toml --duration 0.05";

/// Its other end is never opened.
TEST_F(Outputs, ATraceThatNobodyReadsDoesNotKeepTheProgram) {
  const std::string name = path("fifo");
  ASSERT_EQ(mkfifo(name.c_str(), 0600), 0);
  const ProgramResult result = run_program(std::string(short_run) + " --trace '" + name + "'", "timeout 20 ");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("file_incomplete: " + name + " could not be written in full"));
  EXPECT_THAT(result.output, HasSubstr("it lacks 52 lines")) << "header, start and 50 cycles";
}

TEST_F(Outputs, AReportThatNobodyReadsDoesNotKeepTheProgram) {
  const std::string name = path("fifo");
  ASSERT_EQ(mkfifo(name.c_str(), 0600), 0);
  const ProgramResult result =
      run_program(std::string(short_run) + " --report '" + name + "'", "timeout 20 ");
  EXPECT_EQ(result.exit_code, 1) << result.output;
  EXPECT_THAT(result.output, HasSubstr("file_incomplete: " + name));
}

TEST_F(Outputs, APathNeedNotBeUtf8) {
  const std::string trace = path("\xff.csv"), report = path("report.json");
  const ProgramResult result =
      run_program(std::string(short_run) + " --trace '" + trace + "' --report '" + report + "'");
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const auto json = nlohmann::json::parse(read_file(report));
  EXPECT_THAT(json["files"]["trace"].get<std::string>(), HasSubstr("\xEF\xBF\xBD.csv"))
      << "U+FFFD in its place";
  EXPECT_FALSE(read_file(trace).empty());
}

TEST_F(Outputs, ACommandNeedNotBeUtf8) {
  BackgroundProgram simulate(
      {"simulate", "sim/scenes/rigid.toml", "--bus", "can0=pty", "--bus", "can1=pty", "--control", "-"});
  for (std::string line = simulate.line(); line != "ready"; line = simulate.line())
    ASSERT_FALSE(line.empty());
  for (const char* command : {"\xff", "fault \xff", "fault drop bus=\xff"}) {
    const auto reply = nlohmann::json::parse(simulate.say(command), nullptr, false);
    ASSERT_FALSE(reply.is_discarded()) << command;
    EXPECT_EQ(reply["ok"], false);
    EXPECT_FALSE(reply["error"].get<std::string>().empty());
  }
  EXPECT_EQ(nlohmann::json::parse(simulate.say("quit"))["ok"], true);
}

/// --rearm auto is no request after an emergency stop, pressed alone or while another fault runs down.
TEST_F(Outputs, AnEmergencyStopIsNotRearmed) {
  const std::string hil = GODOBJECT_SOURCE_DIR "/tests/hil/", report = path("report.json");
  write("patient-402.toml", read_file(hil + "patient-402.toml"));
  const auto run = [&](const std::string& faults) {
    const std::string scene = write("rig.toml", read_file(hil + "rig.toml") + faults);
    const ProgramResult result =
        run_program("run '" + scene + "' --duration 5 --rearm auto --report '" + report + "'");
    EXPECT_EQ(result.exit_code, 1) << result.output;
    std::vector<std::string> kinds;
    const nlohmann::json events = nlohmann::json::parse(read_file(report))["events"];
    for (const auto& event : events) kinds.push_back(event["event"]);
    return kinds;
  };
  const std::string press = "\n[[fault]]\nverb = \"press\"\nnode_id = 21\nduration = 0.2\nat = 0.3\n";
  const std::string other = "\n[[fault]]\nverb = \"emcy\"\nnode_id = 1\nvalue = 20480\nat = 0.3\n";
  EXPECT_THAT(run(press), testing::ElementsAre("fault", "lost"));
  EXPECT_THAT(run(other + press), testing::ElementsAre("fault", "fault", "lost"));
}

/// Printed when they occur, with all details, and also in the report; also on the simulated clock.
TEST_F(Outputs, FaultsAndRearmingAreReported) {
  const std::string hil = GODOBJECT_SOURCE_DIR "/tests/hil/";
  write("patient-402.toml", read_file(hil + "patient-402.toml"));
  const std::string scene = write("rig.toml", read_file(hil + "rig.toml") + R"(
[[fault]]
verb = "emcy"
bus = "can0"
node_id = 1
value = 20480
at = 0.3
)");
  const std::string report = path("report.json");
  const ProgramResult result =
      run_program("run '" + scene + "' --duration 2 --rearm auto --report '" + report + "'");
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output,
              testing::ContainsRegex(
                  "at 0\\.3[0-9]+ s: FAULT emergency \\(can0 node 1, encoder of turret, code 0x5000\\): "));
  EXPECT_THAT(result.output, HasSubstr(" s: the device is lost"));
  EXPECT_THAT(result.output, HasSubstr(" s: ARMED again: the motors have torque\n"));
  const auto events = nlohmann::json::parse(read_file(report))["events"];
  ASSERT_GE(events.size(), 4u);
  std::vector<std::string> kinds;
  for (const auto& event : events) kinds.push_back(event["event"]);
  EXPECT_THAT(kinds, testing::ElementsAre("fault", "lost", "trying", "armed"));
  EXPECT_NEAR(events[0]["t_s"].get<double>(), 0.3, 0.05);
  EXPECT_EQ(events[0]["name"], "emergency");
  EXPECT_EQ(events[0]["bus"], "can0");
  EXPECT_EQ(events[0]["node"], 1);
  EXPECT_FALSE(events[0]["cause"].get<std::string>().empty());
  EXPECT_FALSE(events[0]["remedy"].get<std::string>().empty());
  EXPECT_GT(events[3]["t_s"], events[0]["t_s"]);
}

/// Limits from too little to start at all to enough.
TEST_F(Outputs, OutOfMemoryInSetUpIsReported) {
#ifdef GODOBJECT_SANITIZED
  GTEST_SKIP() << "a sanitizer takes more addresses than the limit, and ends a program without memory";
#endif
  bool was_reported = false;
  for (int kib = 20'000; kib <= 100'000; kib += 2'000) {
    const ProgramResult result = run_program(std::string(short_run) + " --realtime",
                                             "ulimit -v " + std::to_string(kib) + " && timeout 20 ");
    EXPECT_THAT(result.exit_code, AnyOf(0, 1, 2, 3, 127)) << kib << " KiB: " << result.output;
    EXPECT_THAT(result.output, Not(HasSubstr("terminate called"))) << kib << " KiB";
    was_reported =
        was_reported || (result.exit_code == 3 && result.output.find("out of memory") != std::string::npos);
  }
  EXPECT_TRUE(was_reported);
}

/// Closed standard descriptors are not reused for a file, which would receive the status lines.
TEST_F(OutputFiles, ClosedStandardDescriptorsBecomeNoOutput) {
  for (const char* closed : {"2>&-", "<&-", "<&- >&- 2>&-", ">&- 2>&-"}) {
    const std::string trace = path("t.csv");
    const ProgramResult result =
        run_program("run sim/scenes/rigid.toml --bus sim --realtime --step 0.01 --duration 0.6 --trace " +
                        trace + " --record " + path("r.log"),
                    std::string("sh -c 'exec \"$0\" \"$@\" ") + closed + "' ");
    EXPECT_EQ(result.exit_code, 0) << closed;
    std::istringstream rows(read_file(trace));
    std::string row;
    ASSERT_TRUE(std::getline(rows, row) && row.starts_with("t,")) << closed << row;
    const auto commas = std::ranges::count(row, ',');
    while (std::getline(rows, row))
      ASSERT_TRUE(std::ranges::count(row, ',') == commas && row.find("cycle") == std::string::npos) << row;
  }
}

TEST_F(OutputFiles, ClosedStandardDescriptorsAreTheNullDevice) {
  BackgroundProgram run({"run", "sim/scenes/rigid.toml", "--bus", "sim", "--realtime", "--duration", "60",
                         "--trace", path("t.csv")},
                        {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO});
  const std::string of = "/proc/" + std::to_string(run.pid()) + "/fd/";
  for (int i = 0; i < 500 && read_file(path("t.csv")).empty(); ++i)
    std::this_thread::sleep_for(milliseconds(10));
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    EXPECT_EQ(std::filesystem::read_symlink(of + std::to_string(standard)), "/dev/null") << standard;
}

/// A killed run loses at most half a second of every file.
TEST_F(OutputFiles, AKilledRunHasWrittenAllButTheLastHalfSecond) {
  const std::vector<std::string> names{path("t.csv"), path("r.log")};
  // At a period of 10 ms a program under ThreadSanitizer keeps its deadlines, and the rig stays armed.
  BackgroundProgram run({"run", "sim/scenes/rigid.toml", "--bus", "sim", "--realtime", "--step", "0.01",
                         "--duration", "60", "--trace", names[0], "--record", names[1]});
  const auto size_of = [](const std::string& name) {
    std::error_code error;
    const auto size = std::filesystem::file_size(name, error);
    return error ? 0 : size;
  };
  for (int i = 0; i < 1000 && (size_of(names[0]) < 2000 || size_of(names[1]) == 0); ++i)
    std::this_thread::sleep_for(milliseconds(10));
  std::vector<std::uintmax_t> sizes(2);
  for (int i = 0; i < 4; ++i) {  // it grows all the time
    std::this_thread::sleep_for(milliseconds(500));
    for (std::size_t f = 0; f < sizes.size(); ++f) {
      EXPECT_GT(size_of(names[f]), sizes[f]) << names[f];
      sizes[f] = size_of(names[f]);
    }
  }
  run.end_by(SIGKILL);
  const auto last_time = [](const std::string& text, std::size_t begin) {
    const std::size_t end = text.rfind('\n');
    const std::size_t start = text.rfind('\n', end - 1) + 1;
    return std::stod(text.substr(start + begin));
  };
  const double trace_s = last_time(read_file(names[0]), 0), record_s = last_time(read_file(names[1]), 1);
  EXPECT_GT(trace_s, 1.5);
  EXPECT_NEAR(trace_s, record_s, 0.5) << "both up to the same time, but for the boot";
}

TEST_F(OutputFiles, FoldersOfAnOutputAreMadeWithTheirParents) {
  const std::string trace = path("a/b/c/t.csv"), report = path("d/e/r.json");
  EXPECT_EQ(run_program("run sim/scenes/rigid.toml --bus direct --duration 0.1 --trace " + trace +
                        " --report " + report)
                .exit_code,
            0);
  EXPECT_FALSE(read_file(trace).empty());
  EXPECT_FALSE(read_file(report).empty());
  const ProgramResult below_a_file =
      run_program("run sim/scenes/rigid.toml --bus direct --duration 0.1 --trace " + report + "/x/t.csv");
  EXPECT_EQ(below_a_file.exit_code, 2);
  EXPECT_THAT(below_a_file.output, HasSubstr("is not a folder"));
}

/// `ulimit -s`, which a process without rights cannot raise.
TEST_F(OutputFiles, ASmallStackIsEnough) {
  for (const char* scene : {"rigid", "lego", "organ-soft", "grasper", "endobag"})
    for (const char* verb :
         {"check", "run --duration 0.05 --bus direct --realtime", "run --duration 0.05 --bus direct"}) {
      const ProgramResult result = run_program(std::string(verb) + " sim/scenes/" + scene + ".toml",
                                               "sh -c 'ulimit -s 256; exec \"$0\" \"$@\"' ");
      // a busy machine or an instrumented step misses deadlines, which is a fault and no lack of stack
      const bool is_late =
          result.exit_code == 1 && result.output.find("deadlines_missed") != std::string::npos;
      EXPECT_TRUE(result.exit_code == 0 || is_late) << scene << ", " << verb << result.output;
    }
}

/// Unread answers of a simulation do not delay it.
TEST_F(OutputFiles, UnreadAnswersDoNotStallASimulation) {
  BackgroundProgram far({"simulate", "sim/scenes/rigid.toml", "--control", "-", "--report", path("r.json"),
                         "--bus", "can0=pty", "--bus", "can1=pty"});
  while (far.line() != "ready") continue;
  for (int i = 0; i < 2000; ++i) far.tell("status");
  far.tell("quit");
  for (int i = 0; i < 1000 && read_file(path("r.json")).empty(); ++i)
    std::this_thread::sleep_for(milliseconds(10));
  EXPECT_FALSE(read_file(path("r.json")).empty()) << "it has ended";
}

}  // namespace
}  // namespace godobject::test::test_outputs
