// The scenes with contacts, by the peers found in the build.
#include <memory>

#include "tests/bench/contact_contest.h"

namespace godobject::bench {
namespace {

[[maybe_unused]] void add_peer(const ContactScene& scene, const std::string& who, MakeContactPeer make,
                               const Effort& effort) {
  const auto it = std::make_shared<Contest>(Contest{scene});
  add(scene.name + "/" + who, effort, [=](benchmark::State& state) {
    const std::unique_ptr<ContactPeer> peer = make(it->scene, it->targets);
    run_contest(state, who, true, *it, *peer, [&] {
      Snapshot now;
      now.num_contacts = peer->num_contacts();
      for (std::size_t i = 0; i < it->scene.problem.bodies.size(); ++i) now.bodies.push_back(peer->pose(i));
      return now;
    });
  });
}

}  // namespace

void add_contact_peers() {
  for ([[maybe_unused]] const double k : {1e3, 1e4, 1e5, 1e6}) {
#ifdef GODOBJECT_PEER_ODE
    add_peer(scene_s2(k), "ODE step, spring contacts", make_ode_springs, short_scene);
#endif
#ifdef GODOBJECT_PEER_BULLET
    add_peer(scene_s2(k), "Bullet f64, 10 it", make_bullet_contacts, short_scene);
#endif
#ifdef GODOBJECT_PEER_MUJOCO
    add_peer(scene_s2(k), "MuJoCo Newton, elliptic", make_mujoco_contacts, short_scene);
#endif
  }
#ifdef GODOBJECT_PEER_ODE
  add_peer(scene_s4(64, 20), "ODE QuickStep, 20 it", make_ode_quick, long_scene);
#endif
#ifdef GODOBJECT_PEER_BULLET
  add_peer(scene_s4(64, 20), "Bullet f64, 10 it", make_bullet_contacts, long_scene);
#endif
#ifdef GODOBJECT_PEER_MUJOCO
  // one sweep to and fro: its steps take a millisecond or ten
  add_peer(scene_s4(64, 5), "MuJoCo Newton, the first 5 s", make_mujoco_contacts, long_scene);
#endif
}

}  // namespace godobject::bench
