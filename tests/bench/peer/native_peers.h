// List of the native peers found in the build. A peer is one file of this folder, which adds itself here, and
// one line of CMakeLists.txt.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/bench/net_contest.h"
#include "tests/bench/peer/peer.h"
#include "tests/study/contact/scene.h"

namespace godobject::bench {

/// Peer of a scene with contacts: pose() also returns the velocities.
class ContactPeer : public Peer {
 public:
  /// Number of contacts in the previous step.
  virtual std::size_t num_contacts() const = 0;
};

/// Makes a peer of a scene with contacts, at 1 ms. The peer refers to both arguments; targets are those of
/// the first body alone, at the start and after every step.
using MakeContactPeer = std::unique_ptr<ContactPeer> (*)(const ContactScene& scene, const Targets& targets);

/// Returns the targets of the first body, at the start and after every step.
Targets targets_of(const ContactScene& scene);

/// An engine on scenes with contacts.
struct PressedPeer {
  std::string engine;
  bool (*can)(const ContactScene&);
  double longest;  // s: a slow peer runs the start of a scene alone
  MakeContactPeer make;
};

/// An engine on the hanging net.
struct HangingPeer {
  std::string engine;
  bool is_slow;  // true if a step takes milliseconds
  std::function<std::unique_ptr<NetPeer>()> make;
};

struct NativePeers {
  std::vector<FreePeer> free;
  std::vector<PressedPeer> pressed;
  std::vector<HangingPeer> hanging;
  std::string missing;  // engines that the build has not found, with their packages; empty if none
};

/// Returns the peers of this program.
NativePeers& native_peers();

// Each adds a peer and returns true, for the initialiser of a constant.
bool add_peer(PressedPeer peer);
bool add_peer(HangingPeer peer);

inline bool is_pile(const ContactScene& scene) { return scene.half_extents.has_value(); }

}  // namespace godobject::bench
