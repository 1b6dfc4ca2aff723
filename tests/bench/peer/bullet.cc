// Bullet 3.24 in double precision: btMultiBody, reduced coordinates by Featherstone's algorithm. No
// constraint is in its world.
#define BT_USE_DOUBLE_PRECISION
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <stdexcept>

#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

btVector3 vector(const oracle::Vector3d& a) { return {a.x(), a.y(), a.z()}; }
btQuaternion quaternion(const oracle::Quaterniond& q) { return {q.x(), q.y(), q.z(), q.w()}; }

class BulletChain final : public Peer {
 public:
  explicit BulletChain(const oracle::Case& problem)
      : num_links_(static_cast<int>(problem.bodies.size())),
        chain_(num_links_, 0, btVector3(0, 0, 0), true, false) {
    oracle::Quaterniond q_P = oracle::Quaterniond::Identity();
    for (int i = 0; i < num_links_; ++i) {
      const oracle::Body& body = problem.bodies[static_cast<std::size_t>(i)];
      const oracle::Joint& joint = problem.joints[static_cast<std::size_t>(i)];
      if (joint.type != oracle::JointType::ball) throw std::invalid_argument("chains of ball joints only");
      chain_.setupSpherical(i, body.m, vector(body.I_B.diagonal()), i - 1,
                            quaternion(body.start.q.conjugate() * q_P), vector(joint.anchor_P),
                            vector(-joint.anchor_C), true);
      q_P = body.start.q;
    }
    chain_.finalizeMultiDof();
    chain_.setLinearDamping(0);
    chain_.setAngularDamping(0);
    world_.setGravity(vector(problem.gravity));
    world_.addMultiBody(&chain_);
  }
  ~BulletChain() override { world_.removeMultiBody(&chain_); }
  BulletChain(const BulletChain&) = delete;
  BulletChain& operator=(const BulletChain&) = delete;

  void restart() override {
    const btScalar q[] = {0, 0, 0, 1}, w[] = {0, 0, 0};
    for (int i = 0; i < num_links_; ++i) {
      chain_.setJointPosMultiDof(i, q);
      chain_.setJointVelMultiDof(i, w);
    }
  }

  void step(std::size_t) override { world_.stepSimulation(h, 0); }

  oracle::RigidState pose(std::size_t i) const override {
    if (i == 0) chain_.forwardKinematics(rotations_, origins_);
    const btTransform& X = chain_.getLink(static_cast<int>(i)).m_cachedWorldTransform;
    const btVector3 p = X.getOrigin();
    const btQuaternion q = X.getRotation();
    oracle::RigidState x;
    x.p = {p.x(), p.y(), p.z()};
    x.q = {q.w(), q.x(), q.y(), q.z()};
    return x;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  int num_links_;
  mutable btMultiBody chain_;  // its poses are computed on request
  mutable btAlignedObjectArray<btQuaternion> rotations_;
  mutable btAlignedObjectArray<btVector3> origins_;
};

}  // namespace

std::unique_ptr<Peer> make_bullet(const oracle::Case& problem, const Targets&) {
  return std::make_unique<BulletChain>(problem);
}

}  // namespace godobject::bench
