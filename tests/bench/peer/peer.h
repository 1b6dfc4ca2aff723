// Scenes without contacts in other engines. Unsupported scenes are left out; the files document the set-ups.
// Compiles as C++17 too, for engines whose headers need it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "tests/oracle/case/case.h"

namespace godobject::bench {

inline constexpr double h = 1e-3;  // s, in every benchmark

/// Targets of the bodies: [step][body].
using Targets = std::vector<std::vector<oracle::RigidState>>;

/// Target that a step receives.
struct Aim {
  double share = 1;   // its instant within the step: 0 start, 1 end
  bool mean = false;  // true for the mean velocity of the step
};

/// Returns the targets of `steps` steps of length h; none for a case without coupling.
Targets targets_of(const oracle::Case& problem, const Aim& aim, double h, std::size_t steps);

/// Returns the target of a coupling at t.
oracle::RigidState target_at(const oracle::Coupling& coupling, double t);

/// A scene in another engine.
class Peer {
 public:
  virtual ~Peer() = default;

  virtual void restart() = 0;
  /// Takes step n, from n h to (n + 1) h.
  virtual void step(std::size_t n) = 0;
  /// Returns the pose of body i; its velocities are not set. NaN after a failure that the engine reports.
  virtual oracle::RigidState pose(std::size_t i) const = 0;
};

/// Makes a peer of a case. The peer refers to both arguments; targets are those of every step.
using MakePeer = std::unique_ptr<Peer> (*)(const oracle::Case& problem, const Targets& targets, double h);

/// An engine on scenes without contacts.
struct FreePeer {
  std::string engine;  // with its version and variant, without commas
  Aim aim;
  bool (*can)(const oracle::Case&);  // true for cases that it runs
  MakePeer make;
};

/// Adds a peer to native_peers(). Returns true, for the initialiser of a constant.
bool add_peer(FreePeer peer);

inline bool is_coupled(const oracle::Case& problem) { return problem.bodies.front().coupling.has_value(); }
/// True for chains of up to 64 links: longer ones are too deep or too slow for some peers.
inline bool is_short(const oracle::Case& problem) { return problem.bodies.size() <= 64; }

}  // namespace godobject::bench
