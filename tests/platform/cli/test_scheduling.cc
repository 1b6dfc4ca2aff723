// Options --core and --deadline of godobject run: cores of its threads, and refusals.
#include <gmock/gmock.h>
#include <sched.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>

#include <nlohmann/json.hpp>

#include "tests/support/background_program.h"
#include "tests/support/program.h"

namespace godobject::test::test_scheduling {
namespace {

using testing::HasSubstr;

const std::string rigid = "run sim/scenes/rigid.toml ";

using Scheduling = ProgramTest;

TEST_F(Scheduling, WrongOptionsAreUsage) {
  for (const auto& [options, message] :
       {std::pair<std::string, const char*>{"--core 1023", "--core: this machine has no core 1023: it has 0"},
        {"--core x", "--core"},
        {"--deadline 1000", "--deadline: 1000 us are not shorter than the step of 1000 us"},
        {"--deadline 500 --step 5e-4", "--deadline: 500 us"},
        {"--deadline 1", "--deadline"},
        {"--core 0 --deadline 100", "excludes"},
        {"--core 0 --fast", "excludes"},
        {"--deadline 100 --fast", "excludes"}}) {
    const ProgramResult result = run_program(rigid + options);
    EXPECT_EQ(result.exit_code, 2) << options << result.output;
    EXPECT_THAT(result.output, HasSubstr(message));
  }
}

/// Returns the cores of each thread of a process, by its name.
std::map<std::string, std::string, std::less<>> cores_of(pid_t process) {
  std::map<std::string, std::string, std::less<>> cores;
  std::error_code error;
  for (const auto& thread :
       std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task", error)) {
    std::ifstream comm(thread.path() / "comm"), status(thread.path() / "status");
    std::string name, list;
    std::getline(comm, name);
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("Cpus_allowed_list:\t")) list = line.substr(line.find('\t') + 1);
    cores[name] = list;
  }
  return cores;
}

TEST_F(Scheduling, TheLoopAloneRunsOnItsCore) {
  cpu_set_t allowed;
  ASSERT_EQ(sched_getaffinity(0, sizeof allowed, &allowed), 0);
  if (CPU_COUNT(&allowed) < 2) GTEST_SKIP() << "one core";
  int core = CPU_SETSIZE - 1;
  while (!CPU_ISSET(core, &allowed)) --core;
  const std::string n = std::to_string(core);
  BackgroundProgram host({"run", "sim/scenes/rigid.toml", "--core", n, "--duration", "3", "--quiet",
                          "--trace", path("trace.csv"), "--report", path("report.json")});
  std::map<std::string, std::string, std::less<>> cores;
  for (int i = 0; i < 100 && !cores.contains("loop"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    cores = cores_of(host.pid());
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // for the set-up of the thread
  cores = cores_of(host.pid());
  static_cast<void>(host.wait_status());
  ASSERT_TRUE(cores.contains("loop"));
  ASSERT_TRUE(cores.contains("file"));
  for (const auto& [name, list] : cores) EXPECT_EQ(list == n, name == "loop") << name << ": " << list;
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")));
  EXPECT_THAT(report["machine"]["rt_setup"].dump(), HasSubstr("\"other threads\""));
}

TEST_F(Scheduling, ARefusedDeadlineStartsNoRun) {
  const std::string no_rights = "setpriv --bounding-set=-all --inh-caps=-all prlimit --rtprio=0 ";
  if (run_program("--version", no_rights).exit_code != 0) GTEST_SKIP() << "no setpriv or prlimit here";
  const ProgramResult result = run_program(rigid + "--deadline 300 --duration 0.1", no_rights);
  EXPECT_EQ(result.exit_code, 3) << result.output;
  EXPECT_THAT(result.output, HasSubstr("--deadline: this machine does not meet"));
  EXPECT_THAT(result.output, HasSubstr("setcap cap_sys_nice+ep"));
}

TEST_F(Scheduling, ADeadlineIsInTheReportWherePermitted) {
  const ProgramResult result =
      run_program(rigid + "--deadline 500 --duration 0.3 --seal --report " + path("report.json"));
  if (result.exit_code == 3) GTEST_SKIP() << result.output;
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")));
  EXPECT_THAT(report["machine"]["rt_setup"].dump(), HasSubstr("SCHED_DEADLINE 500 us of each 1000 us"));
  EXPECT_EQ(report["seal"]["refused_calls"], 0);
  EXPECT_GT(report["cycles"], 10);
}

}  // namespace
}  // namespace godobject::test::test_scheduling
