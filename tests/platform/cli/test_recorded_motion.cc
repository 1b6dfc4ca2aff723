// A recorded operation (80 s of teleoperation) through the whole chain: encoders on simulated wires, the
// core, the drives.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/program.h"
#include "tests/support/shared_data.h"

namespace godobject::test::test_recorded_motion {
namespace {

class RecordedMotion : public ProgramTest {
 protected:
#ifdef NDEBUG
  static constexpr const char* duration = "";  // all of it
  static constexpr int num_cycles = 79'000;
#else
  static constexpr const char* duration = " --duration 5";
  static constexpr int num_cycles = 5'000;
#endif

  nlohmann::json run(const std::string& scene, const std::string& bus, const std::string& motion) const {
    const std::string report = path(bus + ".json");
    const ProgramResult result = run_program("run sim/scenes/" + scene + " --fast --bus " + bus + duration +
                                             " --motion " + motion + " --report " + report);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return nlohmann::json::parse(read_file(report));
  }
};

TEST_F(RecordedMotion, RunsThroughTheWholeChainWithoutFault) {
  const auto script = shared_file("tools/desk_to_motion.py");
  const auto data = shared_file("data/desk_taurus/S5_T2_left_kinematics.txt");
  if (script.empty() || data.empty()) GTEST_SKIP() << "the recording is not here (shared/data/desk_taurus)";
  const std::string motion = path("motion.csv");
  ASSERT_EQ(
      std::system(("python3 '" + script.string() + "' pose '" + data.string() + "' > " + motion).c_str()), 0);

  const nlohmann::json sim = run("rigid.toml", "sim", motion);
  const nlohmann::json direct = run("rigid.toml", "direct", motion);
  EXPECT_TRUE(sim["faults"].empty());
  EXPECT_FALSE(sim["limits"].contains("held"));
  EXPECT_GE(sim["cycles"].get<int>(), num_cycles);
  EXPECT_EQ(sim["answers"]["incomplete_syncs"], 0);
  // A count is 2.4e-5 rad; 0.36 m of arm.
  EXPECT_LT(sim["sensing"]["max_m"], 2e-5);
  EXPECT_LT(sim["sensing"]["max_rad"], 1e-4);
  EXPECT_LT(sim["following"]["rms_m"], 1e-4);
  // Encoders disturb the tool less than the coupling does.
  EXPECT_LT(sim["encoders"]["rms_m"].get<double>(), 0.5 * sim["exact_following"]["rms_m"].get<double>());
  std::printf(
      "following error, rms: %.3g m %.3g rad on the bus, %.3g m %.3g rad direct; difference %.2g m %.2g rad\n"
      "the encoders move the tool by %.2g m %.2g rad\n",
      sim["following"]["rms_m"].get<double>(), sim["following"]["rms_rad"].get<double>(),
      direct["following"]["rms_m"].get<double>(), direct["following"]["rms_rad"].get<double>(),
      sim["following"]["rms_m"].get<double>() - direct["following"]["rms_m"].get<double>(),
      sim["following"]["rms_rad"].get<double>() - direct["following"]["rms_rad"].get<double>(),
      sim["encoders"]["rms_m"].get<double>(), sim["encoders"]["rms_rad"].get<double>());
}

/// Parameters: recording, bus.
class RecordedGrasper : public RecordedMotion,
                        public testing::WithParamInterface<std::tuple<const char*, const char*>> {};

TEST_P(RecordedGrasper, ArticulatedToolsFollowWithoutFault) {
  const auto& [recording, bus] = GetParam();
  const auto script = shared_file("tools/desk_to_motion.py");
  const auto data = shared_file(std::string("data/desk_taurus/S5_T2_") + recording + "_kinematics.txt");
  if (script.empty() || data.empty()) GTEST_SKIP() << "the recording is not here (shared/data/desk_taurus)";
  const std::string motion = path("motion.csv");
  ASSERT_EQ(
      std::system(("python3 '" + script.string() + "' grasper '" + data.string() + "' > " + motion).c_str()),
      0);
  std::vector<const char*> scenes{"grasper.toml"};
  if (std::string(bus) == "direct") scenes.push_back("scissors-imposed.toml");
  for (const char* scene : scenes) {
    const nlohmann::json report = run(scene, bus, motion);
    EXPECT_TRUE(report["faults"].empty()) << scene;
    EXPECT_FALSE(report["limits"].contains("held")) << scene;
    EXPECT_GE(report["cycles"].get<int>(), num_cycles) << scene;
    EXPECT_LT(report["following"]["rms_m"], 1e-4) << scene;
    EXPECT_LT(report["following"]["max_m"], 1e-3) << scene;
    std::printf("%s, %s arm, %s: following rms %.2g m, max %.2g m\n", scene, recording, bus,
                report["following"]["rms_m"].get<double>(), report["following"]["max_m"].get<double>());
  }
}

INSTANTIATE_TEST_SUITE_P(Desk, RecordedGrasper,
                         testing::Combine(testing::Values("left", "right"), testing::Values("direct", "sim")),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param)) + "_" + std::get<1>(test.param);
                         });

}  // namespace
}  // namespace godobject::test::test_recorded_motion
