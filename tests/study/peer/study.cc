#include "tests/study/peer/study.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include "tests/bench/net_contest.h"
#include "tests/study/csv_writer.h"
#include "tests/study/peer/own.h"
#include "tests/study/peer/scene_file.h"
#include "tests/study/reference_solution.h"
#include "tests/study/tool.h"

namespace godobject::study {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct PeerPlan {
  std::vector<ReferenceScene> scenes;
  std::vector<double> pressed;    // N/m, of S2
  std::vector<double> stiffened;  // N/m, of S1
  std::vector<double> steps;      // s, of S1 stiffened
  double stiffened_duration = 2;  // s
};

PeerPlan peer_plan(bool quick) {
  if (!quick)
    return {.scenes = {scene_s1(), reference_s3(), reference_chain()},
            .pressed = {1e3, 1e4, 1e5, 1e6},
            .stiffened = {1e3, 1e4, 1e5, 1e6},
            .steps = {1e-3, 2e-3, 4e-3}};
  ReferenceScene s1 = scene_s1();
  s1.duration = 2;
  return {.scenes = {s1}, .pressed = {}, .stiffened = {1e6}, .steps = {2e-3}};
}

std::string file_name(std::string scene) {
  std::replace(scene.begin(), scene.end(), '/', '-');
  return scene + ".json";
}

json hanging_net_json() {
  using Net = bench::HangingNet;
  return {{"across", Net::across}, {"down", Net::down}, {"spacing", Net::spacing}, {"m", Net::m},
          {"k", Net::k},           {"g", Net::g()},     {"g_air", Net::g_air},     {"gravity", Net::gravity},
          {"h", Net::h},           {"duration", 1.0}};
}

/// Writes the scene files and plan.json, which lists them.
void write_plan(const fs::path& out, const PeerPlan& plan, bool quick) {
  json content{
      {"steps", error_steps(quick)},
      {"stiffened",
       {{"stiffnesses", plan.stiffened}, {"steps", plan.steps}, {"duration", plan.stiffened_duration}}}};
  content["errors"] = content["contacts"] = content["piles"] = content["nets"] = json::array();
  for (const ReferenceScene& scene : plan.scenes) {
    write_scene(out / file_name(scene.name), scene, reference_of(scene));
    content["errors"].push_back(file_name(scene.name));
  }
  for (const double k : plan.pressed) {
    const bench::ContactScene scene = bench::scene_s2(k);
    write_scene(out / file_name(scene.name), scene);
    content["contacts"].push_back(file_name(scene.name));
  }
  if (!quick) {
    const bench::ContactScene pile = bench::scene_s4(64, 20);
    write_scene(out / file_name(pile.name), pile);
    content["piles"].push_back(file_name(pile.name));
    content["nets"].push_back(hanging_net_json());
  }
  std::ofstream(out / "plan.json") << content << '\n';
}

/// Returns a number of node's rows; null stands for infinity there.
double number_of(const json& row, const char* key) {
  return row.at(key).is_null() ? std::numeric_limits<double>::infinity() : row.at(key).get<double>();
}

void add_rows_of(const json& all, PeerResults& results) {
  for (const json& r : all.at("errors"))
    results.errors.push_back({r.at("scene"), r.at("engine"), r.at("h"), number_of(r, "position"),
                              number_of(r, "rotation"), number_of(r, "usPerStep")});
  for (const json& r : all.at("contacts"))
    results.contacts.push_back({r.at("engine"), r.at("k"), number_of(r, "depth"), number_of(r, "jitter"),
                                number_of(r, "usPerStep")});
  for (const json& r : all.at("piles"))
    results.piles.push_back({r.at("engine"), number_of(r, "overlap"), number_of(r, "median"),
                             number_of(r, "usPerStep"), number_of(r, "p99")});
  for (const json& r : all.at("nets"))
    results.nets.push_back({r.at("engine"), number_of(r, "stretch"), number_of(r, "usPerStep")});
  for (const json& r : all.at("stability"))
    results.stability.push_back({r.at("engine"), r.at("k"), r.at("h"), number_of(r, "distance")});
  results.versions = all.at("versions");
}

/// Runs the peers in node and adds their rows. Returns the reason if they did not run.
std::string run_peers(const PeerFolders& folders, PeerResults& results) {
  const fs::path packages = folders.packages.empty() ? fs::path(GODOBJECT_PEER_PACKAGES) : folders.packages;
  if (!tool_exists("node")) return "node is not installed";
  if (!fs::exists(packages / "node_modules"))
    return "their npm packages are not in " + packages.filename().string() +
           "/: ./dev setup peers fetches them";
  const std::string program = peer_program().string();
  const ToolResult run =
      run_tool({"node", program, "--packages", packages.string(), "--plan",
                (folders.out / "plan.json").string(), "--out", (folders.out / "peers.json").string()});
  if (!run.ok()) throw std::runtime_error("node " + program + " failed: " + run.output);
  std::ifstream file(folders.out / "peers.json");
  add_rows_of(json::parse(file), results);
  return {};
}

}  // namespace

fs::path peer_program() { return GODOBJECT_PEER_PROGRAM; }

bool is_ours(const std::string& engine) {
  return engine.starts_with(ImplicitEuler::name) || engine.starts_with(TrBdf2::name);
}

PeerResults study_peers(const PeerFolders& folders, bool quick, const Progress& progress) {
  fs::create_directories(folders.out);
  const PeerPlan plan = peer_plan(quick);
  PeerResults results;
  results.errors = own_errors(plan.scenes, quick, progress);
  progress("peers: S2 and S1 stiffened");
  results.contacts = own_contacts(plan.pressed);
  if (!quick) {
    progress("peers: S4 and S6");
    results.piles.push_back(own_pile());
    results.nets.push_back(own_net());
  }
  results.stability = own_stability(plan.stiffened, plan.steps, plan.stiffened_duration);
  write_plan(folders.out, plan, quick);
  progress("peers: node");
  results.why_not = run_peers(folders, results);
  return results;
}

const PeerError* find_row(const std::vector<PeerError>& rows, const std::string& scene,
                          const std::string& engine, double h) {
  const auto row = std::ranges::find_if(rows, [&](const PeerError& r) {
    return r.scene == scene && r.engine == engine && std::abs(r.h / h - 1) < 1e-6;
  });
  return row == rows.end() ? nullptr : &*row;
}

std::vector<std::string> engines_of(const PeerResults& results) {
  std::vector<std::string> engines;
  const auto add = [&](const std::string& engine) {
    if (std::ranges::find(engines, engine) == engines.end()) engines.push_back(engine);
  };
  for (const PeerError& r : results.errors) add(r.engine);
  for (const PeerContact& r : results.contacts) add(r.engine);
  return engines;
}

void write_csv(const fs::path& out, const PeerResults& results) {
  CsvWriter errors(out / "peers-error.csv",
                   "scene,engine,step_s,position_error_m,rotation_error_rad,wasm_us_per_step");
  for (const PeerError& r : results.errors)
    errors.row(r.scene, r.engine, r.h, r.position, r.rotation, r.us_per_step);
  CsvWriter contacts(out / "peers-contact.csv",
                     "engine,stiffness_N_per_m,penetration_m,jitter_m,wasm_us_per_step");
  for (const PeerContact& r : results.contacts) contacts.row(r.engine, r.k, r.depth, r.jitter, r.us_per_step);
  CsvWriter piles(out / "peers-pile.csv", "engine,overlap_m,median_overlap_m,wasm_us_per_step,wasm_p99_us");
  for (const PeerPile& r : results.piles) piles.row(r.engine, r.overlap, r.median, r.us_per_step, r.p99_us);
  CsvWriter nets(out / "peers-net.csv", "engine,stretch_error,wasm_us_per_step");
  for (const PeerNet& r : results.nets) nets.row(r.engine, r.stretch, r.us_per_step);
  CsvWriter stability(out / "peers-stability.csv", "engine,stiffness_N_per_m,step_s,distance_m");
  for (const PeerStability& r : results.stability) stability.row(r.engine, r.k, r.h, r.distance);
}

}  // namespace godobject::study
