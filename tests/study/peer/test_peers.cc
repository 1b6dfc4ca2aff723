#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <nlohmann/json.hpp>

#include "tests/bench/contact_quality.h"
#include "tests/study/figure.h"
#include "tests/study/peer/own.h"
#include "tests/study/peer/scene_file.h"
#include "tests/study/peer/section.h"
#include "tests/study/peer/study.h"
#include "tests/study/reference_solution.h"
#include "tests/study/tool.h"

namespace godobject::study::test_peers {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// A folder removed at the end of the test.
class PeerFolder {
 public:
  PeerFolder() {
    std::string name = (fs::temp_directory_path() / "godobject-peers-XXXXXX").string();
    path_ = ::mkdtemp(name.data());
  }
  ~PeerFolder() { fs::remove_all(path_); }
  PeerFolder(const PeerFolder&) = delete;
  PeerFolder& operator=(const PeerFolder&) = delete;

  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

std::string content_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

ReferenceScene short_s3() {
  ReferenceScene scene = reference_s3();
  scene.duration = 0.02;
  return scene;
}

TEST(SceneFile, HasTheCaseItsReferenceAndItsTargets) {
  const PeerFolder folder;
  const ReferenceScene scene = short_s3();
  const oracle::Solution reference = reference_of(scene);
  write_scene(folder / "S3.json", scene, reference);
  const json written = json::parse(std::ifstream(folder / "S3.json"));
  ASSERT_EQ(written["bodies"].size(), 4u);
  EXPECT_EQ(written["bodies"][1]["coupling"]["k_r"], scene.problem.bodies[1].coupling->k_r);
  EXPECT_EQ(written["joints"][0]["type"], "universal");
  EXPECT_TRUE(written["joints"][0]["parent"].is_null());
  EXPECT_EQ(written["joints"][3]["parent"], 1);
  ASSERT_EQ(written["instants"].size(), reference.times.size());
  EXPECT_EQ(written["instants"][5]["poses"][2]["p"][0], reference.states[5][2].p.x());
  EXPECT_EQ(written["instants"][5]["targets"].size(), 4u);
}

TEST(SceneFile, WithoutAFolderIsAnError) {
  const ReferenceScene scene = short_s3();
  EXPECT_THROW(write_scene("/nowhere/S3.json", scene, {}), std::runtime_error);
}

/// Its targets are written a second time in motion.mjs: both must be the same.
TEST(SceneFile, OfAnotherMotionIsRefusedByTheReader) {
  if (!tool_exists("node")) GTEST_SKIP() << "node is not installed";
  const PeerFolder folder;
  ReferenceScene scene = short_s3();
  const fs::path file = folder / "S3.json";
  const fs::path module = peer_program().parent_path() / "scene.mjs";
  const auto read = [&] {
    write_scene(file, scene, {.times = {0, 0.004}, .states = {{}, {}}});
    return run_tool({"node", "--input-type=module", "-e",
                     "import { load } from '" + module.string() + "'; load('" + file.string() + "')"});
  };
  const ToolResult same = read();
  EXPECT_TRUE(same.ok()) << same.output;
  // At 0 s the jaws are shut, and their targets equal.
  scene.problem.bodies[2].coupling->target = scene.problem.bodies[3].coupling->target;
  const ToolResult other = read();
  EXPECT_FALSE(other.ok());
  EXPECT_NE(other.output.find("the target of body 2 at 0.004 s differs from motion.mjs"), std::string::npos)
      << other.output;
}

/// Returns a vector or quaternion as node writes it.
template <class V>
std::string text_of(const V& values) {
  std::ostringstream text;
  text.precision(17);
  const char* separator = "[";
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    text << separator << values[i];
    separator = ",";
  }
  return text.str() + "]";
}

std::string pose_text(const oracle::RigidState& x) {
  const Eigen::Vector4d wxyz(x.q.w(), x.q.x(), x.q.y(), x.q.z());
  return "{p:" + text_of(x.p) + ",q:" + text_of(wxyz) + "}";
}

TEST(PileMeasure, IsThatOfTheBenchmarks) {
  if (!tool_exists("node")) GTEST_SKIP() << "node is not installed";
  const Vec3 half(0.016, 0.008, 0.005);
  const std::string module = (peer_program().parent_path() / "pile.mjs").string();
  for (const double x : {0.0, 0.012, 0.03, 0.05}) {
    oracle::RigidState a, b;
    a.q = oracle::Quaterniond(0.9, 0.1, -0.2, 0.3).normalized();
    b.p = {x, 0.002, 0.004};
    const ToolResult run = run_tool({"node", "--input-type=module", "-e",
                                     "import { overlapOf } from '" + module + "'; console.log(overlapOf(" +
                                         text_of(half) + "," + pose_text(a) + "," + pose_text(b) + "))"});
    ASSERT_TRUE(run.ok()) << run.output;
    EXPECT_NEAR(std::stod(run.output), bench::box_overlap(half, a, b), 1e-12) << x;
  }
}

TEST(BagMeasure, IsThatOfTheCore) {
  if (!tool_exists("node")) GTEST_SKIP() << "node is not installed";
  const Bag bag = endobag();
  nlohmann::json scene = bag_json(bag, {});
  for (const char* part : {"nodes", "springs"}) scene.erase(part);  // an argument is too short for them
  const std::string module = (peer_program().parent_path() / "bag.mjs").string();
  const Vec3 node(0.012, 0.03, 0.004);
  const ToolResult run =
      run_tool({"node", "--input-type=module", "-e",
                "import { barAt, depthOf } from '" + module + "'; const bag = " + scene.dump() +
                    "; console.log(barAt(bag, 0.3)[0], depthOf(bag, barAt(bag, 2), " + text_of(node) + "))"});
  ASSERT_TRUE(run.ok()) << run.output;
  double at = 0, depth = 0;
  std::istringstream(run.output) >> at >> depth;
  EXPECT_NEAR(at, Bag::bar_at(0.3)[0], 1e-12);
  EXPECT_NEAR(depth, bag.depth(node), 1e-12);
}

/// The rest is that of an undented bag here, so the error is its dent.
TEST(Bag, IsDentedByTheBarAndKeepsItOut) {
  const Bag bag = endobag();
  EXPECT_EQ(bag.net.nodes.size(), 950u);
  std::vector<Vec3> undented;
  for (const NetNode& node : bag.net.nodes) undented.push_back(node.p_B);
  const PeerBag row = own_bags(bag, undented).front()();
  EXPECT_EQ(row.engine, "implicit-euler");
  EXPECT_GT(row.error, 0.5 * Bag::bar_press);
  EXPECT_LT(row.error, 2 * Bag::bar_press);
  EXPECT_GT(row.depth, 1e-5);
  EXPECT_LT(row.depth, 1e-3);
}

/// MuJoCo's `discrete` is implicit Euler on S1, as ours is.
TEST(PeerStudy, QuickRunHasFiniteErrorsOfTheExpectedSize) {
  const PeerFolder folder;
  const PeerResults results =
      study_peers({.out = folder / "out", .packages = {}}, true, [](const std::string&) {});
  const auto order = [&](const char* engine) {
    return std::log2(find_row(results.errors, "S1", engine, 2e-3)->position /
                     find_row(results.errors, "S1", engine, 1e-3)->position);
  };
  EXPECT_NEAR(order("tr-bdf2"), 2, 0.1);
  if (!results.why_not.empty()) GTEST_SKIP() << results.why_not;
  for (const PeerError& r : results.errors) {
    SCOPED_TRACE(r.engine + " " + std::to_string(r.h));
    EXPECT_EQ(r.engine.find(','), std::string::npos) << "gnuplot ends a field there";
    const bool is_rk4 = r.engine.find("RK4") != std::string::npos,
               is_explicit = r.engine == "ODE 0.16 explicit force";
    const bool too_stiff = (is_rk4 && r.h > 3e-3) || (is_explicit && r.h > 1e-3);  // h g_r / I = 3.9 at 4 ms
    EXPECT_EQ(std::isfinite(r.position) && std::isfinite(r.rotation), !too_stiff);
  }
  const PeerError* const discrete = find_row(results.errors, "S1", "MuJoCo discrete", 1e-3);
  ASSERT_NE(discrete, nullptr);
  EXPECT_NEAR(discrete->position, 2.4e-5, 0.2 * 2.4e-5);
  EXPECT_NEAR(discrete->position / find_row(results.errors, "S1", "implicit-euler", 1e-3)->position, 1, 0.05);
  EXPECT_NEAR(order("MuJoCo discrete"), 1, 0.1);
  for (const PeerStability& r : results.stability)
    if (is_ours(r.engine) || r.engine.starts_with("MuJoCo discrete")) {
      EXPECT_LT(r.distance, 1e-4) << r.engine;
    } else if (r.engine == "MuJoCo Euler") {
      EXPECT_TRUE(std::isinf(r.distance));
    }
}

TEST(PeerFigure, HasALineOfEveryEngineAndIsDrawn) {
  const PeerFolder folder;
  PeerResults results;
  for (const char* engine :
       {"implicit-euler", "implicit-euler (mean velocity)", "tr-bdf2", "MuJoCo a", "MuJoCo b", "other"})
    for (const double h : {1e-3, 2e-3}) results.errors.push_back({"S1", engine, h, h * h, h, {}});
  fs::create_directories(folder / "out");
  write_csv(folder / "out", results);
  write_peer_script(folder / "out", results);
  EXPECT_EQ(content_of(folder / "out" / "peers.gp").find("simulated second"), std::string::npos)
      << "no times: gnuplot refuses a panel without a point";
  for (PeerError& r : results.errors)
    if (r.engine != "other") r.native_us = 2.0;
  write_csv(folder / "out", results);
  write_peer_script(folder / "out", results);
  const std::string gp = content_of(folder / "out" / "peers.gp");
  for (const PeerError& r : results.errors)
    EXPECT_NE(gp.find("strcol('engine') eq '" + r.engine + "'"), std::string::npos) << gp;
  if (!tool_exists("gnuplot")) GTEST_SKIP() << "gnuplot is not installed";
  EXPECT_EQ(draw(folder / "out", "peers"), "");
  EXPECT_GT(fs::file_size(folder / "out" / "peers.png"), 1000u);
}

TEST(PeerSection, IsReplacedAndTheRestOfTheReportStays) {
  const PeerFolder folder;
  const fs::path report = folder / "report.md";
  PeerResults results;
  results.why_not = "a reason";
  std::ofstream(report) << "before\n\n" << peers_begin << "## Old\n\n" << peers_end << "\nafter\n";
  for (int repeat = 0; repeat < 2; ++repeat) {
    replace_peers(report, results);
    EXPECT_EQ(content_of(report), "before\n\n" + std::string(peers_begin) +
                                      "## Beside other engines\n\nLeft out: a reason.\n\n" + peers_end +
                                      "\nafter\n");
  }
}

TEST(PeerSection, WithoutMarkersIsAnErrorAndTheReportStays) {
  const PeerFolder folder;
  const fs::path report = folder / "report.md";
  EXPECT_THROW(replace_peers(report, {}), std::runtime_error);
  std::ofstream(report) << "text\n";
  EXPECT_THROW(replace_peers(report, {}), std::runtime_error);
  EXPECT_EQ(content_of(report), "text\n");
}

TEST(PeerSection, NamesThePeerThatWinsInItsFirstLine) {
  PeerResults results;
  results.errors = {{"S1", "implicit-euler", 1e-3, 2e-5, 3e-4, {}},
                    {"S1", "tr-bdf2", 1e-3, 1e-8, 4e-7, {}},
                    {"S1", "other", 1e-3, 1e-9, 1e-6, 3.0}};
  const auto begins = [&](const std::string& begin) {
    std::ostringstream section;
    write_peers(section, results);
    return section.str().starts_with("## Beside other engines\n\n" + begin);
  };
  EXPECT_TRUE(
      begins("**A peer is better, by 5 % or more at a step of 1 ms:**\n\n"
             "- than tr-bdf2: S1 position (other: 1e-09, ours 1e-08).\n- than implicit-euler: S1 position "));
  results.errors[2].position = results.errors[2].rotation = 1;
  EXPECT_TRUE(begins("No peer is better than ours by 5 % at a step of 1 ms.\n"));
}

}  // namespace
}  // namespace godobject::study::test_peers
