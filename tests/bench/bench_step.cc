// Our step: S1 with and without feedback, the grasper S3, chains S5.
#include <memory>

#include "tests/bench/bench.h"
#include "tests/bench/bench_scene.h"
#include "tests/study/compositions.h"

namespace godobject::bench {
namespace {

/// Errors are measured once.
template <Scene S>
void step_scene(benchmark::State& state, const BenchScene& it, const std::string& composition,
                const char* motion) {
  const auto run = std::make_unique<study::CaseRun<S>>(it.scene.problem, h);
  static const Errors errors = study::compare(it.scene, it.reference, *run, h);
  const std::vector<Input<S>> inputs = run->inputs(study::steps_in(it.scene.duration, h), 1e9);
  state.counters["state_bytes"] = sizeof(State<S>);
  state.counters["scratch_bytes"] = sizeof(Scratch<S>);
  measure(
      state,
      {.scene = it.scene.name,
       .who = composition,
       .num_bodies = it.scene.problem.bodies.size(),
       .times = {},
       .instructions = counter().per_step(composition, motion),
       .errors = errors,
       .contacts = {}},
      inputs.size(), [&] { run->restart(); }, [&](std::size_t n) { run->step(inputs[n]); });
}

template <Scene S, class MakeScene>
void add_one(const std::string& scene, const std::string& composition, const char* motion,
             MakeScene make_scene) {
  const std::string name = composition + "-" + std::to_string(S::max_bodies) + " " + S::Integrator::name;
  add(scene + "/" + name, short_scene,
      [=](benchmark::State& state) { step_scene<S>(state, make_scene(), name, motion); });
}

template <std::size_t N>
void add_chain() {
  const auto make_scene = []() -> const BenchScene& { return s5(N); };
  add_one<study::FreeJoints<ImplicitEuler, N>>("S5", "free-joints", "s5", make_scene);
  add_one<study::FreeJoints<TrBdf2, N>>("S5", "free-joints", "s5", make_scene);
}

}  // namespace

void add_ours() {
  add_one<study::Follower<ImplicitEuler, 1>>("S1", "pose", "s1", s1);
  add_one<study::Follower<TrBdf2, 1>>("S1", "pose", "s1", s1);
  add_one<study::Haptic<ImplicitEuler, 1>>("S1", "haptic", "s1", s1);
  add_one<study::Haptic<TrBdf2, 1>>("S1", "haptic", "s1", s1);
  add_one<study::Tool<ImplicitEuler, 4>>("S3", "pose-joints", "s3", s3);
  add_one<study::Tool<TrBdf2, 4>>("S3", "pose-joints", "s3", s3);
  add_chain<1>();
  add_chain<8>();
  add_chain<64>();
  add_chain<256>();
}

}  // namespace godobject::bench
