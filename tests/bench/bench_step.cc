// The rigid step in free space: scene S1 at 1 ms, with and without feedback, one column per number:
// time of the loop, p50 and p99 of a step, instructions, bytes, and the error over the 20 s of S1.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>

#include "sim/study/case_run.h"
#include "sim/study/compositions.h"
#include "sim/study/error_study.h"
#include "sim/study/study.h"
#include "tests/oracle/scenes.h"

namespace godobject::study {
namespace {

constexpr double h = 1e-3;                // s
constexpr std::size_t num_steps = 20000;  // one run of S1

/// Times of one step in ns, sorted: means over chunks long enough for the clock's own time not to matter.
template <Scene S>
std::vector<double> chunk_times(CaseRun<S>& run, const std::vector<Input<S>>& inputs) {
  constexpr std::size_t chunk = 20;
  std::vector<double> times;
  for (std::size_t first = 0; first + chunk <= inputs.size(); first += chunk) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t n = first; n < first + chunk; ++n) run.step(inputs[n]);
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
    times.push_back(elapsed.count() / chunk);
  }
  std::sort(times.begin(), times.end());
  return times;
}

double percentile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

InstructionCounter& counter() {
  static InstructionCounter instance((default_probe_directory() / "godobject_probe").string());
  return instance;
}

/// Measured once per integrator: the oracle takes its time, and feedback does not change the motion.
template <class Integrator>
const Errors& errors() {
  static const Errors once = measure_errors(scene_s1(), Integrator::name, h);
  return once;
}

template <template <class, std::size_t> class SceneOf, class Integrator>
void step_s1(benchmark::State& state, const std::string& composition) {
  using S = SceneOf<Integrator, 1>;
  const oracle::Case problem = oracle::scene_s1();
  CaseRun<S> run(problem, h);
  const std::vector<Input<S>> inputs = run.inputs(num_steps, 1e9);
  std::size_t n = 0;
  for (auto _ : state) {
    run.step(inputs[n]);
    benchmark::ClobberMemory();
    if (++n == num_steps) {
      n = 0;
      run.restart();
    }
  }
  run.restart();
  const std::vector<double> times = chunk_times(run, inputs);
  state.counters["p50_ns"] = percentile(times, 0.5);
  state.counters["p99_ns"] = percentile(times, 0.99);
  if (const auto instructions = counter().per_step(composition))
    state.counters["instructions"] = *instructions;
  state.counters["state_bytes"] = sizeof(State<S>);
  state.counters["scratch_bytes"] = sizeof(Scratch<S>);
  state.counters["error_m"] = errors<Integrator>().position;
  state.counters["error_rad"] = errors<Integrator>().rotation;
}

template <template <class, std::size_t> class SceneOf, class Integrator>
void add(const std::string& scene) {
  const std::string composition = scene + "-1 " + Integrator::name;
  benchmark::RegisterBenchmark(("S1/" + composition).c_str(), step_s1<SceneOf, Integrator>, composition)
      ->Unit(benchmark::kNanosecond)
      ->MinTime(0.2)
      ->Repetitions(9)
      ->ReportAggregatesOnly(true);
}

}  // namespace

void add_all() {
  add<Follower, ImplicitEuler>("pose");
  add<Follower, TrBdf2>("pose");
  add<Haptic, ImplicitEuler>("haptic");
  add<Haptic, TrBdf2>("haptic");
}

}  // namespace godobject::study

int main(int argc, char** argv) {
  godobject::study::add_all();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
