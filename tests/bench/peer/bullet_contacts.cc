// Bullet 3.24 in double precision with contacts: rigid bodies, sequential impulses, no sleeping.
// The coupling is the force of implicit_force.h. A soft row in Bullet's solver diverges.
#define BT_USE_DOUBLE_PRECISION
#include <btBulletDynamicsCommon.h>

#include "tests/bench/peer/bullet_types.h"
#include "tests/bench/peer/implicit_force.h"
#include "tests/bench/peer/native_peers.h"

namespace godobject::bench {
namespace {

btTransform transform(const oracle::RigidState& x) { return btTransform(quaternion(x.q), vector(x.p)); }

/// Shape of all bodies for contacts.
class BulletShape {
 public:
  explicit BulletShape(const ContactScene& scene) {
    if (scene.half_extents) {
      box_ = std::make_unique<btBoxShape>(vector(*scene.half_extents));
      box_->setMargin(0.1 * scene.half_extents->minCoeff());  // part of the box; 4 cm if not set
      return;
    }
    sphere_ = std::make_unique<btSphereShape>(scene.radius);
    row_ = std::make_unique<btCompoundShape>();
    for (const Vec3& c : scene.centres)
      row_->addChildShape(btTransform(btQuaternion::getIdentity(), vector(c)), sphere_.get());
  }
  btCollisionShape* get() const {
    return box_ ? static_cast<btCollisionShape*>(box_.get()) : static_cast<btCollisionShape*>(row_.get());
  }

 private:
  std::unique_ptr<btBoxShape> box_;
  std::unique_ptr<btSphereShape> sphere_;
  std::unique_ptr<btCompoundShape> row_;
};

class BulletWorld {
 public:
  BulletWorld(const ContactScene& scene, BulletShape& shape) {
    world_.setGravity(vector(scene.problem.gravity));
    world_.getSolverInfo().m_numIterations = 10;
    const double friction = std::sqrt(scene.law.mu);  // that of a pair is the product
    ground_.setFriction(friction);
    world_.addRigidBody(&ground_);
    for (const oracle::Body& body : scene.problem.bodies) {
      btRigidBody::btRigidBodyConstructionInfo info(body.m, nullptr, shape.get(),
                                                    vector(body.I_B.diagonal()));
      info.m_startWorldTransform = transform(body.start);
      info.m_friction = friction;
      bodies_.push_back(std::make_unique<btRigidBody>(info));
      bodies_.back()->setActivationState(DISABLE_DEACTIVATION);
      world_.addRigidBody(bodies_.back().get());
    }
  }
  ~BulletWorld() {
    for (const auto& body : bodies_) world_.removeRigidBody(body.get());
    world_.removeRigidBody(&ground_);
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  btRigidBody& body(std::size_t i) { return *bodies_[i]; }
  void step() { world_.stepSimulation(h, 0); }
  std::size_t num_contacts() {
    int num = 0;
    for (int i = 0; i < dispatcher_.getNumManifolds(); ++i)
      num += dispatcher_.getManifoldByIndexInternal(i)->getNumContacts();
    return static_cast<std::size_t>(num);
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btStaticPlaneShape plane_{btVector3(0, 0, 1), 0};
  btRigidBody ground_{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &plane_)};
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
};

class BulletContacts final : public ContactPeer {
 public:
  BulletContacts(const ContactScene& scene, const Targets& targets)
      : scene_(scene), targets_(targets), shape_(scene) {
    world_.emplace(scene_, shape_);
  }

  /// Makes all objects again, because contacts keep impulses from step to step.
  void restart() override { world_.emplace(scene_, shape_); }

  void step(std::size_t n) override {
    pull(targets_[n + 1].front());
    world_->step();
  }

  oracle::RigidState pose(std::size_t i) const override { return state_of(world_->body(i)); }
  std::size_t num_contacts() const override { return world_->num_contacts(); }

 private:
  void pull(const oracle::RigidState& D) {
    const ForceAndTorque F = implicit_force(scene_.problem.bodies.front(), pose(0), D, h);
    world_->body(0).applyCentralForce(vector(F.f));
    world_->body(0).applyTorque(vector(F.tau));
  }

  const ContactScene& scene_;
  const Targets& targets_;
  BulletShape shape_;
  mutable std::optional<BulletWorld> world_;  // its getters are not const
};

const bool added = add_peer(PressedPeer{
    .engine = "Bullet 3.24 10 it",
    .can = [](const ContactScene&) { return true; },
    .longest = 20,
    .make = [](const ContactScene& scene, const Targets& targets) -> std::unique_ptr<ContactPeer> {
      return std::make_unique<BulletContacts>(scene, targets);
    }});

}  // namespace
}  // namespace godobject::bench
