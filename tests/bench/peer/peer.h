// Scenes of the benchmarks in other engines. Unsupported scenes are left out; the files document the set-ups.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "tests/study/contact/scene.h"

namespace godobject::bench {

inline constexpr double h = 1e-3;  // s, in every benchmark

/// Targets of the bodies after every step, the first at the start: [tick][body].
using Targets = std::vector<std::vector<oracle::RigidState>>;

/// A scene in another engine.
class Peer {
 public:
  virtual ~Peer() = default;

  virtual void restart() = 0;
  /// From tick n to n + 1.
  virtual void step(std::size_t n) = 0;
  /// Returns the pose of body i; its velocities are not set.
  virtual oracle::RigidState pose(std::size_t i) const = 0;
};

/// Peer of a scene with contacts: pose() also returns the velocities.
class ContactPeer : public Peer {
 public:
  /// Number of contacts in the previous step.
  virtual std::size_t num_contacts() const = 0;
};

/// Makes a peer of a case. The peer refers to both arguments; targets are empty for a case without coupling.
using MakePeer = std::unique_ptr<Peer> (*)(const oracle::Case& problem, const Targets& targets);

/// ODE's direct step, the couplings as motor rows that make it implicit Euler.
std::unique_ptr<Peer> make_ode(const oracle::Case& problem, const Targets& targets);
/// ODE's direct step, the couplings as forces.
std::unique_ptr<Peer> make_ode_explicit(const oracle::Case& problem, const Targets& targets);
/// Bullet's btMultiBody: reduced coordinates; chains of ball joints only.
std::unique_ptr<Peer> make_bullet(const oracle::Case& problem, const Targets& targets);
/// MuJoCo's Euler: reduced coordinates; chains of ball joints only.
std::unique_ptr<Peer> make_mujoco(const oracle::Case& problem, const Targets& targets);

/// Makes a peer of a scene with contacts. The peer refers to both arguments; targets are those of the first
/// body alone.
using MakeContactPeer = std::unique_ptr<ContactPeer> (*)(const ContactScene& scene, const Targets& targets);

/// ODE's direct step, motor rows, contacts that are the springs of the scene's law.
std::unique_ptr<ContactPeer> make_ode_springs(const ContactScene& scene, const Targets& targets);
/// ODE's QuickStep, 20 iterations, motor rows, hard contacts.
std::unique_ptr<ContactPeer> make_ode_quick(const ContactScene& scene, const Targets& targets);
/// Bullet's sequential impulses, 10 iterations; the coupling is a force with an implicit denominator.
std::unique_ptr<ContactPeer> make_bullet_contacts(const ContactScene& scene, const Targets& targets);
/// MuJoCo's Newton solver; the coupling is springs and implicit dampers on slides and a ball.
std::unique_ptr<ContactPeer> make_mujoco_contacts(const ContactScene& scene, const Targets& targets);

}  // namespace godobject::bench
