// Many bodies and many nodes: apart from own.cc, since their steps take the longest to compile.
#include <limits>
#include <memory>

#include "tests/bench/contact_quality.h"
#include "tests/bench/hanging_run.h"
#include "tests/study/case_errors.h"
#include "tests/study/contact/run.h"
#include "tests/study/peer/own.h"

namespace godobject::study {

PeerPile pile_row(const std::string& engine, const bench::ContactQuality& quality, const StepClock& clock,
                  bool failed) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  return {.engine = engine,
          .overlap = failed ? infinite : quality.overlap,
          .median = failed ? infinite : quality.overlap_median,
          .us_per_step = {},
          .p99_us = {},
          .native_us = clock.median_us(),
          .native_p99_us = clock.p99_us()};
}

PeerPile own_pile() {
  using S = Bricks<ImplicitEuler, 64>;
  constexpr double h = 1e-3;
  const bench::ContactScene scene = bench::scene_s4(64, 20);
  const auto run = std::make_unique<CaseRun<S>>(scene.problem, h);
  set_contacts(scene, run->params());
  const std::vector<Input<S>> inputs = run->inputs(steps_in(scene.duration, h), scene.duration);
  bool failed = false;
  StepClock clock;
  const bench::ContactQuality quality = bench::quality_of(scene, inputs.size(), [&](std::size_t n) {
    clock.time([&] { run->step(inputs[n]); });
    failed = failed || any(run->output().fault);
    bench::Snapshot now{{}, run->output().contacts.num_contacts};
    for (std::size_t i = 0; i < scene.problem.bodies.size(); ++i)
      now.bodies.push_back(oracle_state(run->body(i)));
    return now;
  });
  return pile_row(ImplicitEuler::name, quality, clock, failed);
}

PeerNet own_net() {
  bench::HangingRun<NetTool<ImplicitEuler, 1024>> run(NetParams<1, 1>{}.max_iterations);
  run.restart();
  StepClock clock;
  for (std::size_t n = 0; n < net_steps; ++n) clock.time([&] { run.step(0); });  // its ball stays away
  return {.engine = ImplicitEuler::name,
          .stretch = bench::stretch_error([&](std::uint32_t n) { return run.node(n); }),
          .us_per_step = {},
          .native_us = clock.median_us()};
}

}  // namespace godobject::study
