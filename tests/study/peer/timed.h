// Native times of several engines in one run. They are measured in rounds, in which engines take turns,
// because the speed of the machine changes.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace godobject::study {

inline double median_of(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// A run of short steps, timed in blocks.
class TimedRun {
 public:
  virtual ~TimedRun() = default;
  virtual std::size_t num_steps() const = 0;
  virtual void restart() = 0;
  /// Takes the steps from `first` to before `end`.
  virtual void advance(std::size_t first, std::size_t end) = 0;
};

/// Returns the median time of a step of each run, us. A block takes about block_s.
std::vector<double> interleaved_us(const std::vector<std::unique_ptr<TimedRun>>& runs, int rounds,
                                   double block_s);

/// Times steps one by one that take microseconds or more.
class StepClock {
 public:
  template <class Step>
  void time(Step step) {
    const auto start = std::chrono::steady_clock::now();
    step();
    const std::chrono::duration<double, std::micro> elapsed = std::chrono::steady_clock::now() - start;
    times_us_.push_back(elapsed.count());
  }
  double median_us() const { return median_of(times_us_); }
  double p99_us() const {
    std::vector<double> sorted = times_us_;
    std::ranges::sort(sorted);
    return sorted[sorted.size() * 99 / 100];
  }

 private:
  std::vector<double> times_us_;
};

/// Whole runs of a scene, each of which returns its row.
template <class Row>
using Runs = std::vector<std::function<Row()>>;

/// Runs all in rounds. Keeps the lowest native times of each.
template <class Row>
std::vector<Row> interleaved(const Runs<Row>& runs, int rounds) {
  std::vector<Row> rows;
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const Row row = runs[i]();
      if (round == 0) rows.push_back(row);
      else if (row.native_us < rows[i].native_us) rows[i] = row;
    }
  return rows;
}

}  // namespace godobject::study
