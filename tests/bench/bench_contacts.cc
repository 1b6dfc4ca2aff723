// Our step on the scenes with contacts: the pressed tool S2, the bricks S4, and the cost by their number.
#include <memory>

#include "tests/bench/contact_contest.h"
#include "tests/bench/contact_run.h"
#include "tests/study/compositions.h"

namespace godobject::bench {
namespace {

template <Scene S>
void add_run(const ContactScene& scene, const std::string& who, const Effort& effort) {
  const auto it = std::make_shared<Contest>(Contest{scene});
  add(scene.name + "/" + who, effort, [=](benchmark::State& state) {
    const auto run = std::make_unique<ContactRun<S>>(it->scene, it->targets);
    state.counters["state_bytes"] = sizeof(State<S>);
    state.counters["scratch_bytes"] = sizeof(Scratch<S>);
    run_contest(state, who, false, *it, *run, [&] { return run->snapshot(); });
  });
}

}  // namespace

void add_our_contacts() {
  for (const double k : {1e3, 1e4, 1e5, 1e6}) {
    add_run<study::PressedTool<ImplicitEuler, 1>>(scene_s2(k), "fixed-contacts implicit-euler", short_scene);
    add_run<study::PressedTool<TrBdf2, 1>>(scene_s2(k), "fixed-contacts tr-bdf2", short_scene);
  }
  add_run<study::Bricks<ImplicitEuler, 64>>(scene_s4(64, 20), "implicit-euler", long_scene);
  // the same, with one capacity for all
  for (const std::size_t n : {16, 64, 128, 256, 512}) {
    ContactScene scene = scene_s4(n, 20);
    scene.name = "of " + std::to_string(n);
    add_run<study::Bricks<ImplicitEuler, 512>>(scene, "room for 512, implicit-euler", long_scene);
  }
}

}  // namespace godobject::bench
