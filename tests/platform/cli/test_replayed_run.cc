// A rig that replays the record of a run: the same cycles, the same poses, no fault.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "tests/support/program.h"

namespace godobject::test::test_replayed_run {
namespace {

using testing::HasSubstr;

struct Trace {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;

  double at(std::size_t row, const std::string& name) const {
    return rows[row][static_cast<std::size_t>(std::ranges::find(names, name) - names.begin())];
  }
};

/// Reads the numbers of a trace; other cells are 0.
Trace read_trace(const std::string& path) {
  Trace trace;
  std::istringstream text(read_file(path));
  for (std::string line; std::getline(text, line);) {
    std::istringstream cells(line);
    const bool header = trace.names.empty();
    if (!header) trace.rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');)
      if (header) trace.names.push_back(cell);
      else trace.rows.back().push_back(std::strtod(cell.c_str(), nullptr));
  }
  return trace;
}

/// Returns the largest difference in columns with this ending, over the rows of both traces.
double difference(const Trace& a, const Trace& b, const std::string& ending) {
  double most = 0;
  for (std::size_t c = 0; c < a.names.size(); ++c)
    for (std::size_t i = 0; a.names[c].ends_with(ending) && i < std::min(a.rows.size(), b.rows.size()); ++i)
      most = std::max(most, std::abs(a.rows[i][c] - b.rows[i][c]));
  return most;
}

class ReplayedRun : public ProgramTest {
 protected:
  ProgramResult record(const std::string& scene, const std::string& options) {
    return run_program("run " + scene + " --fast --duration 0.6 --record " + path("run.log") + " --trace " +
                       path("first.csv") + " " + options);
  }
  ProgramResult replay(const std::string& scene, const std::string& bus, const std::string& options = "") {
    return run_program("run " + scene + " --duration 0.6 --bus " + bus + " --trace " + path("second.csv") +
                       " " + options);
  }
  void expect_the_same(double most_m) {
    const Trace first = read_trace(path("first.csv")), second = read_trace(path("second.csv"));
    EXPECT_EQ(first.names, second.names);
    EXPECT_EQ(first.rows.size(), second.rows.size());
    for (const std::string column : {".target.x", ".target.y", ".target.z", ".x", ".y", ".z"})
      EXPECT_LT(difference(first, second, column), most_m) << column;
    EXPECT_EQ(difference(first, second, "rig_fault"), 0);
  }
};

TEST_F(ReplayedRun, EveryRigRunsOnItsRecord) {
  for (const std::string name :
       {"rigid", "grasper", "grasp", "scissors-imposed", "desk", "relative", "non-haptic"}) {
    const std::string scene = "sim/scenes/" + name + ".toml";
    ASSERT_EQ(record(scene, "").exit_code, 0) << name;
    const ProgramResult result = replay(scene, "replay:" + path("run.log"));
    EXPECT_EQ(result.exit_code, 0) << name << "\n" << result.output;
    EXPECT_THAT(result.output, HasSubstr("600 cycles")) << name;
    expect_the_same(1e-4);
  }
}

/// A log and its own clock are all inputs of such a run, so its state is equal each time to the last bit.
TEST_F(ReplayedRun, TwoReplaysOfOneLogEndInEqualStates) {
  const auto hash_of = [this](const std::string& scene, const std::string& log) {
    const ProgramResult result = replay(scene, "replay:" + log, "--report " + path("r.json"));
    EXPECT_EQ(result.exit_code, 0) << scene << "\n" << result.output;
    const nlohmann::json report = nlohmann::json::parse(read_file(path("r.json")));
    EXPECT_EQ(report["cycles"], 600) << scene;
    return report["state_hash"].get<std::string>();
  };
  std::string once;
  for (const std::string name : {"grasper", "scissors-imposed", "desk", "rigid"}) {
    const std::string scene = "sim/scenes/" + name + ".toml";
    ASSERT_EQ(record(scene, "").exit_code, 0) << name;
    once = hash_of(scene, path("run.log"));
    EXPECT_THAT(once, testing::MatchesRegex("[0-9a-f]{16}"));
    EXPECT_EQ(hash_of(scene, path("run.log")), once) << name;
  }
  // One other digit of one encoder's position is another state.
  std::string log = read_file(path("run.log"));
  const std::string answer = " 181#";
  const std::size_t at = log.find(answer, log.size() / 2) + answer.size();
  ASSERT_GT(at, log.size() / 2);
  log[at] = log[at] == '0' ? '1' : '0';
  EXPECT_NE(hash_of("sim/scenes/rigid.toml", write("other.log", log)), once);
}

TEST_F(ReplayedRun, AWholeRecordEndsWithItsRun) {
  const std::string scene = "sim/scenes/rigid.toml";
  ASSERT_EQ(record(scene, "").exit_code, 0);
  const ProgramResult result = run_program("run " + scene + " --bus replay:" + path("run.log"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("the log ended after step 60"));
}

TEST_F(ReplayedRun, TheRecordOfAReplayIsReplayedToo) {
  const std::string scene = "sim/scenes/rigid.toml";
  ASSERT_EQ(record(scene, "").exit_code, 0);
  const ProgramResult result =
      replay(scene, "can0=replay:" + path("run.log") + " --bus can1=replay:" + path("run.log") + ",can1",
             "--record " + path("again.log"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  ProgramResult again;
  // A busy machine makes the run miss deadlines, which hold the pose: tried again.
  for (int attempt = 0;
       attempt < 10 && again.output.find("missed deadlines           0 (") == std::string::npos; ++attempt)
    again = replay(scene, "replay:" + path("again.log"), "--realtime");
  EXPECT_THAT(again.output, HasSubstr("600 cycles")) << again.output;
  expect_the_same(1e-4);
}

/// The clock of a replay is that of its log, whenever it is replayed.
TEST_F(ReplayedRun, TimesAreThoseOfTheLog) {
  const std::string scene = "sim/scenes/rigid.toml";
  ASSERT_EQ(record(scene, "").exit_code, 0);
  const ProgramResult result = replay(scene, "replay:" + path("run.log"),
                                      "--record " + path("again.log") + " --report " + path("r.json"));
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const Trace first = read_trace(path("first.csv")), second = read_trace(path("second.csv"));
  ASSERT_THAT(first.names, testing::Contains("t_bus"));
  EXPECT_LT(difference(first, second, "t_bus"), 1e-4);
  const auto last_time = [](const std::string& log) {
    return std::stod(log.substr(log.rfind("\n(", log.size() - 2) + 2));
  };
  EXPECT_NEAR(last_time(read_file(path("again.log"))), last_time(read_file(path("run.log"))), 0.1);
  const nlohmann::json report = nlohmann::json::parse(read_file(path("r.json")));
  EXPECT_TRUE(report["motion_start_wall_s"].is_null());
  EXPECT_NEAR(report["motion_start_on_bus_s"].get<double>(), second.at(0, "t_bus"), 1e-4);
}

/// The record of a killed program ends anywhere.
TEST_F(ReplayedRun, ACutRecordIsReplayedUpToTheCut) {
  const std::string scene = "sim/scenes/grasper.toml";
  ASSERT_EQ(record(scene, "").exit_code, 0);
  const std::string log = read_file(path("run.log"));
  for (const double share : {0.4, 0.6, 0.8}) {
    std::size_t size = static_cast<std::size_t>(share * static_cast<double>(log.size()));
    if (log[size - 1] == '\n') size -= 3;
    const ProgramResult result = replay(scene, "replay:" + write("cut.log", log.substr(0, size)));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_THAT(result.output, HasSubstr("the log ended after step"));
    const Trace first = read_trace(path("first.csv")), second = read_trace(path("second.csv"));
    EXPECT_GT(second.rows.size(), 100u);
    EXPECT_LT(second.rows.size(), first.rows.size());
    EXPECT_LT(difference(first, second, ".x"), 1e-4);
  }
}

TEST_F(ReplayedRun, UnsuitableLogsAreReported) {
  const std::string scene = "sim/scenes/rigid.toml";
  const std::string log = write("other.log", "(1.000000) vcan7 080#\n(1.001000) vcan7 181#0000\n");
  ProgramResult result = replay(scene, "replay:" + log);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output,
              HasSubstr("holds no frame of the scene's buses: give the scene of the recorded run"));
  result = replay(scene, "can0=replay:" + log + ",can3 --bus can1=replay:" + log);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("holds no frame of can3"));
  result = replay(scene, "can0=replay:" + log + " --bus can1=pty");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("do not go together"));
  result = replay(scene, "replay:" + path("missing.log"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace godobject::test::test_replayed_run
