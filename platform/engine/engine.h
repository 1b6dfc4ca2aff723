// A compiled composition of the core behind one virtual call a step, for programs that load scenes at run
// time. A product with one scene calls godobject::step on its own scene type instead.
#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/contact/contact.h"
#include "core/energy.h"
#include "core/gain_watch.h"
#include "core/joint/prescribed.h"
#include "core/net/net.h"
#include "core/nonblocking.h"
#include "core/validity.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/net/params.h"
#include "platform/scene/scene.h"

namespace godobject {

/// Device sample for one body; a composition reads the fields of its device.
struct BodySample {
  Target target;  // relative devices: pose of the device, of which the changes count
  Wrench F_WB;    // force of the hand (admittance)
  bool valid = true;
  bool engaged = true;
  bool clutch = true;       // relative devices
  JointMotionSample joint;  // coordinates of the body's joint, if prescribed
};

/// State of one body after a step.
struct BodyView {
  Pose X_WB;
  Twist V_WB;
  Target target;      // target of the body (relative devices: accumulated so far)
  Wrench feedback_D;  // displayed to the hand
  Wrench coupling_B;  // coupling wrench at the end of the step (2); only from view()
  Wrench joint_C;     // wrench of its joint on the body, about the joint's anchor on it; mean over the step
  Wrench contact_W;   // sum of its contact wrenches, about its centre of mass; mean over the step
};

/// Plane of another simulation, touched like an obstacle, without friction.
struct ContactPlane {
  Vec3 p_W = Vec3::Zero(), n_W = Vec3::UnitZ();  // a point, m; normal, out of the solid
  double k = 0, c = 0;                           // N/m, N s/m
};

/// A contact that bears a force. The force acts on a sphere or shape edge of body a, or on node a of the
/// nets. Its counterpart is body b, the world, or the surface of a net.
struct ContactView {
  std::size_t a = 0, b = world;  // bodies; b: or world
  bool is_node = false;          // true if a is the number of a node
  bool is_on_net = false;        // true if b is the number of a node of the touched triangle
  std::size_t surface = 0;       // index in SceneContacts::surfaces, if b is the world
  Vec3 p_W = Vec3::Zero();       // contact point, m
  Vec3 n_W = Vec3::UnitZ();      // normal, out of b
  Vec3 F_W = Vec3::Zero();       // force on a, N; mean over the step
};

/// Energies after the last step, J.
struct EnergyReport {
  double total =
      0;  // kinetic, gravitational (zero at the world's origin), and of the springs of couplings, contacts,
          // stops and nets
  double balance = 0;  // total without the work of the device and of prescribed joints (38); never increases
  double gained = 0, at_work = 0;  // increase within a second, and the energy it is compared with: see
                                   // GainWatch
};

struct StepReport {
  Fault fault = Fault::none;
  Limited limited = Limited::none;
  ContactReport contacts;
  NetReport nets;
};

/// Memory of one part of a composition, for all of the composition's bodies.
struct PartBytes {
  std::string name;  // name of the slot in the scene type: "coupling"
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
};

/// Parts of a composition and their memory.
struct Composition {
  std::string name;  // "rigid-1 tr-bdf2"
  std::string integrator;
  std::size_t max_bodies = 0;
  bool joints = false;  // true if it has all features of joints
  ContactScope contacts = ContactScope::none;
  std::size_t max_spheres = 0, max_surfaces = 0, max_contacts = 0;
  std::size_t max_nodes = 0, max_springs = 0, max_node_contacts = 0, max_attachments = 0,
              max_faces = 0;  // of nets
  std::size_t params_bytes = 0, state_bytes = 0, scratch_bytes = 0;
  std::vector<PartBytes> parts;  // those that have storage

  std::size_t all_contacts() const noexcept { return max_contacts + max_node_contacts; }
  std::size_t max_terms = 0;  // springs; and as many gears, closing joints, forces

  bool has_terms() const noexcept { return max_terms > 0; }
  bool has_nets() const noexcept { return max_nodes > 0; }
  std::size_t bytes() const noexcept { return params_bytes + state_bytes + scratch_bytes; }
};

class Engine {
 public:
  virtual ~Engine() = default;

  virtual const Composition& composition() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Runs one time step. samples: one per body. Real-time: no allocation, no lock, no system call.
  virtual StepReport step(std::span<const BodySample> samples) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Passes time without a step, which is a gap in the devices' samples. s: duration, s.
  virtual void pass_time(double s) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the state of body i after the last step.
  virtual BodyView view(std::size_t i) const noexcept GODOBJECT_NONBLOCKING = 0;
  virtual Wrench feedback(std::size_t i) const noexcept GODOBJECT_NONBLOCKING = 0;
  virtual EnergyReport energy() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Lists the contacts that bore a force in the last step, in a stable order, as far as `out` has space.
  /// Returns their number. Real-time.
  virtual std::size_t contacts(std::span<ContactView> out) const noexcept GODOBJECT_NONBLOCKING = 0;
  /// The scene's nets: nodes, springs, and the triangles between their nodes; constant. Empty without nets.
  virtual const SceneNets& nets() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Writes the positions of the nets' nodes after the last step, world, m, as far as p_W has space. Returns
  /// their number. Real-time.
  virtual std::size_t net_nodes(std::span<Vec3> p_W) const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Largest ratio l / l_0 of all net springs after the last step; 0 without nets.
  virtual double net_stretch() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Writes the wrenches of springs, gears and closing joints, means over the last step, in the order of
  /// term_names(), as far as F_W has space. Each is on the second end about its point, in world axes; that of
  /// a gear acts along coordinate b. Real-time.
  virtual void term_forces(std::span<Wrench> F_W) const noexcept GODOBJECT_NONBLOCKING = 0;
  virtual std::uint64_t state_hash() const noexcept GODOBJECT_NONBLOCKING = 0;

  // Planes of another simulation: see SceneConfig::world_planes.

  /// Returns SceneContacts::surfaces index of the first plane.
  virtual std::size_t first_plane() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Moves plane i before a step. The plane is at rest during the step. Real-time.
  virtual void set_plane(std::size_t i, const ContactPlane& plane) noexcept GODOBJECT_NONBLOCKING = 0;
  /// Returns the depth of the deepest sphere or shape of all bodies below a plane, m; negative if it is above
  /// the plane, -infinity without contacts. Real-time.
  virtual double depth_below(const Vec3& p_W, const Vec3& n_W) const noexcept GODOBJECT_NONBLOCKING = 0;

  // Snapshots: all that a step leaves to the next, as the bytes of this build of this composition.

  /// Returns the size of a snapshot, a multiple of eight bytes.
  virtual std::size_t snapshot_bytes() const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Writes a snapshot. Real-time. out: snapshot_bytes() bytes.
  virtual void save(std::span<std::byte> out) const noexcept GODOBJECT_NONBLOCKING = 0;
  /// Continues from a snapshot of the same scene, composition and build. Returns false if it is none; then
  /// this engine cannot be used any more.
  virtual bool restore(std::span<const std::byte> in) noexcept = 0;
};

/// One row of the table of compositions.
struct CompositionRow {
  Composition composition;
  std::unique_ptr<Engine> (*make)(const SceneConfig&, std::span<const BodySample>, const Composition&,
                                  Validity&);
};

// One file each, and one line in engine.cc.
void add_free(std::vector<CompositionRow>& table);
void add_contacts(std::vector<CompositionRow>& table);
void add_many(std::vector<CompositionRow>& table);
void add_terms(std::vector<CompositionRow>& table);

/// Returns every composition compiled into this program, smallest first.
std::vector<Composition> compositions();

/// Makes the smallest composition that covers the scene, started with the devices' samples at t = 0.
/// Null with the reason in `why_not` if no composition covers it, or if the core rejects the scene's
/// parameters.
std::unique_ptr<Engine> make_engine(const SceneConfig& scene, std::span<const BodySample> at_start,
                                    std::string& why_not);

}  // namespace godobject
