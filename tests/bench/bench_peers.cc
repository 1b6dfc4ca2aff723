// Scenes of bench_step.cc, by the peers found in the build.
#include <memory>

#include "tests/bench/bench.h"
#include "tests/bench/bench_scene.h"
#include "tests/bench/peer/peer.h"
#include "tests/study/compositions.h"

namespace godobject::bench {
namespace {

Targets targets_of(const BenchScene& it, std::size_t steps) {
  Targets all;
  if (!it.scene.is_coupled()) return all;
  for (std::size_t n = 0; n <= steps; ++n) {
    std::vector<oracle::RigidState>& bodies = all.emplace_back();
    for (const oracle::Body& body : it.scene.problem.bodies)
      bodies.push_back(body.coupling->target->at(static_cast<double>(n) * h));
  }
  return all;
}

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
void add_peer(const std::string& scene, const std::string& who, MakePeer make, MakeScene make_scene) {
  const auto known = std::make_shared<std::optional<Errors>>();
  add(scene + "/" + who, short_scene, [=](benchmark::State& state) {
    const BenchScene& it = make_scene();
    const std::size_t steps = study::steps_in(it.scene.duration, h);
    const Targets targets = targets_of(it, steps);
    const std::unique_ptr<Peer> peer = make(it.scene.problem, targets);
    if (!*known) *known = errors_of(*peer, it, steps);
    measure(
        state,
        {.scene = it.scene.name,
         .who = who,
         .num_bodies = it.scene.problem.bodies.size(),
         .peer = true,
         .times = {},
         .instructions = {},
         .errors = **known,
         .contacts = {}},
        steps, [&] { peer->restart(); }, [&](std::size_t n) { peer->step(n); });
  });
}

[[maybe_unused]] void add_chains(const std::string& who, MakePeer make,
                                 const std::vector<std::size_t>& links) {
  for (const std::size_t n : links)
    add_peer("S5/" + std::to_string(n), who, make, [n]() -> const BenchScene& { return s5(n); });
}

}  // namespace

void add_peers() {
#ifdef GODOBJECT_PEER_ODE
  add_peer("S1", "ODE step, explicit force", make_ode_explicit, s1);
  add_peer("S1", "ODE step, motor rows", make_ode, s1);
  add_peer("S3", "ODE step, motor rows", make_ode, s3);
  add_chains("ODE step", make_ode, {1, 8, 64});
#endif
#ifdef GODOBJECT_PEER_BULLET
  add_chains("Bullet f64 btMultiBody", make_bullet, {1, 8, 64, 256});
#endif
#ifdef GODOBJECT_PEER_MUJOCO
  add_chains("MuJoCo Euler", make_mujoco, {1, 8, 64});
#endif
}

}  // namespace godobject::bench
