// MuJoCo 2.2 with contacts: semi-implicit Euler, its Newton solver with defaults: 100 iterations, tolerance
// 1e-8.
// The pulled body has three slides and a ball joint. Their dampers are implicit; their springs follow the
// target and are explicit. The target is that of the start of the step.
#include "tests/bench/peer/mujoco_model.h"
#include "tests/bench/peer/native_peers.h"

namespace godobject::bench {
namespace {

void write_joints(std::ostream& xml, const oracle::Coupling& c) {
  for (const char* const axis : {"1 0 0", "0 1 0", "0 0 1"})
    xml << "<joint type='slide' axis='" << axis << "' stiffness='" << c.k_t << "' damping='" << c.g_t
        << "'/>";
  xml << "<joint type='ball' stiffness='" << c.k_r << "' damping='" << c.g_r << "'/>";
}

void write_shapes(std::ostream& xml, const ContactScene& scene) {
  if (scene.half_extents) {
    xml << "<geom type='box' size='" << numbers(*scene.half_extents) << "'/>";
    return;
  }
  for (const Vec3& c : scene.centres)
    xml << "<geom type='sphere' size='" << scene.radius << "' pos='" << numbers(c) << "'/>";
}

/// The cones and the restoration rate of contacts are the best found.
std::string model_of(const ContactScene& scene) {
  std::ostringstream xml;
  xml.precision(17);
  xml << "<mujoco><compiler inertiafromgeom='false' boundmass='0' boundinertia='0'/>"
      << "<size njmax='8000' nconmax='2000' nstack='20000000'/><option timestep='" << h << "' gravity='"
      << numbers(scene.problem.gravity) << "' integrator='Euler' solver='Newton' cone='"
      << (scene.half_extents ? "pyramidal" : "elliptic") << "'/><default><geom friction='" << scene.law.mu
      << " 0 0' solref='" << (scene.half_extents ? 0.004 : 0.02) << " 1'/></default>"
      << "<worldbody><geom type='plane' size='0 0 1'/>";
  for (const oracle::Body& body : scene.problem.bodies) {
    xml << "<body>";
    if (body.coupling) write_joints(xml, *body.coupling);
    else xml << "<freejoint/>";
    xml << "<inertial pos='0 0 0' mass='" << body.m << "' diaginertia='" << numbers(body.I_B.diagonal())
        << "'/>";
    write_shapes(xml, scene);
    xml << "</body>";
  }
  xml << "</worldbody></mujoco>";
  return xml.str();
}

class MujocoContacts final : public ContactPeer {
 public:
  MujocoContacts(const ContactScene& scene, const Targets& targets)
      : scene_(scene), targets_(targets), model_(load(model_of(scene))), data_(mj_makeData(model_)) {
    restart();
  }
  ~MujocoContacts() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  MujocoContacts(const MujocoContacts&) = delete;
  MujocoContacts& operator=(const MujocoContacts&) = delete;

  void restart() override {
    mj_resetData(model_, data_);
    for (std::size_t i = 0; i < scene_.problem.bodies.size(); ++i)
      write_pose(scene_.problem.bodies[i].start, data_->qpos + 7 * i);
  }

  void step(std::size_t n) override {
    pull(targets_[n].front());
    mj_step(model_, data_);
  }

  /// Slides and a ball have the coordinates a free joint has.
  oracle::RigidState pose(std::size_t i) const override {
    const mjtNum* const q = data_->qpos + 7 * i;
    const mjtNum* const v = data_->qvel + 6 * i;
    oracle::RigidState x;
    x.p = {q[0], q[1], q[2]};
    x.q = oracle::Quaterniond(q[3], q[4], q[5], q[6]).normalized();
    x.v = {v[0], v[1], v[2]};
    x.w = x.q * oracle::Vector3d(v[3], v[4], v[5]);
    return x;
  }
  std::size_t num_contacts() const override { return static_cast<std::size_t>(data_->ncon); }

 private:
  static void write_pose(const oracle::RigidState& x, mjtNum* q) {
    const mjtNum numbers[] = {x.p.x(), x.p.y(), x.p.z(), x.q.w(), x.q.x(), x.q.y(), x.q.z()};
    std::copy_n(numbers, 7, q);
  }

  void pull(const oracle::RigidState& D) {
    const oracle::Coupling& c = scene_.coupling();
    write_pose(D, model_->qpos_spring);
    const oracle::Vector3d f = c.g_t * D.v, t_B = c.g_r * (pose(0).q.conjugate() * D.w);
    std::copy_n(f.data(), 3, data_->qfrc_applied);
    std::copy_n(t_B.data(), 3, data_->qfrc_applied + 3);
  }

  const ContactScene& scene_;
  const Targets& targets_;
  mjModel* model_;
  mjData* data_;
};

/// In a pile its steps take a millisecond or ten: 5 s are one sweep to and fro.
const bool added = add_peer(PressedPeer{
    .engine = "MuJoCo 2.2 Newton",
    .can = [](const ContactScene&) { return true; },
    .longest = 5,
    .make = [](const ContactScene& scene, const Targets& targets) -> std::unique_ptr<ContactPeer> {
      return std::make_unique<MujocoContacts>(scene, targets);
    }});

}  // namespace
}  // namespace godobject::bench
