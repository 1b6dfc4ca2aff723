// Bullet 3.24 in double precision: btMultiBody, reduced coordinates by Featherstone's algorithm. No
// constraint is in its world. A free body is a base without links; its coupling is the force of
// implicit_force.h.
#define BT_USE_DOUBLE_PRECISION
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include <stdexcept>

#include "tests/bench/peer/bullet_types.h"
#include "tests/bench/peer/implicit_force.h"
#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

struct MultiBodyWorld {
  btDefaultCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  btMultiBodyConstraintSolver solver;
  btMultiBodyDynamicsWorld world{&dispatcher, &broadphase, &solver, &configuration};
};

class BulletBase final : public Peer {
 public:
  BulletBase(const oracle::Case& problem, const Targets& targets, double h)
      : body_(problem.bodies.front()),
        targets_(targets),
        h_(h),
        base_(0, body_.m, vector(body_.I_B.diagonal()), false, false) {
    base_.finalizeMultiDof();
    base_.setLinearDamping(0);
    base_.setAngularDamping(0);
    in_.world.setGravity(vector(problem.gravity));
    in_.world.addMultiBody(&base_);
    restart();
  }
  ~BulletBase() override { in_.world.removeMultiBody(&base_); }
  BulletBase(const BulletBase&) = delete;
  BulletBase& operator=(const BulletBase&) = delete;

  void restart() override {
    base_.setBaseWorldTransform(btTransform(quaternion(body_.start.q), vector(body_.start.p)));
    base_.setBaseVel(vector(body_.start.v));
    base_.setBaseOmega(vector(body_.start.w));
  }

  void step(std::size_t n) override {
    oracle::RigidState x = pose(0);
    x.v = vector(base_.getBaseVel());
    x.w = vector(base_.getBaseOmega());
    const ForceAndTorque F = implicit_force(body_, x, targets_[n].front(), h_);
    base_.addBaseForce(vector(F.f));
    base_.addBaseTorque(vector(F.tau));
    in_.world.stepSimulation(h_, 0);
  }

  oracle::RigidState pose(std::size_t) const override { return state_of(base_.getBaseWorldTransform()); }

 private:
  const oracle::Body& body_;
  const Targets& targets_;
  double h_;
  MultiBodyWorld in_;
  btMultiBody base_;
};

class BulletChain final : public Peer {
 public:
  BulletChain(const oracle::Case& problem, double h)
      : h_(h),
        num_links_(static_cast<int>(problem.bodies.size())),
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
    in_.world.setGravity(vector(problem.gravity));
    in_.world.addMultiBody(&chain_);
  }
  ~BulletChain() override { in_.world.removeMultiBody(&chain_); }
  BulletChain(const BulletChain&) = delete;
  BulletChain& operator=(const BulletChain&) = delete;

  void restart() override {
    const btScalar q[] = {0, 0, 0, 1}, w[] = {0, 0, 0};
    for (int i = 0; i < num_links_; ++i) {
      chain_.setJointPosMultiDof(i, q);
      chain_.setJointVelMultiDof(i, w);
    }
  }

  void step(std::size_t) override { in_.world.stepSimulation(h_, 0); }

  oracle::RigidState pose(std::size_t i) const override {
    if (i == 0) chain_.forwardKinematics(rotations_, origins_);
    return state_of(chain_.getLink(static_cast<int>(i)).m_cachedWorldTransform);
  }

 private:
  double h_;
  MultiBodyWorld in_;
  int num_links_;
  mutable btMultiBody chain_;  // its poses are computed on request
  mutable btAlignedObjectArray<btQuaternion> rotations_;
  mutable btAlignedObjectArray<btVector3> origins_;
};

bool is_free_or_chain(const oracle::Case& problem) { return is_coupled(problem) == problem.joints.empty(); }

std::unique_ptr<Peer> make(const oracle::Case& problem, const Targets& targets, double h) {
  if (is_coupled(problem)) return std::make_unique<BulletBase>(problem, targets, h);
  return std::make_unique<BulletChain>(problem, h);
}

const bool added = add_peer(FreePeer{
    .engine = "Bullet 3.24 multibody", .aim = {.mean = true}, .can = is_free_or_chain, .make = make});

}  // namespace
}  // namespace godobject::bench
