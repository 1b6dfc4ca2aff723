// A compiled composition of the core behind one virtual call a step, for programs that choose the scene
// at run time. A product with one scene calls godobject::step on its own scene type instead.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "core/energy.h"
#include "core/gain_watch.h"
#include "core/joint/prescribed.h"
#include "core/net/net.h"
#include "platform/scene/contact/pairs.h"
#include "platform/scene/net/params.h"
#include "platform/scene/scene.h"

namespace godobject {

/// What the devices say for one body; a composition reads the fields its device has.
struct BodySample {
  Target target;  // relative devices: where the device is; its changes count
  Wrench F_WB;    // force of the hand (admittance)
  bool valid = true;
  bool engaged = true;
  bool clutch = true;       // relative devices
  JointMotionSample joint;  // coordinates of the body's joint, if that is imposed
};

/// What one body does.
struct BodyView {
  Pose X_WB;
  Twist V_WB;
  Target target;      // target the body is pulled to (relative devices: built up so far)
  Wrench feedback_D;  // shown to the hand
  Wrench coupling_B;  // (2) at the end of the step; only from view()
  Wrench joint_C;     // of its joint on the body, at the joint's anchor on it; mean over the step
  Wrench contact_W;   // of all its contacts, about its centre of mass; mean over the step
};

/// A contact that bears a force: a sphere of body a, or an edge of its shape, or node a of the nets, on body b or on the
/// world.
struct ContactView {
  std::size_t a = 0, b = world;  // bodies; b: or world
  bool is_node = false;          // a is the number of a node
  std::size_t surface = 0;       // of SceneContacts::surfaces, where b is the world
  Vec3 p_W = Vec3::Zero();       // contact point, m
  Vec3 n_W = Vec3::UnitZ();      // normal, off b
  Vec3 F_W = Vec3::Zero();       // force on a, N; mean over the step
};

/// J, after the last step.
struct EnergyReport {
  double total =
      0;  // of motion, of gravity (zero at the world's origin), in the springs of couplings, contacts, stops
  double balance = 0;  // (38)  without the work that the device and led joints have done: it only falls
  double gained = 0, at_work = 0;  // see GainWatch: how far it has risen within a second, and of what
};

struct StepReport {
  Fault fault = Fault::none;
  Limited limited = Limited::none;
  ContactReport contacts;
  NetReport nets;
};

/// A part of a composition and what it costs in it, for all of the composition's bodies.
struct PartBytes {
  std::string name;  // of the slot in the scene type: "coupling"
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
};

/// The parts of a composition and what they cost.
struct Composition {
  std::string name;  // "rigid-1 tr-bdf2"
  std::string integrator;
  std::size_t max_bodies = 0;
  bool joints = false;  // with all that they can have
  ContactScope contacts = ContactScope::none;
  std::size_t max_spheres = 0, max_surfaces = 0, max_contacts = 0;
  std::size_t max_nodes = 0, max_springs = 0, max_node_contacts = 0,
              max_attachments = 0;  // of nets
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
  std::vector<PartBytes> parts;  // those that have storage

  std::size_t all_contacts() const noexcept { return max_contacts + max_node_contacts; }
  bool has_nets() const noexcept { return max_nodes > 0; }
  std::size_t bytes() const noexcept { return params_bytes + state_bytes + scratch_bytes; }
};

class Engine {
 public:
  virtual ~Engine() = default;

  virtual const Composition& composition() const noexcept = 0;
  /// One time step; `samples` has one entry per body. Real-time: no allocation, no lock, no system call.
  virtual StepReport step(std::span<const BodySample> samples) noexcept = 0;
  /// So many s of the devices' time have passed without a step: a gap in their samples.
  virtual void pass_time(double s) noexcept = 0;
  /// Body i after the last step.
  virtual BodyView view(std::size_t i) const noexcept = 0;
  virtual Wrench feedback(std::size_t i) const noexcept = 0;
  virtual EnergyReport energy() const noexcept = 0;
  /// The contacts that bore a force in the last step, in a lasting order, as far as there is room.
  /// Their number; real-time.
  virtual std::size_t contacts(std::span<ContactView> out) const noexcept = 0;
  /// The scene's nets: nodes, springs, and the triangles between their nodes; constant. Empty without any.
  virtual const SceneNets& nets() const noexcept = 0;
  /// Where their nodes are after the last step, in the world, m, as far as there is room. Their number; real-time.
  virtual std::size_t net_nodes(std::span<Vec3> p_W) const noexcept = 0;
  /// l / l_0 of the spring that is stretched most, after the last step; 0 without any.
  virtual double net_stretch() const noexcept = 0;
  virtual std::uint64_t state_hash() const noexcept = 0;
};

/// Every composition compiled into this program, smallest first.
std::vector<Composition> compositions();

/// The smallest composition that covers the scene, started with the devices' samples at t = 0;
/// null with the reason in `why_not` when none does, or when the core does not take the scene's parameters.
std::unique_ptr<Engine> make_engine(const SceneConfig& scene, std::span<const BodySample> at_start,
                                    std::string& why_not);

}  // namespace godobject
