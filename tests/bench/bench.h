// Shared parts of the benchmarks: timing of steps, references of the runs, the closing table.
#pragma once

#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/contact_quality.h"
#include "tests/bench/peer/peer.h"
#include "tests/study/case_errors.h"
#include "tests/study/instruction_count.h"

namespace godobject::bench {

using study::Errors;

/// Times of one step in ns.
struct StepTimes {
  double p50 = 0, p99 = 0, mean = 0;
};

/// Times `steps` steps in order. Short steps are timed in chunks of up to 20, about 1 us each, so that the
/// clock's own time does not matter.
template <class Step>
StepTimes time_steps(std::size_t steps, double mean_ns, Step step) {
  const auto chunk = static_cast<std::size_t>(std::clamp(1000 / mean_ns, 1.0, 20.0));
  std::vector<double> times;
  for (std::size_t first = 0; first + chunk <= steps; first += chunk) {
    const auto start = std::chrono::steady_clock::now();
    for (std::size_t n = first; n < first + chunk; ++n) step(n);
    const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
    times.push_back(elapsed.count() / static_cast<double>(chunk));
  }
  std::sort(times.begin(), times.end());
  const auto at = [&](double share) {
    return times[static_cast<std::size_t>(share * static_cast<double>(times.size() - 1))];
  };
  double sum = 0;
  for (const double time : times) sum += time;
  return {.p50 = at(0.5), .p99 = at(0.99), .mean = sum / static_cast<double>(times.size())};
}

/// Quality of a net: means over the timed steps. stretch_error: springs against the stretch at rest.
/// node_error: farthest node from its place with complete iterations, m.
struct NetQuality {
  double iterations = 0, contacts = 0;
  std::optional<double> stretch_error, node_error;  // if known
};

/// A line of the closing table.
struct Row {
  std::string scene, who;
  std::size_t num_bodies = 1;
  bool peer = false;
  StepTimes times;  // the repetition with the lowest median
  std::optional<double> instructions;
  Errors errors;
  std::optional<ContactQuality> contacts;  // of a scene with contacts, which has no reference
  std::optional<NetQuality> net = {};      // of a scene with a net; bodies are its nodes
};

/// Runs steps 0 .. steps - 1 repeatedly for google benchmark, then once more step by step, and keeps the row.
template <class Restart, class Step>
void measure(benchmark::State& state, Row row, std::size_t steps, Restart restart, Step step);

/// Keeps the row's lowest median, and reports its numbers as counters.
void keep(benchmark::State& state, const Row& row);

/// Prints all rows kept, with the ratio of every peer to ours.
void print_table();

study::InstructionCounter& counter();

/// Number of repetitions of a benchmark.
struct Effort {
  int repetitions;
  long iterations;  // of google's loop; 0: as many as take 0.1 s
};
inline constexpr Effort short_scene{.repetitions = 9, .iterations = 0};
/// A run of all its steps takes seconds, after every loop.
inline constexpr Effort long_scene{.repetitions = 3, .iterations = 100};
/// A run takes half a minute.
inline constexpr Effort slow_scene{.repetitions = 1, .iterations = 1};

void add(const std::string& name, const Effort& effort, const std::function<void(benchmark::State&)>& run);

/// Registers our step on every scene, and the peers of this build; then both on the scenes with contacts.
void add_ours();
void add_peers();
void add_our_contacts();
void add_contact_peers();
void add_our_nets();
void add_net_peers();

template <class Restart, class Step>
void measure(benchmark::State& state, Row row, std::size_t steps, Restart restart, Step step) {
  using Clock = std::chrono::steady_clock;
  std::size_t n = 0;
  restart();
  const Clock::time_point start = Clock::now();
  for (auto _ : state) {
    step(n);
    benchmark::ClobberMemory();
    if (++n == steps) {
      n = 0;
      restart();
    }
  }
  const std::chrono::duration<double, std::nano> elapsed = Clock::now() - start;
  restart();
  row.times = time_steps(steps, elapsed.count() / static_cast<double>(state.iterations()), step);
  keep(state, row);
}

}  // namespace godobject::bench
