// A trace given as --motion replays the devices' samples: the second run equals the first.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "platform/scene/text/csv.h"
#include "tests/support/program.h"

namespace godobject::test::test_trace_as_motion {
namespace {

using testing::HasSubstr;
using testing::Not;

struct Case {
  std::string scene, bus;
};

constexpr double within = 1e-6;  // m: velocities of a replay are those of a curve through its samples

class TraceAsMotion : public ProgramTest, public testing::WithParamInterface<Case> {
 protected:
  /// Runs for two seconds and returns the trace.
  CsvTable run(const std::string& name, const std::string& options) {
    result_ = run_program("run sim/scenes/" + GetParam().scene + ".toml " + options +
                          " --duration 2 --trace " + path(name) + " --report " + path("report.json"));
    CsvResult trace = read_csv(path(name), "", std::size_t{1} << 30);
    EXPECT_TRUE(trace.table) << result_.output;
    return trace.table.value_or(CsvTable());
  }

  ProgramResult result_;
};

double apart(const CsvTable& a, const CsvTable& b, const std::string& column) {
  const std::size_t i = a.find(column).value(), k = b.find(column).value();
  double apart = 0;
  for (std::size_t row = 0; row < std::min(a.num_rows(), b.num_rows()); ++row)
    apart = std::max(apart, std::abs(a.at(row, i) - b.at(row, k)));
  return apart;
}

TEST_P(TraceAsMotion, DoesTheSameAgain) {
  const CsvTable first = run("a.csv", "--bus " + GetParam().bus);
  const CsvTable second = run("b.csv", "--bus direct --motion " + path("a.csv"));
  EXPECT_EQ(result_.exit_code, 0) << result_.output;
  EXPECT_THAT(result_.output, Not(HasSubstr("is not used")));
  EXPECT_THAT(result_.output, Not(HasSubstr("a.csv")));
  ASSERT_EQ(first.num_rows(), 2001u);
  ASSERT_EQ(second.num_rows(), 2001u);
  for (const std::string& column : first.columns()) {
    if (!column.ends_with(".x") && !column.ends_with(".y") && !column.ends_with(".z")) continue;
    // A simulated device: its joints are replayed, with those of the first sample also before it.
    const bool is_direct = GetParam().bus == "direct";
    const bool is_target = column.find(".target.") != std::string::npos;
    EXPECT_LE(apart(first, second, column), is_direct ? within : is_target ? 1e-5 : 1e-4) << column;
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, TraceAsMotion,
                         testing::Values(Case{"rigid", "direct"}, Case{"rigid", "sim"},
                                         Case{"wall", "direct"}, Case{"relative", "direct"},
                                         Case{"admittance", "direct"}, Case{"grasper", "direct"},
                                         Case{"scissors-imposed", "direct"}, Case{"grasp", "direct"},
                                         Case{"tracked", "direct"}),
                         [](const auto& test) {
                           std::string name = test.param.scene + "_" + test.param.bus;
                           std::ranges::replace(name, '-', '_');
                           return name;
                         });

class TraceOfOneRun : public ProgramTest {};

TEST_F(TraceOfOneRun, ReleaseAndTheClutchAreReplayed) {
  const std::string motion = write("m.csv", "t,tool.engaged,tool.clutch\n0,1,1\n0.5,1,0\n1,0,1\n1.5,1,1\n");
  const std::string run = "run sim/scenes/relative.toml --bus direct --duration 2 --report " + path("r.json");
  EXPECT_EQ(run_program(run + " --motion " + motion + " --trace " + path("a.csv")).exit_code, 0);
  EXPECT_EQ(run_program(run + " --motion " + path("a.csv") + " --trace " + path("b.csv")).exit_code, 0);
  const CsvTable a = read_csv(path("a.csv")).table.value(), b = read_csv(path("b.csv")).table.value();
  EXPECT_EQ(apart(a, b, "tool.engaged"), 0);
  EXPECT_EQ(apart(a, b, "tool.clutch"), 0);
  EXPECT_LE(apart(a, b, "tool.x"), 1e-6);
}

TEST_F(TraceOfOneRun, OfAKilledRunIsReplayedUpToTheCut) {
  const std::string scene = "run sim/scenes/rigid.toml --bus direct --trace " + path("a.csv");
  ASSERT_EQ(run_program(scene + " --duration 1").exit_code, 0);
  const std::string whole = read_file(path("a.csv"));
  const std::size_t end = whole.rfind('\n', whole.size() - 2);
  for (const std::size_t more : {std::size_t{1}, std::size_t{7}, std::size_t{60}}) {
    write("cut.csv", whole.substr(0, end + more));
    const ProgramResult result =
        run_program("run sim/scenes/rigid.toml --bus direct --motion " + path("cut.csv"));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_THAT(result.output, HasSubstr(" 999 cycles"));
  }
}

TEST_F(TraceOfOneRun, OfAnotherSceneIsRefused) {
  ASSERT_EQ(
      run_program("run sim/scenes/rigid.toml --bus direct --duration 0.1 --trace " + path("a.csv")).exit_code,
      0);
  const ProgramResult result =
      run_program("run sim/scenes/admittance.toml --bus direct --motion " + path("a.csv"));
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.output, HasSubstr("give the trace of this scene"));
}

TEST_F(TraceOfOneRun, AndReportHaveJointsDeviceAndTorques) {
  ASSERT_EQ(run_program("run sim/scenes/grasper.toml --bus sim --duration 2 --trace " + path("a.csv") +
                        " --report " + path("r.json"))
                .exit_code,
            0);
  const CsvTable trace = read_csv(path("a.csv")).table.value();
  const nlohmann::json report = nlohmann::json::parse(read_file(path("r.json")));
  const auto largest = [&](const std::string& column) {
    double most = 0;
    for (std::size_t row = 1; row < trace.num_rows(); ++row)
      most = std::max(most, std::abs(trace.at(row, trace.find(column).value())));
    return most;
  };
  ASSERT_FALSE(report["drives"].empty());
  for (const nlohmann::json& drive : report["drives"]) {
    const double peak = largest("drive." + drive["joint"].get<std::string>() + ".torque");
    EXPECT_EQ(drive["commanded_torque_Nm"]["peak"], peak);
    EXPECT_GT(peak, 0);
    EXPECT_GT(largest("device." + drive["joint"].get<std::string>() + ".q"), 0);
    EXPECT_LE(drive["commanded_torque_Nm"]["mean"], peak);
  }
  ASSERT_FALSE(report["joints"].empty());
  for (const nlohmann::json& joint : report["joints"]) {
    const std::size_t n = joint["coordinates"].size();
    EXPECT_GE(joint["force_N"]["peak"], joint["force_N"]["mean"]);
    for (std::size_t i = 0; i < n; ++i) {
      const nlohmann::json& q = joint["coordinates"][i];
      const std::string column =
          joint["name"].get<std::string>() + ".q" + (n > 1 ? std::to_string(i + 1) : "");
      EXPECT_EQ(std::max(std::abs(q["min"].get<double>()), std::abs(q["max"].get<double>())),
                largest(column));
    }
  }
  int moved = 0;
  for (const nlohmann::json& body : report["bodies"]) {
    moved += body["speed_m_per_s"]["peak"] > 0 ? 1 : 0;
    EXPECT_LE(body["speed_m_per_s"]["mean"], body["speed_m_per_s"]["peak"]);
  }
  EXPECT_GT(moved, 2);
}

}  // namespace
}  // namespace godobject::test::test_trace_as_motion
