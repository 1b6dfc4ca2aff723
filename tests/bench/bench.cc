#include "tests/bench/bench.h"

#include <cstdio>

#include "tests/study/instruction_count.h"

namespace godobject::bench {
namespace {

std::vector<Row>& rows() {
  static std::vector<Row> all;
  return all;
}

/// Returns our row of this scene and integrator; null if there is none.
const Row* ours(const std::string& scene, const std::string& integrator) {
  for (const Row& r : rows())
    if (!r.peer && r.scene == scene && r.who.ends_with(integrator)) return &r;
  return nullptr;
}

std::string ratio(const Row& r, const std::string& integrator) {
  const Row* const base = ours(r.scene, integrator);
  if (base == nullptr) return "-";
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", r.times.p50 / base->times.p50);
  return text;
}

void show(benchmark::State& state, const Errors& errors) {
  state.counters["error_m"] = errors.position;
  state.counters["error_rad"] = errors.rotation;
  if (!errors.drift) return;
  state.counters["drift_m"] = errors.drift->m;
  state.counters["drift_rad"] = errors.drift->rad;
}

void show(benchmark::State& state, const ContactQuality& q, bool pile) {
  state.counters["contacts"] = q.contacts;
  if (pile) {
    state.counters["overlap_m"] = q.overlap;
    state.counters["overlap_median_m"] = q.overlap_median;
    state.counters["speed_m_s"] = q.speed;
  } else {
    state.counters["deepest_m"] = q.deepest.mean;
    state.counters["deepest_jitter_m"] = q.deepest.jitter;
    state.counters["average_m"] = q.average.mean;
    state.counters["average_jitter_m"] = q.average.jitter;
  }
}

void show(benchmark::State& state, const NetQuality& q) {
  state.counters["contacts"] = q.contacts;
  state.counters["iterations"] = q.iterations;
  if (q.stretch_error) state.counters["stretch_error"] = *q.stretch_error;
  if (q.node_error) state.counters["node_error_m"] = *q.node_error;
}

void print_references() {
  std::printf("\n%-7s %-34s %9s %9s %8s %7s %9s %9s %9s %9s %7s %7s\n", "scene", "by", "p50 ns", "p99 ns",
              "ns/body", "instr.", "error m", "rad", "drift m", "rad", "/euler", "/bdf2");
  for (const Row& r : rows()) {
    if (r.contacts || r.net) continue;
    const std::string instructions = r.instructions ? std::to_string(std::lround(*r.instructions)) : "-";
    const Drift drift = r.errors.drift.value_or(Drift{});
    std::printf("%-7s %-34s %9.0f %9.0f %8.1f %7s %9.2g %9.2g %9.2g %9.2g %7s %7s\n", r.scene.c_str(),
                r.who.c_str(), r.times.p50, r.times.p99, r.times.p50 / static_cast<double>(r.num_bodies),
                instructions.c_str(), r.errors.position, r.errors.rotation, drift.m, drift.rad,
                ratio(r, ImplicitEuler::name).c_str(), ratio(r, TrBdf2::name).c_str());
  }
}

void print_pressed() {
  std::printf("\n%-7s %-34s %9s %9s %8s %9s %9s %9s %9s %7s %7s\n", "scene", "by", "p50 ns", "p99 ns",
              "contacts", "deepest m", "jitter m", "average m", "jitter m", "/euler", "/bdf2");
  for (const Row& r : rows()) {
    if (!r.contacts || r.num_bodies > 1) continue;
    const ContactQuality& q = *r.contacts;
    std::printf("%-7s %-34s %9.0f %9.0f %8.1f %9.2g %9.2g %9.2g %9.2g %7s %7s\n", r.scene.c_str(),
                r.who.c_str(), r.times.p50, r.times.p99, q.contacts, q.deepest.mean, q.deepest.jitter,
                q.average.mean, q.average.jitter, ratio(r, ImplicitEuler::name).c_str(),
                ratio(r, TrBdf2::name).c_str());
  }
}

void print_piles() {
  std::printf("\n%-7s %-34s %9s %9s %8s %8s %8s %9s %9s %9s %7s\n", "scene", "by", "p50 ns", "p99 ns",
              "contacts", "p50/cont", "mean/con", "overlap m", "median m", "max m/s", "/euler");
  for (const Row& r : rows()) {
    if (!r.contacts || r.num_bodies == 1) continue;
    const ContactQuality& q = *r.contacts;
    std::printf("%-7s %-34s %9.0f %9.0f %8.1f %8.1f %8.1f %9.2g %9.2g %9.2g %7s\n", r.scene.c_str(),
                r.who.c_str(), r.times.p50, r.times.p99, q.contacts, r.times.p50 / q.contacts,
                r.times.mean / q.contacts, q.overlap, q.overlap_median, q.speed,
                ratio(r, ImplicitEuler::name).c_str());
  }
}

void print_nets() {
  std::printf("\n%-13s %-34s %9s %9s %8s %8s %9s %8s %8s %9s %7s %7s\n", "scene", "by", "p50 us", "p99 us",
              "p99/p50", "ns/node", "instr.", "contacts", "iterat.", "stretch", "/euler", "/bdf2");
  for (const Row& r : rows()) {
    if (!r.net) continue;
    const NetQuality& q = *r.net;
    const std::string instructions = r.instructions ? std::to_string(std::lround(*r.instructions)) : "-";
    char stretch[16] = "-", iterations[16] = "-";  // not reported by peers
    if (!r.peer) std::snprintf(iterations, sizeof iterations, "%.1f", q.iterations);
    if (q.stretch_error) std::snprintf(stretch, sizeof stretch, "%.2g", *q.stretch_error);
    std::printf("%-13s %-34s %9.1f %9.1f %8.2f %8.1f %9s %8.1f %8s %9s %7s %7s\n", r.scene.c_str(),
                r.who.c_str(), 1e-3 * r.times.p50, 1e-3 * r.times.p99, r.times.p99 / r.times.p50,
                r.times.p50 / static_cast<double>(r.num_bodies), instructions.c_str(), q.contacts, iterations,
                stretch, ratio(r, ImplicitEuler::name).c_str(), ratio(r, TrBdf2::name).c_str());
  }
}

}  // namespace

study::InstructionCounter& counter() {
  static study::InstructionCounter instance(study::probe_program(study::default_probe_directory(), false));
  return instance;
}

void keep(benchmark::State& state, const Row& row) {
  state.counters["p50_ns"] = row.times.p50;
  state.counters["p99_ns"] = row.times.p99;
  if (row.num_bodies > 1) state.counters["ns_per_body"] = row.times.p50 / static_cast<double>(row.num_bodies);
  if (row.instructions) state.counters["instructions"] = *row.instructions;
  if (row.net) show(state, *row.net);
  else if (row.contacts) show(state, *row.contacts, row.num_bodies > 1);
  else show(state, row.errors);
  for (Row& r : rows()) {
    if (r.scene != row.scene || r.who != row.who) continue;
    if (row.times.p50 < r.times.p50) r = row;
    return;
  }
  rows().push_back(row);
}

void print_table() {
  print_references();
  print_pressed();
  print_piles();
  print_nets();
  std::printf(
      "p50, p99: of single steps, the best repetition; /cont, mean/con: median and mean for each contact. "
      "/euler, /bdf2: p50 over ours with that integrator. stretch: of the net at rest, the largest error of "
      "a strain.\n");
}

void add(const std::string& name, const Effort& effort, const std::function<void(benchmark::State&)>& run) {
  auto* const benchmark = benchmark::RegisterBenchmark(name.c_str(), run)
                              ->Unit(benchmark::kNanosecond)
                              ->Repetitions(effort.repetitions)
                              ->ReportAggregatesOnly(true);
  if (effort.iterations == 0) benchmark->MinTime(0.1);
  else benchmark->Iterations(effort.iterations);
}

}  // namespace godobject::bench

int main(int argc, char** argv) {
  using namespace godobject::bench;
  add_ours();
  add_peers();
  add_our_contacts();
  add_our_nets();
  add_contact_peers();
  add_net_peers();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  print_table();
}
