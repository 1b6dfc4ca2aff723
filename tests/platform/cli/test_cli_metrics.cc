// godobject metrics on traces whose values are known, and on one of a run.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"

namespace godobject::test::test_cli_metrics {
namespace {

using testing::HasSubstr;
using testing::Not;

class CliMetrics : public ProgramTest {
 protected:
  static constexpr const char* pose = "1,2,3,1,0,0,0";

  /// Writes a trace of 2 s with rows every 5 ms. columns: after t. row: their numbers at t.
  std::string trace(const std::string& columns, const std::function<std::string(double)>& row) const {
    std::ostringstream text;
    text << "t," << columns << '\n';
    for (int i = 0; i <= 400; ++i) text << 0.005 * i << ',' << row(0.005 * i) << '\n';
    return write("trace.csv", text.str());
  }
  /// A tool along a line of 0.2 m, that displays 6 N and touches in the second half.
  std::string line() const {
    return trace(
        "tool.x,tool.y,tool.z,tool.qw,tool.qx,tool.qy,tool.qz,tool.feedback.fx,tool.feedback.fy,"
        "tool.feedback.fz,tool.target.x,tool.contact.fx,tool.contact.fy,tool.contact.fz,tool.engaged,tool."
        "clutch",
        [](double t) {
          const std::string contact = t > 0.9999 ? "3,0,-4" : "0,0,0",
                            clutch = t > 0.4 && t < 0.6 ? "0" : "1";
          return std::to_string(0.1 * t) + ",0,0,-1,0,0,0," + (t > 0.9999 ? "0,6,0" : "0,0,0") + ",0," +
                 contact + ",1," + clutch;
        });
  }
  nlohmann::json metrics(const std::string& arguments) const {
    const ProgramResult result = run_program("metrics " + arguments + " --json " + path("m.json"));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return nlohmann::json::parse(read_file(path("m.json")));
  }
};

TEST_F(CliMetrics, ALineHasItsMetrics) {
  const nlohmann::json json = metrics(line());
  EXPECT_EQ(json["rows"], 401);
  EXPECT_NEAR(json["time_s"], 2, 1e-9);
  EXPECT_TRUE(json["grabs"].is_null());
  ASSERT_EQ(json["subjects"].size(), 1u);
  const nlohmann::json& tool = json["subjects"][0];
  EXPECT_EQ(tool["name"], "tool");
  EXPECT_NEAR(tool["path_m"], 0.2, 1e-5);
  EXPECT_NEAR(tool["mean_speed_m_per_s"], 0.1, 1e-5);
  EXPECT_NEAR(tool["peak_speed_m_per_s"], 0.1, 1e-3);
  EXPECT_NEAR(tool["angle_rad"], 0, 1e-9);
  EXPECT_EQ(tool["idle_percent"], 0);
  EXPECT_EQ(tool["displayed_force"]["peak_N"], 6);
  EXPECT_NEAR(tool["displayed_force"]["mean_N"], 3, 0.02);
  EXPECT_NEAR(tool["displayed_force"]["above_s"], 1, 0.006);
  EXPECT_EQ(tool["contact_force"]["peak_N"], 5);
  EXPECT_EQ(tool["contacts"]["begun"], 1);
  EXPECT_NEAR(tool["contacts"]["time_s"], 1, 1e-9);
  EXPECT_EQ(tool["clutch"]["releases"], 1);
  EXPECT_EQ(tool["clutch"]["engagements"], 2);
}

TEST_F(CliMetrics, OptionsSelectTheTimeAndTheThresholds) {
  const std::string file = line();
  const nlohmann::json part = metrics(file + " --from 1.0 --to 1.5");
  EXPECT_EQ(part["rows"], 101);
  EXPECT_NEAR(part["subjects"][0]["path_m"], 0.05, 1e-5);
  EXPECT_NEAR(part["subjects"][0]["displayed_force"]["mean_N"], 6, 1e-9);
  const nlohmann::json all = metrics(file + " --idle-below 0.2 --force-above 6");
  EXPECT_EQ(all["subjects"][0]["idle_percent"], 100);
  EXPECT_TRUE(all["subjects"][0]["log_dimensionless_jerk"].is_null());
  EXPECT_EQ(all["subjects"][0]["displayed_force"]["above_s"], 0);
}

TEST_F(CliMetrics, TheTableHasUnits) {
  const ProgramResult result = run_program("metrics " + line());
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.output, testing::ContainsRegex("path, m +0.2\n"));
  EXPECT_THAT(result.output, testing::ContainsRegex("mean speed, mm/s +100\n"));
  EXPECT_THAT(result.output, testing::ContainsRegex("contacts begun +1\n"));
  EXPECT_THAT(result.output, Not(HasSubstr("grabs")));
}

TEST_F(CliMetrics, AGrippingDeviceHasItsOwnPathForceAndGrabs) {
  const std::string file = trace(
      "a.x,a.y,a.z,a.qw,a.qx,a.qy,a.qz,a.vx,held,hand.fx,hand.fy,hand.fz,grip.engaged,grip.device.x,"
      "grip.device.y,grip.device.z,grip.device.qw,grip.device.qx,grip.device.qy,grip.device.qz",
      [](double t) {
        const char* const held = t < 0.5 ? "-1" : t < 1 ? "0" : t < 1.2 ? "1" : t < 1.5 ? "-1" : "1";
        return std::string(pose) + ",0," + held + ",0,0,1,1,0,0," + std::to_string(0.05 * t) + ",1,0,0,0";
      });
  const nlohmann::json json = metrics(file);
  EXPECT_EQ(json["grabs"], 3);
  ASSERT_EQ(json["subjects"].size(), 1u);
  EXPECT_EQ(json["subjects"][0]["name"], "grip.device");
  EXPECT_NEAR(json["subjects"][0]["path_m"], 0.1, 1e-5);
  EXPECT_EQ(json["subjects"][0]["displayed_force"]["peak_N"], 1);
  EXPECT_EQ(json["subjects"][0]["clutch"]["engagements"], 1);
}

TEST_F(CliMetrics, ThePictureShowsWhenItGripsReleasesAndRests) {
  const std::string file = trace(
      "a.x,a.y,a.z,a.qw,a.qx,a.qy,a.qz,a.vx,held,hand.fx,hand.fy,hand.fz,grip.engaged,grip.device.x,"
      "grip.device.y,grip.device.z,grip.device.qw,grip.device.qx,grip.device.qy,grip.device.qz",
      [](double t) {
        const char *const held = t > 0.5 && t < 1 ? "0" : "-1", *const engaged =
                                                                    t > 0.2 && t < 0.3 ? "0" : "1";
        return std::string(pose) + ",0," + held + ",0,0,1," + engaged + ",0,0," +
               std::to_string(0.05 * std::min(t, 1.2)) + ",1,0,0,0";
      });
  const std::string picture = path("m.svg");
  const ProgramResult missing = run_program("metrics " + file + " --picture " + picture, "PATH=/none ");
  EXPECT_EQ(missing.exit_code, 3);
  EXPECT_THAT(missing.output, HasSubstr("gnuplot draws it and is not installed: install it"));
  EXPECT_THAT(missing.output, HasSubstr("path, m"));
  EXPECT_TRUE(read_file(picture).empty());
  const ProgramResult other = run_program("metrics " + file + " --picture " + path("m.pdf"));
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.output, HasSubstr("must end in .svg or .png"));
  if (std::system("command -v gnuplot > /dev/null") != 0) GTEST_SKIP() << "gnuplot is not installed";

  const ProgramResult result = run_program("metrics " + file + " --picture " + picture);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const std::string svg = read_file(picture);
  for (const char* text :
       {"grip.device", "speed, mm/s", "force, N", "path from above", "idle", "released", "held"})
    EXPECT_THAT(svg, HasSubstr(text));
  // Each colour is in the key, and in both panels once.
  for (const char* colour : {"rgb(232, 232, 232)", "rgb(255, 224, 176)", "rgb(207, 232, 207)"}) {
    int polygons = 0;
    const std::string polygon = std::string("<polygon fill = '") + colour;
    for (std::size_t at = svg.find(polygon); at != std::string::npos; at = svg.find(polygon, at + 1))
      ++polygons;
    EXPECT_EQ(polygons, 3) << colour;
  }
  ASSERT_EQ(run_program("metrics " + line() + " --picture " + path("m.png")).exit_code, 0);
  EXPECT_EQ(read_file(path("m.png")).substr(1, 3), "PNG");
}

TEST_F(CliMetrics, ATraceOfARunHasItsBodies) {
  const std::string file = path("run.csv");
  ASSERT_EQ(run_program("run sim/scenes/relative.toml --duration 1 --quiet --trace " + file).exit_code, 0);
  const nlohmann::json json = metrics(file);
  ASSERT_EQ(json["subjects"].size(), 2u);
  EXPECT_EQ(json["subjects"][0]["name"], "tool");
  EXPECT_EQ(json["subjects"][1]["name"], "tool.device");
  for (const nlohmann::json& subject : json["subjects"]) {
    EXPECT_GT(subject["path_m"], 0.01);
    EXPECT_LT(subject["log_dimensionless_jerk"], -5);
    EXPECT_NEAR(subject["path_m"], subject["mean_speed_m_per_s"], 1e-9);  // in 1 s
  }
  const nlohmann::json fewer = [&] {
    EXPECT_EQ(
        run_program("run sim/scenes/relative.toml --duration 1 --quiet --trace-every 10 --trace " + file)
            .exit_code,
        0);
    return metrics(file);
  }();
  EXPECT_EQ(fewer["rows"], 101);
  EXPECT_NEAR(fewer["subjects"][1]["path_m"], json["subjects"][1]["path_m"], 1e-4);
}

TEST_F(CliMetrics, ALogOfBusesHasTheMetricsOfTheTraceOfItsReplay) {
  const std::string scene = "sim/scenes/rigid.toml", log = path("bus.log"), trace = path("again.csv");
  ASSERT_EQ(run_program("run " + scene + " --duration 1 --quiet --record " + log + " 2> /dev/null").exit_code,
            0);
  run_program("run " + scene + " --bus replay:" + log + " --duration 0.9 --quiet --trace " + trace);
  const nlohmann::json of_trace = metrics(trace + " --from 0.01 --to 0.9")["subjects"],
                       of_log = metrics(log + " --scene " + scene + " --from 0.01 --to 0.9")["subjects"];
  EXPECT_GT(of_log[0]["path_m"], 0.05);
  EXPECT_EQ(of_trace, of_log);
  const ProgramResult other = run_program("metrics " + log + " --scene sim/scenes/admittance.toml");
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_THAT(other.output, HasSubstr("describes no buses"));
  EXPECT_EQ(run_program("metrics " + log + " --scene /no/such.toml").exit_code, 2);
}

TEST_F(CliMetrics, WrongFilesAreNamedWithTheirRemedy) {
  const std::string columns = "a.x,a.y,a.z,a.qw,a.qx,a.qy,a.qz,a.vx";
  const auto of = [&](const std::string& name, const std::string& text) { return write(name, text); };
  const std::string good = std::string(pose) + ",0\n";
  const struct {
    std::string file;
    const char* message;
  } cases[] = {
      {"/no/such.csv", "cannot be read"},
      {of("log", "(1.0) can0 080#\n"),
       "is no trace, whose first column is t; a log of buses requires --scene"},
      {of("other.csv", "t,u\n0,1\n"), "has no columns of a body"},
      {of("short.csv", "t," + columns + "\n0," + good + "0.1," + good), "2 rows over 0.1 s; metrics require"},
      {of("nan.csv", "t," + columns + "\n0,nan,2,3,1,0,0,0,0\n"), ":2: a number of a is not finite"},
      {of("zero.csv", "t," + columns + "\n0,1,2,3,0,0,0,0,0\n"), "its quaternion is 0"},
      {of("back.csv", "t," + columns + "\n1," + good + "0," + good), ":3: its time is not after"},
      {of("cut.csv", "t," + columns + "\n0,1\n1," + good), ":2: not the 9 numbers of a row"},
      {of("none.csv", "t," + columns + "\n"), "0 rows over 0 s"}};
  for (const auto& c : cases) {
    const ProgramResult result = run_program("metrics " + c.file);
    EXPECT_EQ(result.exit_code, 2) << c.file << result.output;
    EXPECT_THAT(result.output, HasSubstr(c.message));
  }
  const ProgramResult result = run_program("metrics " + line() + " --json " + path("none/m.json"));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.output, HasSubstr("could not be written"));
}

}  // namespace
}  // namespace godobject::test::test_cli_metrics
