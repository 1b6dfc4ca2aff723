// One scene with contacts, stepped by us or by a peer.
#pragma once

#include <optional>

#include "tests/bench/bench.h"
#include "tests/bench/contact_quality.h"
#include "tests/bench/peer/native_peers.h"

namespace godobject::bench {

struct Contest {
  ContactScene scene;
  Targets targets = targets_of(scene);
  std::optional<ContactQuality> quality = {};  // measured once

  std::size_t steps() const { return targets.size() - 1; }
};

/// Runner: restart(), step(n), and look(), which inspects the result of the previous step.
template <class Runner, class Look>
void run_contest(benchmark::State& state, const std::string& who, bool peer, Contest& it, Runner& runner,
                 Look look) {
  const auto step = [&](std::size_t n) { runner.step(n); };
  if (!it.quality) {
    runner.restart();
    it.quality = quality_of(it.scene, it.steps(), [&](std::size_t n) {
      step(n);
      return look();
    });
  }
  const Row row{.scene = it.scene.name,
                .who = who,
                .num_bodies = it.scene.problem.bodies.size(),
                .peer = peer,
                .times = {},
                .instructions = {},
                .errors = {},
                .contacts = it.quality};
  measure(
      state, row, it.steps(), [&] { runner.restart(); }, step);
}

}  // namespace godobject::bench
