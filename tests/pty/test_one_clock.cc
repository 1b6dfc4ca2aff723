// Record, trace and report of a run on real buses agree in time to 0.1 ms.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <sstream>

#include <nlohmann/json.hpp>

#include "platform/scene/text/csv.h"
#include "tests/support/background_program.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/program.h"

namespace godobject::test::test_one_clock {
namespace {

class OneClock : public ProgramTest {};

/// s since 1970.
double time_of_day() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

TEST_F(OneClock, OfRecordTraceAndReport) {
  const std::string scene = write("scene.toml", patient_toml());
  BackgroundProgram far({"simulate", scene, "--realtime", "--bus", "can0=pty", "--bus", "can1=pty"});
  std::string arguments = "run " + scene + " --duration 2 --quiet --trace " + path("t.csv") + " --record " +
                          path("r.log") + " --report " + path("r.json");
  for (std::string line = far.line(); line != "ready" && !line.empty(); line = far.line())
    arguments += " --bus " + line.substr(4, 4) + "=slcan:" + line.substr(line.find(": ") + 2);
  const double begin = time_of_day();
  const ProgramResult result = run_program(arguments);
  const double end = time_of_day();

  const double start_s = nlohmann::json::parse(read_file(path("r.json")))["motion_start_wall_s"];
  EXPECT_GT(start_s, begin) << result.output;
  EXPECT_LT(start_s, end - 2);
  const CsvTable trace = read_csv(path("t.csv")).table.value();
  const std::size_t t_bus = trace.find("t_bus").value();
  EXPECT_NEAR(trace.at(0, t_bus), start_s, 1e-6);
  std::vector<double> syncs;
  std::istringstream log(read_file(path("r.log")));
  for (std::string line; std::getline(log, line);)
    if (line.find(" can0 080#") != std::string::npos) syncs.push_back(std::stod(line.substr(1)));
  std::vector<double> apart;
  for (std::size_t row = 1; row < trace.num_rows(); ++row) {
    const auto sync = std::ranges::lower_bound(syncs, trace.at(row, t_bus) - 1e-6);
    if (sync != syncs.end()) apart.push_back(*sync - trace.at(row, t_bus));
  }
  ASSERT_GT(apart.size(), 300u);
  std::ranges::sort(apart);
  // The shortest has the difference of the clocks, and least of the delay before a frame is sent.
  std::printf("SYNC in the record after its period in the trace: median %.1f us, shortest %.1f us\n",
              1e6 * apart[apart.size() / 2], 1e6 * apart.front());
  EXPECT_LT(apart.front(), 1e-4);
}

}  // namespace
}  // namespace godobject::test::test_one_clock
