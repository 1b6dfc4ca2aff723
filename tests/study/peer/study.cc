#include "tests/study/peer/study.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <stdexcept>
#include <thread>

#include <nlohmann/json.hpp>

#include "tests/bench/peer/native_peers.h"
#include "tests/study/csv_writer.h"
#include "tests/study/peer/native.h"
#include "tests/study/peer/own.h"
#include "tests/study/peer/scene_file.h"
#include "tests/study/peer/work_precision.h"
#include "tests/study/reference_solution.h"
#include "tests/study/report/text.h"
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

constexpr int rounds = 2;  // of whole runs, the faster of which counts

template <class T>
void append(std::vector<T>& all, const std::vector<T>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

template <class Row>
Runs<Row> joined(Runs<Row> all, const Runs<Row>& more) {
  append(all, more);
  return all;
}

/// Returns the processor and its load of the last minute.
std::string machine_line() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  std::string line, name = "an unknown processor";
  while (std::getline(cpuinfo, line))
    if (line.starts_with("model name")) name = line.substr(line.find(':') + 2);
  double load = 0;
  if (getloadavg(&load, 1) != 1) return name;
  return name + ", " + std::to_string(std::thread::hardware_concurrency()) + " CPUs, load " + number(load, 2);
}

/// Returns errors of tr-bdf2 at steps finer than those of the peers, so that curves over time overlap. Scenes
/// whose reference is tr-bdf2 itself are left out.
std::vector<PeerError> finer_errors(const std::vector<ReferenceScene>& scenes, const Progress& progress) {
  std::vector<PeerError> rows;
  for (const ReferenceScene& scene : scenes) {
    if (scene.stiff) continue;
    for (const double h : {0.0625e-3, 0.03125e-3, 0.015625e-3}) {
      progress("peers: " + scene.name + ", tr-bdf2, " + number(1e6 * h) + " us");
      const Errors worst = measure_errors(scene, TrBdf2::name, h);
      rows.push_back({.scene = scene.name,
                      .engine = TrBdf2::name,
                      .h = h,
                      .position = worst.position,
                      .rotation = worst.rotation,
                      .us_per_step = {}});
    }
  }
  return rows;
}

/// Writes the scene files and plan.json, which lists them. bags: of bag_json().
void write_plan(const fs::path& out, const PeerPlan& plan, bool quick, const json& bags) {
  json content{
      {"steps", error_steps(quick)},
      {"stiffened",
       {{"stiffnesses", plan.stiffened}, {"steps", plan.steps}, {"duration", plan.stiffened_duration}}},
      {"bags", bags}};
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

void add_new(std::vector<std::string>& all, const std::string& one) {
  if (std::ranges::find(all, one) == all.end()) all.push_back(one);
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
  for (const json& r : all.at("bags"))
    results.bags.push_back(
        {r.at("engine"), number_of(r, "error"), number_of(r, "depth"), number_of(r, "usPerStep")});
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
  results.missing = bench::native_peers().missing;
  results.errors = own_errors(plan.scenes, quick, progress);
  if (!quick) append(results.errors, finer_errors(plan.scenes, progress));
  append(results.errors, native_errors(plan.scenes, error_steps(quick), progress));
  results.machine = machine_line();
  add_native_times(plan.scenes, quick, progress, results.errors);
  json bags = json::array();
  progress("peers: S2");
  results.contacts = interleaved(joined(own_contacts(plan.pressed), native_contacts(plan.pressed)), rounds);
  if (!quick) {
    progress("peers: S4");
    results.piles = interleaved(joined({own_pile}, native_piles()), rounds);
    progress("peers: S6");
    results.nets = interleaved(joined(own_nets(), native_nets()), rounds);
    progress("peers: bag");
    const Bag bag = endobag();
    const std::vector<Vec3> rest = bag_at_rest(bag);
    results.bags = interleaved(own_bags(bag, rest), rounds);
    bags.push_back(bag_json(bag, rest));
  }
  progress("peers: S1 stiffened");
  results.stability = own_stability(plan.stiffened, plan.steps, plan.stiffened_duration);
  append(results.stability, native_stability(plan.stiffened, plan.steps, plan.stiffened_duration));
  write_plan(folders.out, plan, quick, bags);
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
  for (const PeerError& r : results.errors) add_new(engines, r.engine);
  for (const PeerContact& r : results.contacts) add_new(engines, r.engine);
  return engines;
}

std::vector<std::string> scenes_of(const PeerResults& results) {
  std::vector<std::string> scenes;
  for (const PeerError& r : results.errors) add_new(scenes, r.scene);
  return scenes;
}

void write_csv(const fs::path& out, const PeerResults& results) {
  CsvWriter errors(
      out / "peers-error.csv",
      "scene,engine,step_s,position_error_m,rotation_error_rad,wasm_us_per_step,native_us_per_step,"
      "native_ms_per_simulated_s");
  for (const PeerError& r : results.errors)
    errors.row(r.scene, r.engine, r.h, r.position, r.rotation, r.us_per_step, r.native_us,
               r.native_us ? std::optional(1e-3 * *r.native_us / r.h) : std::nullopt);
  CsvWriter contacts(out / "peers-contact.csv",
                     "engine,stiffness_N_per_m,penetration_m,jitter_m,wasm_us_per_step,native_us_per_step");
  for (const PeerContact& r : results.contacts)
    contacts.row(r.engine, r.k, r.depth, r.jitter, r.us_per_step, r.native_us);
  CsvWriter piles(
      out / "peers-pile.csv",
      "engine,overlap_m,median_overlap_m,wasm_us_per_step,wasm_p99_us,native_us_per_step,native_p99_us");
  for (const PeerPile& r : results.piles)
    piles.row(r.engine, r.overlap, r.median, r.us_per_step, r.p99_us, r.native_us, r.native_p99_us);
  CsvWriter nets(out / "peers-net.csv", "engine,stretch_error,wasm_us_per_step,native_us_per_step");
  for (const PeerNet& r : results.nets) nets.row(r.engine, r.stretch, r.us_per_step, r.native_us);
  CsvWriter bags(out / "peers-bag.csv", "engine,error_m,depth_m,wasm_us_per_step,native_us_per_step");
  for (const PeerBag& r : results.bags) bags.row(r.engine, r.error, r.depth, r.us_per_step, r.native_us);
  CsvWriter stability(out / "peers-stability.csv", "engine,stiffness_N_per_m,step_s,distance_m");
  for (const PeerStability& r : results.stability) stability.row(r.engine, r.k, r.h, r.distance);
  write_work_csv(out / "peers-work.csv", results);
}

}  // namespace godobject::study
