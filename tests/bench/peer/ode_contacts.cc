// ODE 0.16 with contacts: its direct step, or QuickStep with 20 iterations of successive over-relaxation.
#include "tests/bench/peer/native_peers.h"
#include "tests/bench/peer/ode_rows.h"

namespace godobject::bench {
namespace {

struct Settings {
  bool direct;   // dWorldStep, else dWorldQuickStep
  bool springs;  // contacts of the scene's law, else hard ones
};

class OdeContacts final : public ContactPeer {
 public:
  OdeContacts(const ContactScene& scene, const Targets& targets, const Settings& settings)
      : scene_(scene), targets_(targets), settings_(settings) {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    surface_.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
    surface_.mu = scene.law.mu;
    surface_.soft_erp = settings.springs ? h * scene.law.k / (h * scene.law.k + scene.law.c) : 0.2;
    surface_.soft_cfm = settings.springs ? 1 / (h * scene.law.k + scene.law.c) : 1e-8;
    make();
  }
  ~OdeContacts() override {
    destroy();
    dCloseODE();
  }
  OdeContacts(const OdeContacts&) = delete;
  OdeContacts& operator=(const OdeContacts&) = delete;

  void restart() override {
    destroy();
    make();
  }

  void step(std::size_t n) override {
    coupling_->aim(targets_[n + 1].front());
    dJointGroupEmpty(contacts_);
    num_contacts_ = 0;
    dSpaceCollide(space_, this, &OdeContacts::collide);
    settings_.direct ? dWorldStep(world_, h) : dWorldQuickStep(world_, h);
  }

  oracle::RigidState pose(std::size_t i) const override { return state_of(bodies_[i]); }
  std::size_t num_contacts() const override { return num_contacts_; }

 private:
  /// Makes all objects again, because ODE keeps the order of its lists and the impulses of the previous step.
  void make() {
    dRandSetSeed(0);  // of the order of the rows
    world_ = dWorldCreate();
    space_ = dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
    contacts_ = dJointGroupCreate(0);
    const oracle::Vector3d& gravity = scene_.problem.gravity;
    dWorldSetGravity(world_, gravity.x(), gravity.y(), gravity.z());
    dWorldSetQuickStepNumIterations(world_, 20);
    dCreatePlane(space_, 0, 0, 1, 0);
    for (const oracle::Body& body : scene_.problem.bodies) {
      bodies_.push_back(make_body(world_, body));
      place(bodies_.back(), body.start);
      add_shapes(bodies_.back());
    }
    coupling_.emplace(world_, bodies_.front(), scene_.coupling(), h);
  }
  void destroy() {
    bodies_.clear();
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }

  void add_shapes(dBodyID body) {
    if (scene_.half_extents) {
      const Vec3 edges = 2 * *scene_.half_extents;
      dGeomSetBody(dCreateBox(space_, edges.x(), edges.y(), edges.z()), body);
      return;
    }
    for (const Vec3& c : scene_.centres) {
      const dGeomID sphere = dCreateSphere(space_, scene_.radius);
      dGeomSetBody(sphere, body);
      dGeomSetOffsetPosition(sphere, c.x(), c.y(), c.z());
    }
  }

  static void collide(void* self, dGeomID a, dGeomID b) {
    const dBodyID body_a = dGeomGetBody(a), body_b = dGeomGetBody(b);
    if (body_a != body_b) static_cast<OdeContacts*>(self)->add_contacts(a, b);
  }
  void add_contacts(dGeomID a, dGeomID b) {
    constexpr int max_contacts = 8;  // of a pair of boxes
    dContactGeom found[max_contacts];
    const int num = dCollide(a, b, max_contacts, found, sizeof *found);
    for (int i = 0; i < num; ++i) {
      dContact contact{};
      contact.surface = surface_;
      contact.geom = found[i];
      dJointAttach(dJointCreateContact(world_, contacts_, &contact), dGeomGetBody(a), dGeomGetBody(b));
    }
    num_contacts_ += static_cast<std::size_t>(num);
  }

  const ContactScene& scene_;
  const Targets& targets_;
  Settings settings_;
  dSurfaceParameters surface_{};
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  std::vector<dBodyID> bodies_;
  std::optional<OdeRows> coupling_;
  std::size_t num_contacts_ = 0;
};

template <bool direct>
std::unique_ptr<ContactPeer> make_contacts(const ContactScene& scene, const Targets& targets) {
  return std::make_unique<OdeContacts>(scene, targets, Settings{.direct = direct, .springs = direct});
}

const bool added =
    add_peer(PressedPeer{.engine = "ODE 0.16 step with spring contacts",
                         .can = [](const ContactScene& scene) { return !is_pile(scene); },
                         .longest = 20,
                         .make = make_contacts<true>}) &&
    add_peer(PressedPeer{
        .engine = "ODE 0.16 QuickStep 20 it", .can = is_pile, .longest = 20, .make = make_contacts<false>});

}  // namespace
}  // namespace godobject::bench
