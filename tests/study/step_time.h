// Measures the run time of a step.
#pragma once

#include <algorithm>
#include <chrono>
#include <vector>

#include "tests/study/case_run.h"

namespace godobject::study {

/// Returns the median time of one step, ns, over blocks of up to 1000 steps. A block is long enough for the
/// clock and mostly short enough not to be interrupted. Inputs are computed before the clock starts. The run
/// restarts until min_steps are done.
template <Scene S>
double time_step(CaseRun<S>& run, const std::vector<Input<S>>& inputs, std::size_t min_steps) {
  using Clock = std::chrono::steady_clock;
  constexpr std::size_t stretch = 1000;
  std::vector<double> times;
  for (std::size_t done = 0; done < min_steps; done += inputs.size()) {
    run.restart();
    for (std::size_t n = 0; n < inputs.size();) {
      const std::size_t first = n, end = std::min(inputs.size(), n + stretch);
      const Clock::time_point start = Clock::now();
      for (; n < end; ++n) run.step(inputs[n]);
      const std::chrono::duration<double, std::nano> elapsed = Clock::now() - start;
      times.push_back(elapsed.count() / static_cast<double>(end - first));
    }
  }
  const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
  std::nth_element(times.begin(), middle, times.end());
  return *middle;
}

}  // namespace godobject::study
