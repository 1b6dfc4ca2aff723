#include "tests/bench/bench_scene.h"

#include <map>

#include "tests/study/case_errors.h"
#include "tests/study/compositions.h"
#include "tests/study/joint/scene.h"
#include "tests/study/reference_solution.h"
#include "tests/study/short_steps.h"

namespace godobject::bench {
namespace {

BenchScene with_reference(const study::ReferenceScene& scene) {
  return {.scene = scene, .reference = study::reference_of(scene)};
}

oracle::Solution chain_reference(const oracle::Case& problem) {
  constexpr std::size_t steps_between = 128;
  const std::vector<double> times = oracle::uniform_times(0.5, study::comparison_step);
  switch (problem.bodies.size()) {
    case 1: return study::by_short_steps<study::FreeJoints<TrBdf2, 1>>(problem, times, steps_between, 1);
    case 8: return study::by_short_steps<study::FreeJoints<TrBdf2, 8>>(problem, times, steps_between, 1);
    case 64: return study::by_short_steps<study::FreeJoints<TrBdf2, 64>>(problem, times, steps_between, 1);
    default: return study::by_short_steps<study::FreeJoints<TrBdf2, 256>>(problem, times, steps_between, 1);
  }
}

}  // namespace

const BenchScene& s1() {
  static const BenchScene once = with_reference(study::scene_s1());
  return once;
}

const BenchScene& s3() {
  static const BenchScene once = with_reference(study::reference_s3());
  return once;
}

const BenchScene& s5(std::size_t num_links) {
  static std::map<std::size_t, BenchScene> made;
  const auto [entry, is_new] = made.try_emplace(num_links);
  BenchScene& chain = entry->second;
  if (is_new) {
    chain.scene = {.name = "S5/" + std::to_string(num_links),
                   .about = "links on ball joints, released at 45 degrees",
                   .problem = study::scene_s5(num_links),
                   .duration = 2};
    chain.reference = chain_reference(chain.scene.problem);
  }
  return chain;
}

}  // namespace godobject::bench
