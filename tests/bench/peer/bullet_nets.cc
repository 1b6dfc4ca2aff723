// Bullet 3.24 in double precision: the hanging net as a btSoftBody, of links without stiffness in N/m.
// Every iteration of its solver moves the ends of each link to its rest length, one link after the other.
// Held nodes have no inverse mass. Its damping is that of our nodes: a velocity loses h g / m of itself in a
// step.
#define BT_USE_DOUBLE_PRECISION
#include <BulletSoftBody/btSoftBody.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <BulletSoftBody/btSoftRigidDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <optional>

#include "tests/bench/peer/native_peers.h"

namespace godobject::bench {
namespace {

btVector3 vector(const Vec3& a) { return {a.x(), a.y(), a.z()}; }

class BulletNetWorld {
 public:
  explicit BulletNetWorld(int iterations) : net_(&world_.getWorldInfo()) {
    const btVector3 gravity(0, 0, -HangingNet::gravity);
    world_.setGravity(gravity);
    btSoftBodyWorldInfo& info = world_.getWorldInfo();
    info.m_gravity = gravity;
    info.m_sparsesdf.Initialize();
    info.m_sparsesdf.setDefaultVoxelsz(HangingNet::spacing);
    btSoftBody::Material* const material = net_.appendMaterial();  // required before the nodes
    material->m_kLST = 1;
    for (std::uint32_t n = 0; n < HangingNet::num_nodes; ++n)
      net_.appendNode(vector(HangingNet::node(n)), HangingNet::is_held(n) ? 0 : HangingNet::m);
    for (const auto& [i, j] : HangingNet::springs())
      net_.appendLink(static_cast<int>(i), static_cast<int>(j), material);
    net_.m_cfg.piterations = iterations;
    net_.m_cfg.kDP = HangingNet::h * HangingNet::g_air / HangingNet::m;
    net_.m_cfg.kDF = HangingNet::mu;
    net_.m_cfg.collisions = btSoftBody::fCollision::SDF_RS;
    net_.getCollisionShape()->setMargin(HangingNet::node_radius);
    world_.addSoftBody(&net_);
    ball_.setCollisionFlags(ball_.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    ball_.setActivationState(DISABLE_DEACTIVATION);
    ball_.setFriction(1);
    world_.addRigidBody(&ball_);
  }
  ~BulletNetWorld() {
    world_.removeRigidBody(&ball_);
    world_.removeSoftBody(&net_);
  }
  BulletNetWorld(const BulletNetWorld&) = delete;
  BulletNetWorld& operator=(const BulletNetWorld&) = delete;

  void step(const Vec3& p, const Vec3& v) {
    ball_.setWorldTransform(btTransform(btQuaternion::getIdentity(), vector(p)));
    ball_.setInterpolationWorldTransform(ball_.getWorldTransform());
    ball_.setLinearVelocity(vector(v));
    world_.stepSimulation(HangingNet::h, 0);
  }
  const btSoftBody& net() const { return net_; }

 private:
  btSoftBodyRigidBodyCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btSoftRigidDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btSphereShape sphere_{HangingNet::ball_radius};
  btRigidBody ball_{btRigidBody::btRigidBodyConstructionInfo(0, nullptr, &sphere_)};
  btSoftBody net_;
};

class BulletNet final : public NetPeer {
 public:
  explicit BulletNet(int iterations) : iterations_(iterations) { restart(); }

  void restart() override { world_.emplace(iterations_); }
  void step(std::size_t n) override {
    const auto [p, v] = HangingNet::ball(static_cast<double>(n + 1) * HangingNet::h);
    world_->step(p, v);
  }
  Vec3 node(std::uint32_t n) const override {
    const btVector3& x = world_->net().m_nodes[static_cast<int>(n)].m_x;
    return {x.x(), x.y(), x.z()};
  }
  std::size_t num_contacts() const override {
    return static_cast<std::size_t>(world_->net().m_rcontacts.size());
  }

 private:
  int iterations_;
  std::optional<BulletNetWorld> world_;
};

HangingPeer soft_body(int iterations) {
  return {.engine = "Bullet 3.24 soft body " + std::to_string(iterations) + " it",
          .is_slow = false,
          .make = [=] { return std::make_unique<BulletNet>(iterations); }};
}

const bool added =
    add_peer(soft_body(1)) && add_peer(soft_body(4)) && add_peer(soft_body(10)) && add_peer(soft_body(50));

}  // namespace
}  // namespace godobject::bench
