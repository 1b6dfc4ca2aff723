// The scenes with contacts, by the peers found in the build.
#include <memory>

#include "tests/bench/contact_contest.h"

namespace godobject::bench {
namespace {

void add_peers_on(const ContactScene& scene, const Effort& effort) {
  for (const PressedPeer& peer : native_peers().pressed) {
    if (!peer.can(scene)) continue;
    const bool is_cut = peer.longest < scene.duration;
    ContactScene shown = scene;
    shown.duration = std::min(scene.duration, peer.longest);
    const std::string who =
        peer.engine + (is_cut ? ", the first " + std::to_string(std::lround(peer.longest)) + " s" : "");
    const auto it = std::make_shared<Contest>(Contest{shown});
    add(scene.name + "/" + who, effort, [=, &peer](benchmark::State& state) {
      const std::unique_ptr<ContactPeer> run = peer.make(it->scene, it->targets);
      run_contest(state, who, true, *it, *run, [&] {
        Snapshot now;
        now.num_contacts = run->num_contacts();
        for (std::size_t i = 0; i < it->scene.problem.bodies.size(); ++i) now.bodies.push_back(run->pose(i));
        return now;
      });
    });
  }
}

}  // namespace

void add_contact_peers() {
  for (const double k : {1e3, 1e4, 1e5, 1e6}) add_peers_on(scene_s2(k), short_scene);
  add_peers_on(scene_s4(64, 20), long_scene);
}

}  // namespace godobject::bench
