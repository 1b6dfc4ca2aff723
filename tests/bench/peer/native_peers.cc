#include "tests/bench/peer/native_peers.h"

#include <cmath>
#include <utility>

#include "tests/oracle/target.h"

namespace godobject::bench {

NativePeers& native_peers() {
  static NativePeers all{.free = {}, .pressed = {}, .hanging = {}, .missing = GODOBJECT_MISSING_PEERS};
  return all;
}

bool add_peer(FreePeer peer) { return native_peers().free.push_back(std::move(peer)), true; }
bool add_peer(PressedPeer peer) { return native_peers().pressed.push_back(std::move(peer)), true; }
bool add_peer(HangingPeer peer) { return native_peers().hanging.push_back(std::move(peer)), true; }

oracle::RigidState target_at(const oracle::Coupling& coupling, double t) { return coupling.target->at(t); }

Targets targets_of(const oracle::Case& problem, const Aim& aim, double h, std::size_t steps) {
  Targets all;
  if (!is_coupled(problem)) return all;
  for (std::size_t n = 0; n < steps; ++n) {
    const double start = static_cast<double>(n) * h;
    std::vector<oracle::RigidState>& bodies = all.emplace_back();
    for (const oracle::Body& body : problem.bodies) {
      const oracle::Target& target = *body.coupling->target;
      oracle::RigidState& D = bodies.emplace_back(target.at(start + aim.share * h));
      if (!aim.mean) continue;
      D.v = (target.at(start + h).p - target.at(start).p) / h;
      D.w = target.at(start + h / 2).w;
    }
  }
  return all;
}

Targets targets_of(const ContactScene& scene) {
  Targets all;
  for (long n = 0; n <= std::lround(scene.duration / h); ++n)
    all.push_back({target_at(scene.coupling(), static_cast<double>(n) * h)});
  return all;
}

}  // namespace godobject::bench
