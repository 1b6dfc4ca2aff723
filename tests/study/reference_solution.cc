#include "tests/study/reference_solution.h"

#include "tests/study/case_errors.h"
#include "tests/study/compositions.h"
#include "tests/study/short_steps.h"

namespace godobject::study {
namespace {

constexpr double oracle_duration = 0.052;   // s
constexpr std::size_t steps_between = 256;  // steps per comparison interval

oracle::Solution own_solution(const ReferenceScene& scene, const std::vector<double>& times) {
  return by_short_steps<Tool<TrBdf2, 4>>(scene.problem, times, steps_between, scene.duration);
}

}  // namespace

oracle::Solution reference_of(const ReferenceScene& scene) {
  const std::vector<double> times = oracle::uniform_times(scene.duration, comparison_step);
  return scene.stiff ? own_solution(scene, times) : oracle::solve(scene.problem, times);
}

double reference_error(const ReferenceScene& scene) {
  const std::vector<double> times = oracle::uniform_times(oracle_duration, comparison_step);
  const oracle::Solution exact = oracle::solve(scene.problem, times), own = own_solution(scene, times);
  double worst = 0;
  for (std::size_t n = 0; n < times.size(); ++n)
    for (std::size_t i = 0; i < exact.states[n].size(); ++i)
      worst = std::max(worst, (own.states[n][i].p - exact.states[n][i].p).norm());
  return worst;
}

}  // namespace godobject::study
