// Scenes of bench_step.cc, by the peers found in the build.
#include <memory>

#include "tests/bench/bench.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/peer/native_peers.h"
#include "tests/study/compositions.h"
#include "tests/study/joint/scene.h"

namespace godobject::bench {
namespace {

/// Returns errors and drift from the poses alone: the bodies placed as in the peer.
Errors errors_of(Peer& peer, const BenchScene& it, std::size_t steps) {
  using S = study::FreeJoints<ImplicitEuler, 256>;
  const auto run = std::make_unique<study::CaseRun<S>>(it.scene.problem, h);
  const std::size_t num_bodies = it.scene.problem.bodies.size();
  const auto every = static_cast<std::size_t>(std::lround(study::comparison_step / h));
  Errors errors;
  if (it.scene.is_articulated()) errors.drift = Drift{};
  peer.restart();
  for (std::size_t n = 1; n <= steps; ++n) {
    peer.step(n - 1);
    for (std::size_t i = 0; i < num_bodies; ++i) {
      const oracle::RigidState x = peer.pose(i);
      place(run->state(), i, {.X_WB = {.p = x.p, .q = Quat(x.q)}, .V_WB = {}});
    }
    if (errors.drift) errors.drift = worst(*errors.drift, run->drift());
    const bool counts = n % every == 0 && n / every < it.reference.times.size() &&
                        it.reference.times[n / every] >= it.scene.from;
    if (counts) study::compare(*run, it.reference.states[n / every], errors);
  }
  return errors;
}

template <class MakeScene>
void add_scene(const std::string& scene, const oracle::Case& problem, MakeScene make_scene) {
  for (const FreePeer& peer : native_peers().free) {
    if (!peer.can(problem)) continue;
    const auto known = std::make_shared<std::optional<Errors>>();
    add(scene + "/" + peer.engine, short_scene, [=, &peer](benchmark::State& state) {
      const BenchScene& it = make_scene();
      const std::size_t steps = study::steps_in(it.scene.duration, h);
      const Targets targets = targets_of(it.scene.problem, peer.aim, h, steps);
      const std::unique_ptr<Peer> run = peer.make(it.scene.problem, targets, h);
      if (!*known) *known = errors_of(*run, it, steps);
      measure(
          state,
          {.scene = it.scene.name,
           .who = peer.engine,
           .num_bodies = it.scene.problem.bodies.size(),
           .peer = true,
           .times = {},
           .instructions = {},
           .errors = **known,
           .contacts = {}},
          steps, [&] { run->restart(); }, [&](std::size_t n) { run->step(n); });
    });
  }
}

}  // namespace

void add_peers() {
  add_scene("S1", study::scene_s1().problem, s1);
  add_scene("S3", study::scene_s3(), s3);
  for (const std::size_t links : {1, 8, 64, 256})
    add_scene("S5/" + std::to_string(links), study::scene_s5(links),
              [links]() -> const BenchScene& { return s5(links); });
}

}  // namespace godobject::bench
