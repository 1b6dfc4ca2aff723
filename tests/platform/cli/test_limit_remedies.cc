// Each limit of a run: a scene that activates it, and the change by its remedy, which deactivates it.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "platform/cli/report/warnings.h"
#include "tests/support/desk_scene.h"
#include "tests/support/program.h"

namespace godobject::test::test_limit_remedies {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// Returns `text` with its first `from` replaced; it must exist.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

std::string replaced_everywhere(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

/// Scene of a tool on three slides with a feedback that its device can display. limits: lines of
/// [device.limits].
std::string desk(const std::string& limits = "") {
  const std::string scene = desk_scene("stiffness = 60\ndamping = 0.6\n");
  return replaced(scene, "[device.plant]\n", "[device.limits]\n" + limits + "[device.plant]\n");
}

/// Scene of a tool that a tracked hand turns to and fro. limits: lines of [device.limits].
std::string turned(const std::string& limits) {
  return "[scene]\nname = \"turned\"\nduration = 4.0\n"
         "[[body]]\nname = \"tool\"\nmass = 0.1\ninertia = [1e-4, 1e-4, 1e-4]\n"
         "[body.coupling]\nstiffness = 500\nrotational_stiffness = 0.5\n"
         "[body.feedback]\nstiffness = 60\nrotational_stiffness = 0.1\nrotational_damping = 1e-3\n"
         "[device]\nname = \"hand\"\n[device.limits]\n" +
         limits + "[motion]\nangle_amplitude = [0.8, 0.0, 0.0]\nangle_frequency_hz = [1.0, 1.0, 1.0]\n";
}

/// Scene of a free body at 400 rad/s: TR-BDF2 takes implicit Euler stages if a step turns it by more than
/// 0.25 rad.
std::string spun(const std::string& step) {
  return "[scene]\nname = \"spun\"\nduration = 2.0\nintegrator = \"tr-bdf2\"\nstep = " + step +
         "\n[[body]]\nname = \"tool\"\nmass = 0.1\ninertia = [1e-4, 2e-4, 3e-4]\nangular_velocity = [400.0, "
         "0.0, 0.0]\n";
}

class LimitRemedies : public ProgramTest {
 protected:
  /// Returns the percentage of cycles with the limit active; warnings contain its line above 5 %.
  double percent(const std::string& limit, const std::string& scene, const std::string& options = "") {
    const ProgramResult run = run_program("run " + write("scene.toml", scene) + " --fast --report " +
                                          path("r.json") + " " + options);
    EXPECT_EQ(run.exit_code, 0) << run.output;
    const nlohmann::json report = nlohmann::json::parse(read_file(path("r.json")), nullptr, false);
    if (!report.is_object()) return -1;
    const double share = report["limits_percent"].value(limit, 0.0);
    const std::string line = "limit " + limit + " in ";
    if (share > 5) EXPECT_THAT(run.output, HasSubstr(line));
    else EXPECT_THAT(run.output, testing::Not(HasSubstr(line)));
    return share;
  }

  void expect_remedy(const std::string& limit, const std::string& met, const std::string& remedied,
                     const std::string& options = "") {
    EXPECT_GT(percent(limit, met, options), 5) << limit;
    EXPECT_LT(percent(limit, remedied, options), 5) << limit;
  }
};

TEST_F(LimitRemedies, Force) {
  const std::string met = desk("force = 4e-3\n");
  expect_remedy("force", met, replaced(met, "force = 4e-3", "force = 1"));
  expect_remedy("force", met,
                replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
}

TEST_F(LimitRemedies, Torque) {
  const std::string met = turned("torque = 2e-4\n");
  expect_remedy("torque", met, replaced(met, "torque = 2e-4", "torque = 0.2"), "--bus direct");
  expect_remedy("torque", met,
                replaced(met, "rotational_stiffness = 0.1\nrotational_damping = 1e-3",
                         "rotational_stiffness = 1e-4\nrotational_damping = 1e-6"),
                "--bus direct");
}

TEST_F(LimitRemedies, ForceRate) {
  const std::string met = desk("force_rate = 0.25\n");
  expect_remedy("force_rate", met, replaced(met, "force_rate = 0.25", "force_rate = 100"));
  expect_remedy("force_rate", met,
                replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
}

TEST_F(LimitRemedies, TorqueRate) {
  const std::string met = turned("torque_rate = 5e-3\n");
  expect_remedy("torque_rate", met, replaced(met, "torque_rate = 5e-3", "torque_rate = 10"), "--bus direct");
  expect_remedy("torque_rate", met,
                replaced(met, "rotational_stiffness = 0.1\nrotational_damping = 1e-3",
                         "rotational_stiffness = 1e-4\nrotational_damping = 1e-6"),
                "--bus direct");
}

TEST_F(LimitRemedies, SamplesThatAreMissing) {
  const std::string fault =
      "[[fault]]\nverb = \"drop\"\nbus = \"can0\"\nnode_id = 1\nat = 1.0\nduration = 4.0\nvalue = 0.3\n";
  expect_remedy("held", desk() + fault, desk());
}

TEST_F(LimitRemedies, FirstOrder) {
  expect_remedy("first_order", spun("1e-3"), spun("2e-4"), "--bus direct");
}

TEST_F(LimitRemedies, TorqueOfDrives) {
  const std::string met = replaced_everywhere(desk(), "torque_max_Nm = 0.2", "torque_max_Nm = 8e-5");
  expect_remedy("drive_torque", met, desk());
  expect_remedy("drive_torque", met,
                replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
  expect_remedy("drive_torque", met, replaced(met, "[device.limits]\n", "[device.limits]\nforce = 2e-3\n"));
}

TEST_F(LimitRemedies, TorqueRateOfDrives) {
  const std::string met =
      replaced_everywhere(desk(), "torque_rate_Nm_per_s = 100", "torque_rate_Nm_per_s = 4e-3");
  expect_remedy("drive_torque_rate", met, desk());
  expect_remedy("drive_torque_rate", met,
                replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
}

TEST(RunLimits, AHoldByDeadlinesIsNotOneOfMissingSamples) {
  const auto names = [](const CycleRecord& record) {
    std::string active;
    for (const RunLimit& limit : run_limits)
      if (limit.is_active(record)) active += std::string(limit.name) + " ";
    return active;
  };
  CycleRecord record;
  EXPECT_EQ(names(record), "");
  record.limited = Limited::held;
  EXPECT_EQ(names(record), "held ");
  record.on_hold = true;
  EXPECT_EQ(names(record), "deadlines ");
}

TEST(RunLimits, EachIsActiveAloneAndInItsBit) {
  std::vector<CycleRecord> records(run_limits.size());
  for (unsigned bit = 0; bit < 5; ++bit) records[bit].limited = Limited(1u << bit);
  records[5].limited = Limited::held;
  records[6].on_hold = true;
  records[7].limited = Limited::first_order;
  for (unsigned i = 8; i < 12; ++i) records[i].limited = Limited(1u << (i - 1));
  records[12].drives.torque_limited = records[13].drives.rate_limited = 2;
  records[14].drives.drive_limited = records[15].drives.not_sent = 4;
  for (std::size_t i = 0; i < records.size(); ++i)
    EXPECT_EQ(active_limits(records[i]), 1u << i) << run_limits[i].name;
}

TEST(RunWarnings, ASceneThatIsTooSlowIsNamed) {
  CyclicStatistics timing;
  Histogram step_ns;
  for (int i = 0; i < 10'000; ++i) {
    timing.compute_ns.add(i % 400 == 0 ? 1'180'000 : 300'000);
    step_ns.add(i % 400 == 0 ? 1'100'000 : 250'000);
  }
  EXPECT_THAT(slow_scene_warning(timing, step_ns, 1e-3),
              testing::AllOf(HasSubstr("the period is 1 ms (the step alone: 1.1"),
                             HasSubstr("the scene is too slow")));
  EXPECT_THAT(slow_scene_warning(timing, Histogram(), 1e-3), HasSubstr("other programs"));
  EXPECT_THAT(slow_scene_warning(timing, step_ns, 2e-3), IsEmpty());
}

}  // namespace
}  // namespace godobject::test::test_limit_remedies
