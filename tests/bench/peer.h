// Scenes of the benchmarks in other engines. What one cannot do is not there; docs of the set-ups are in the files.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tests/oracle/case.h"

namespace godobject::bench {

/// Targets of the bodies after every step, the first at the start: [tick][body].
using Targets = std::vector<std::vector<oracle::RigidState>>;

/// A scene in another engine, stepped at 1 ms.
class Peer {
 public:
  virtual ~Peer() = default;

  virtual void restart() = 0;
  /// From tick n to n + 1.
  virtual void step(std::size_t n) = 0;
  /// Pose of body i; velocities are not asked for.
  virtual oracle::RigidState pose(std::size_t i) const = 0;
};

/// Makes a peer of a case, which both are kept for; targets are empty for a case without coupling.
using MakePeer = std::unique_ptr<Peer> (*)(const oracle::Case& problem, const Targets& targets);

/// ODE's direct step, the couplings as motor rows that make it implicit Euler.
std::unique_ptr<Peer> make_ode(const oracle::Case& problem, const Targets& targets);
/// ODE's direct step, the couplings as forces.
std::unique_ptr<Peer> make_ode_explicit(const oracle::Case& problem, const Targets& targets);
/// Bullet's btMultiBody: reduced coordinates; chains of ball joints only.
std::unique_ptr<Peer> make_bullet(const oracle::Case& problem, const Targets& targets);
/// MuJoCo's Euler: reduced coordinates; chains of ball joints only.
std::unique_ptr<Peer> make_mujoco(const oracle::Case& problem, const Targets& targets);

}  // namespace godobject::bench
