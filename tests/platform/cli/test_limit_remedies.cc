// Each limit of a run: a scene that activates it, and the change by its remedy, which deactivates it.
#include <gmock/gmock.h>

#include <atomic>
#include <cctype>
#include <cmath>
#include <set>

#include <nlohmann/json.hpp>

#include "platform/cli/report/report.h"
#include "platform/cli/run/loop.h"
#include "platform/scene/toml.h"
#include "platform/simulated/session.h"
#include "tests/platform/cli/limit_scenes.h"
#include "tests/support/one_drive.h"

namespace godobject::test::test_limit_remedies {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

/// Returns the name of the test of a limit: drive_torque is met by DriveTorque.
std::string test_of(std::string_view limit) {
  std::string name;
  bool begins = true;
  for (const char c : limit) {
    if (c != '_') name += begins ? static_cast<char>(std::toupper(c)) : c;
    begins = c == '_';
  }
  return name;
}

/// Each test is of the limit whose name it has: see RunLimits.EachIsProvoked.
class LimitRemedies : public ProgramTest {
 protected:
  static const RunLimit& limit() {
    const std::string test = testing::UnitTest::GetInstance()->current_test_info()->name();
    for (const RunLimit& limit : run_limits)
      if (test_of(limit.name) == test) return limit;
    ADD_FAILURE() << "no limit has the name of this test";
    return run_limits[0];
  }

  /// Percent of the cycles in which the limit was active; warnings hold its remedy if that is more than 5.
  double percent(const std::string& scene, const std::string& options = "", int exit_code = 0) {
    const ProgramResult run = run_program("run " + write("scene.toml", scene) + " --fast --report " +
                                          path("r.json") + " " + options);
    EXPECT_EQ(run.exit_code, exit_code) << run.output;
    const nlohmann::json report = nlohmann::json::parse(read_file(path("r.json")), nullptr, false);
    if (!report.is_object()) return -1;
    const double share = report["limits_percent"].value(limit().name, 0.0);
    const std::string line = "limit " + std::string(limit().name) + " in ";
    if (share > 5 && !limit().remedy.empty())
      EXPECT_THAT(run.output, AllOf(HasSubstr(line), HasSubstr(std::string(limit().remedy))));
    else EXPECT_THAT(run.output, testing::Not(HasSubstr(line)));
    return share;
  }

  void expect_remedy(const std::string& met, const std::string& remedied, const std::string& options = "",
                     int exit_code_met = 0) {
    EXPECT_GT(percent(met, options, exit_code_met), 5) << limit().name;
    EXPECT_LT(percent(remedied, options), 5) << limit().name;
  }
};

TEST_F(LimitRemedies, Force) {
  const std::string met = desk("force = 4e-3\n");
  expect_remedy(met, replaced(met, "force = 4e-3", "force = 1"));
  expect_remedy(met, replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
}

TEST_F(LimitRemedies, Torque) {
  const std::string met = turned("torque = 2e-4\n");
  expect_remedy(met, replaced(met, "torque = 2e-4", "torque = 0.2"), "--bus direct");
  expect_remedy(met,
                replaced(met, "rotational_stiffness = 0.1\nrotational_damping = 1e-3",
                         "rotational_stiffness = 1e-4\nrotational_damping = 1e-6"),
                "--bus direct");
}

TEST_F(LimitRemedies, ForceRate) {
  const std::string met = desk("force_rate = 0.25\n");
  expect_remedy(met, replaced(met, "force_rate = 0.25", "force_rate = 100"));
  expect_remedy(met, replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
}

TEST_F(LimitRemedies, TorqueRate) {
  const std::string met = turned("torque_rate = 5e-3\n");
  expect_remedy(met, replaced(met, "torque_rate = 5e-3", "torque_rate = 10"), "--bus direct");
  expect_remedy(met,
                replaced(met, "rotational_stiffness = 0.1\nrotational_damping = 1e-3",
                         "rotational_stiffness = 1e-4\nrotational_damping = 1e-6"),
                "--bus direct");
}

TEST_F(LimitRemedies, Held) {
  const std::string fault =
      "[[fault]]\nverb = \"drop\"\nbus = \"can0\"\nnode_id = 1\nat = 1.0\nduration = 4.0\nvalue = 0.1\n";
  expect_remedy(desk() + fault, desk());
}

TEST_F(LimitRemedies, FirstOrder) {
  expect_remedy(spun("1e-3"), spun("2e-4"), "--bus direct");
  expect_remedy(small_net("5"), small_net("12"), "--bus direct");
}

TEST_F(LimitRemedies, DriveTorque) {
  const std::string met = replaced_everywhere(desk(), "torque_max_Nm = 0.2", "torque_max_Nm = 8e-5");
  expect_remedy(met, desk());
  expect_remedy(met, replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
  expect_remedy(met, replaced(met, "[device.limits]\n", "[device.limits]\nforce = 2e-3\n"));
}

TEST_F(LimitRemedies, DriveTorqueRate) {
  const std::string met =
      replaced_everywhere(desk(), "torque_rate_Nm_per_s = 100", "torque_rate_Nm_per_s = 4e-3");
  expect_remedy(met, desk());
  expect_remedy(met, replaced(met, "stiffness = 60\ndamping = 0.6", "stiffness = 0.6\ndamping = 0.006"));
}

TEST_F(LimitRemedies, Ramp) {
  EXPECT_GT(percent(desk()), 5);  // by every engagement, and without a remedy: it is no fault
}

/// Returns the percentage of held cycles of a run. Another program takes the processor for `away` seconds ten
/// times a second.
double percent_on_hold(double step, double away) {
  LoadResult loaded = load_scene(GODOBJECT_SOURCE_DIR "/sim/scenes/rigid.toml");
  loaded.scene->step = step;
  Session::Made made = make_session(*loaded.scene, Motion(*loaded.scene), BusChoice::sim);
  const std::atomic<bool> stop = false;
  RunCycle cycle(*made.session, RunPlan{.num_cycles = 100'000}, stop);
  CycleRecord record = made.session->at_start();
  made.session->start(5);
  const auto period = [&](const Wake& wake) {
    cycle.watch(wake);
    static_cast<void>(cycle.run(record));
  };
  while (made.session->phase() == RunPhase::booting) period({});
  const int between = static_cast<int>(std::lround(0.1 / step)), missed = static_cast<int>(away / step);
  for (int n = 1; n <= 20 * between; ++n)
    period({.skipped = n % between == 0 ? static_cast<std::uint64_t>(missed) : 0u});
  for (std::size_t i = 0; i < run_limits.size(); ++i)
    if (run_limits[i].name == "deadlines") return limit_percent(cycle.statistics(), i);
  return -1;
}

TEST_F(LimitRemedies, Deadlines) {
  EXPECT_THAT(std::string(limit().remedy),
              HasSubstr("use a longer step, a faster machine or a real-time kernel"));
  EXPECT_GT(percent_on_hold(1e-3, 6e-3), 5);
  EXPECT_LT(percent_on_hold(2e-3, 6e-3), 5);  // a longer step
  EXPECT_LT(percent_on_hold(1e-3, 3e-3), 5);  // a machine or a kernel that is away for less
}

TEST_F(LimitRemedies, ContactResidual) {
  const std::string met = heap(8, "1e-3", 1e5);
  expect_remedy(met, heap(8, "1e-4", 1e5));
  expect_remedy(met, heap(8, "1e-3", 1e3));
  expect_remedy(met, heap(2, "1e-3", 1e5));
}

TEST_F(LimitRemedies, NewtonCap) {
  const std::string met = heap(8, "5e-3", 1e8);
  expect_remedy(met, heap(8, "2e-4", 1e8));
  expect_remedy(met, heap(8, "5e-3", 1e3));
}

TEST_F(LimitRemedies, Substeps) {
  const std::string met = chain("1e-2", 1000);
  expect_remedy(met, chain("1e-3", 1000));
  expect_remedy(met, chain("1e-2", 10));
}

TEST_F(LimitRemedies, NetCap) { expect_remedy(small_net("5"), small_net("12"), "--bus direct"); }

/// Returns the percentage of cycles in which a drive limits its torque. bears: 6072h, N m. commanded: largest
/// torque that the host may command, N m.
double percent_limited_by_drive(double bears, double commanded) {
  DriveParams drive = drive_of(DriveProtocol::cia402);
  drive.torque_max_Nm = commanded;
  // 6072h is in thousandths of the rated torque, which is torque_max_Nm here
  OneDrive device(drive, cia402_with({.max_torque_per_mille =
                                          static_cast<std::int16_t>(std::lround(1e3 * bears / commanded))}));
  device.boot();
  EXPECT_TRUE(device.rig->arm()) << device.rig->fault_text();
  int limited = 0;
  constexpr int cycles = 2000;
  for (int k = 0; k < cycles; ++k) {
    device.F.f = Vec3(0, 0.8 * std::sin(0.02 * k), 0);  // 0.1 m from the joint: up to 0.08 N m
    device.cycle();
    CycleRecord record;
    record.drives = device.report;
    for (const RunLimit& limit : run_limits)
      limited += limit.name == "drive_internal_limit" && limit.is_active(record) ? 1 : 0;
  }
  EXPECT_EQ(device.rig->faults(), RigFault::none) << device.rig->fault_text();
  return 100.0 * limited / cycles;
}

TEST_F(LimitRemedies, DriveInternalLimit) {
  EXPECT_THAT(std::string(limit().remedy), HasSubstr("compare the drive's own limits with torque_max_Nm"));
  EXPECT_GT(percent_limited_by_drive(0.03, 0.1), 5);
  EXPECT_LT(percent_limited_by_drive(0.1, 0.1), 5);    // as much as torque_max_Nm
  EXPECT_LT(percent_limited_by_drive(0.03, 0.03), 5);  // torque_max_Nm is as low
}

TEST_F(LimitRemedies, DriveCommandNotSent) {
  const std::string fault =
      "[[fault]]\nverb = \"duplicate\"\nbus = \"can1\"\nvalue = 1.0\nat = 1.0\nduration = 4.0\n";
  const std::string crowded =
      replaced(desk(), "[[bus]]\nname = \"can1\"\n", "[[bus]]\nname = \"can1\"\nbit_rate = 770000\n");
  // a longer step; the drives' queue was refused so often in the first run that it is a fault besides
  expect_remedy(crowded + fault,
                replaced(desk(), "duration = 6.0\n", "duration = 6.0\nstep = 2e-3\n") + fault, "", 1);
  const ProgramResult check = run_program("check " + write("crowded.toml", crowded));
  EXPECT_THAT(check.output, HasSubstr("can1")) << "its load is printed, as the remedy promises";
  EXPECT_THAT(check.output, HasSubstr("99.5 %"));
}

TEST(RunLimits, EachIsProvoked) {
  std::set<std::string> tests, limits;
  const testing::UnitTest& all = *testing::UnitTest::GetInstance();
  for (int i = 0; i < all.total_test_suite_count(); ++i) {
    const testing::TestSuite& suite = *all.GetTestSuite(i);
    if (std::string(suite.name()) != "LimitRemedies") continue;
    for (int k = 0; k < suite.total_test_count(); ++k) tests.insert(suite.GetTestInfo(k)->name());
  }
  for (const RunLimit& limit : run_limits) limits.insert(test_of(limit.name));
  EXPECT_EQ(tests, limits) << "each limit has a test that meets it and applies its remedy";
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
    timing.cycle_ns.add(i % 400 == 0 ? 1'180'000 : 300'000);
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
