// A recorded operation (80 s of a person teleoperating a robot) through the whole chain: encoders on
// simulated wires, the core, the drives.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/platform/program.h"
#include "tests/support/shared_data.h"

namespace godobject::test {
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
  // What the encoders do to the tool is small beside what the coupling does.
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

}  // namespace
}  // namespace godobject::test
