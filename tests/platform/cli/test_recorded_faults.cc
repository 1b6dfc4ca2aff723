// A recorded run with a fault every second is repeated bit for bit. Nightly it has 10 minutes.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/support/fault_reactions.h"
#include "tests/support/faulty_rig.h"
#include "tests/support/nightly.h"
#include "tests/support/program.h"

namespace godobject::test::test_recorded_faults {
namespace {

constexpr double begin_s = 1, pause_s = 1, fault_s = 0.3;

/// Returns true if --rearm auto arms a simulated rig again. A collision of ids needs `restart`.
bool is_left(const FaultReaction& reaction) {
  return !reaction.words.starts_with("id-collision") && !any(reaction.expected & never_rearmed);
}

/// Returns the table of a fault in words, e.g. "drop bus=can0 node=1".
std::string table_of(const std::string& words, double at_s) {
  std::istringstream in(words);
  std::string verb, word;
  in >> verb;
  std::string table = "[[fault]]\nverb = \"" + verb + "\"\nat = " + std::to_string(at_s) + "\n";
  if (words.find("duration=") == std::string::npos) table += "duration = " + std::to_string(fault_s) + "\n";
  while (in >> word) {
    const std::size_t sign = word.find('=');
    const std::string value = word.substr(sign + 1);
    const std::string key = word.starts_with("node=") ? "node_id" : word.substr(0, sign);
    table += key + " = " + (word.starts_with("bus") ? '"' + value + '"' : value) + "\n";
  }
  return table;
}

class RecordedFaults : public ProgramTest {};

TEST_F(RecordedFaults, AreRepeatedBitForBit) {
  const double end_s = length_of(31.0, 600.0);
  std::vector<FaultReaction> reactions = fault_reactions(*two_joints().device->rig, FaultyRig::period_s);
  std::erase_if(reactions, std::not_fn(is_left));
  std::string text = two_joints_toml;
  std::size_t num_faults = 0, num_seen = 0;
  for (double at_s = begin_s; at_s < end_s - pause_s; at_s += pause_s, ++num_faults) {
    const FaultReaction& reaction = reactions[num_faults % reactions.size()];
    text += table_of(reaction.words, at_s);
    if (reaction.expected != RigFault::none) ++num_seen;
  }
  const ProgramResult run = run_program("run " + write("scene.toml", text) +
                                        " --fast --quiet --rearm auto --duration " + std::to_string(end_s) +
                                        " --record " + path("run.godo") + " --report " + path("report.json"));
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
  ASSERT_TRUE(report.is_object()) << run.output;
  EXPECT_EQ(report["cycles"], std::llround(1e3 * end_s)) << run.output;
  std::size_t num_armed = 0;
  for (const auto& recovery : report["recoveries"])
    num_armed += recovery["recovered_after_s"].is_null() ? 0 : 1;
  std::printf("%zu faults of %zu kinds in %g s, %zu of them to be seen; armed again %zu times\n", num_faults,
              reactions.size(), end_s, num_seen, num_armed);
  EXPECT_GE(2 * num_armed, num_seen);

  const ProgramResult again = run_program("replay " + path("run.godo"));
  EXPECT_EQ(again.exit_code, 0) << again.output;
  EXPECT_THAT(again.output, testing::HasSubstr("replayed " + report["cycles"].dump() + " cycles"));
  EXPECT_THAT(again.output, testing::HasSubstr("identical, also the rig\n"));
}

/// Pauses between boots pass in simulated time, so the bus is on again after some of them.
TEST_F(RecordedFaults, HostIsArmedAgainAfterItsBusIsOn) {
  const std::string scene = write("scene.toml", two_joints_toml + table_of("bus-off duration=2", begin_s));
  const ProgramResult run = run_program(
      "run " + scene + " --fast --quiet --rearm auto --duration 3 --report " + path("report.json"));
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
  ASSERT_TRUE(report.is_object()) << run.output;
  EXPECT_EQ(report["cycles"], 3000) << run.output;
  ASSERT_EQ(report["recoveries"].size(), 1u);
  const nlohmann::json& recovery = report["recoveries"][0];
  ASSERT_FALSE(recovery["recovered_after_s"].is_null()) << recovery["boots"] << " boots";
  EXPECT_GE(recovery["recovered_after_s"], 2);
  EXPECT_LE(recovery["recovered_after_s"], 2 + 2) << "the longest pause, and a boot";
}

/// A fault within a second of the one before is in its file.
TEST_F(RecordedFaults, EachHasAFileOfTheSecondsBefore) {
  std::string text = two_joints_toml;
  for (const double at_s : {3.0, 6.0, 18.0}) text += table_of("drop bus=can0 node=1", at_s);
  const ProgramResult run =
      run_program("run " + write("scene.toml", text) + " --fast --rearm auto --duration 22 --on-fault " +
                  path("fault.godo") + " --report " + path("report.json"));
  EXPECT_EQ(run.exit_code, 1);
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
  ASSERT_TRUE(report.is_object()) << run.output;
  const nlohmann::json& files = report["files"]["on_fault"];
  ASSERT_EQ(files.size(), 3u) << run.output;
  const double kept_s[] = {3, 6, 10};
  for (int i = 0; i < 3; ++i) {
    const std::string name = path(i == 0 ? "fault.godo" : "fault-" + std::to_string(i + 1) + ".godo");
    EXPECT_EQ(files[i]["path"], name);
    EXPECT_NEAR(files[i]["kept_s"].get<double>(), kept_s[i], 1.1);
    EXPECT_GE(files[i]["kept_s"].get<double>(), std::min(kept_s[i], 10.0));
    EXPECT_EQ(files[i]["is_bounded"], false);
    EXPECT_THAT(run.output, testing::HasSubstr(" kept in " + name + "; godobject replay repeats them"));
    EXPECT_THAT(run.output, testing::ContainsRegex("file +" + name + ", [0-9.]+ s before a fault"));
    const ProgramResult again = run_program("replay " + name);
    EXPECT_EQ(again.exit_code, 0) << again.output;
    // The first ten seconds of a run have the start of the rig.
    EXPECT_THAT(again.output, testing::HasSubstr(i < 2 ? "identical, also the rig\n" : "identical\n"));
  }
}

TEST_F(RecordedFaults, HaveTenFilesAtMost) {
  std::string text = two_joints_toml;
  for (int i = 0; i < 14; ++i) text += table_of("drop bus=can0 node=1", 2 + 3 * i);
  const ProgramResult run =
      run_program("run " + write("scene.toml", text) + " --fast --rearm auto --duration 45 --on-fault " +
                  path("fault.godo") + " --report " + path("report.json"));
  const nlohmann::json report = nlohmann::json::parse(read_file(path("report.json")), nullptr, false);
  ASSERT_TRUE(report.is_object()) << run.output;
  EXPECT_EQ(report["files"]["on_fault"].size(), 10u);
  EXPECT_THAT(run.output, testing::HasSubstr("fault-10.godo; no further file is written"));
  EXPECT_FALSE(std::filesystem::exists(path("fault-11.godo")));
}

}  // namespace
}  // namespace godobject::test::test_recorded_faults
