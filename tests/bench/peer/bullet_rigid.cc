// Bullet 3.24 in double precision: btRigidBody, maximal coordinates. Joints are rows with error reduction,
// six for each, of which the free ones have no limits. They are solved by 50 iterations of sequential
// impulses, or directly by Dantzig's method. The coupling is the force of implicit_force.h.
#define BT_USE_DOUBLE_PRECISION
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include "tests/bench/peer/bullet_types.h"
#include "tests/bench/peer/implicit_force.h"
#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

/// Returns the axes of a joint's frame: its free turns are x of a hinge, x and y of a universal joint, z of a
/// cylindrical one.
oracle::Quaterniond axes_of(const oracle::Joint& joint) {
  using oracle::Vector3d;
  if (joint.type == oracle::JointType::ball) return oracle::Quaterniond::Identity();
  if (joint.type == oracle::JointType::universal) {
    oracle::Matrix3d R;
    R << joint.axis_C, joint.axis_P, joint.axis_C.cross(joint.axis_P);  // Bullet's child carries x
    return oracle::Quaterniond(R);
  }
  const bool is_hinge = joint.type == oracle::JointType::hinge;
  return oracle::Quaterniond::FromTwoVectors(is_hinge ? Vector3d::UnitX() : Vector3d::UnitZ(), joint.axis_P);
}

/// Returns the numbers of the free rows; rows 0 to 2 are shifts, 3 to 5 turns.
std::vector<int> free_rows(oracle::JointType type) {
  switch (type) {
    case oracle::JointType::ball: return {3, 4, 5};
    case oracle::JointType::hinge: return {3};
    case oracle::JointType::universal: return {3, 4};
    case oracle::JointType::cylindrical: return {2, 5};
    default: throw std::invalid_argument("a case has a joint that bullet_rigid.cc does not make");
  }
}

class BulletRigid final : public Peer {
 public:
  BulletRigid(const oracle::Case& problem, const Targets& targets, double h, bool direct)
      : problem_(problem), targets_(targets), h_(h), direct_(direct) {
    restart();
  }
  ~BulletRigid() override { clear(); }
  BulletRigid(const BulletRigid&) = delete;
  BulletRigid& operator=(const BulletRigid&) = delete;

  /// Makes all objects again, because joints keep impulses from step to step.
  void restart() override {
    clear();
    if (direct_)
      world_.emplace(&dispatcher_, &broadphase_, static_cast<btConstraintSolver*>(&mlcp_), &configuration_);
    else
      world_.emplace(&dispatcher_, &broadphase_, static_cast<btConstraintSolver*>(&impulses_),
                     &configuration_);
    world_->setGravity(vector(problem_.gravity));
    world_->getSolverInfo().m_numIterations = 50;
    world_->getSolverInfo().m_minimumSolverBatchSize = 1;
    for (const oracle::Body& body : problem_.bodies) add(body);
    for (const oracle::Joint& joint : problem_.joints) add(joint);
  }

  void step(std::size_t n) override {
    for (std::size_t i = 0; i < bodies_.size() && !targets_.empty(); ++i) {
      const ForceAndTorque F = implicit_force(problem_.bodies[i], pose(i), targets_[n][i], h_);
      bodies_[i]->applyCentralForce(vector(F.f));
      bodies_[i]->applyTorque(vector(F.tau));
    }
    world_->stepSimulation(h_, 0);
  }

  oracle::RigidState pose(std::size_t i) const override { return state_of(*bodies_[i]); }

 private:
  void clear() {
    for (const auto& joint : joints_) world_->removeConstraint(joint.get());
    for (const auto& body : bodies_) world_->removeRigidBody(body.get());
    joints_.clear();
    bodies_.clear();
    world_.reset();
  }

  void add(const oracle::Body& body) {
    btRigidBody::btRigidBodyConstructionInfo info(body.m, nullptr, &shape_, vector(body.I_B.diagonal()));
    info.m_startWorldTransform = btTransform(quaternion(body.start.q), vector(body.start.p));
    btRigidBody& made = *bodies_.emplace_back(std::make_unique<btRigidBody>(info));
    made.setLinearVelocity(vector(body.start.v));
    made.setAngularVelocity(vector(body.start.w));
    made.setActivationState(DISABLE_DEACTIVATION);
    constexpr int group = 1, no_group = 0;
    world_->addRigidBody(&made, group, no_group);
  }

  void add(const oracle::Joint& joint) {
    const btQuaternion axes = quaternion(axes_of(joint));
    const btTransform P(axes, vector(joint.anchor_P)), C(axes, vector(joint.anchor_C));
    btRigidBody& parent = joint.parent ? *bodies_[*joint.parent] : btTypedConstraint::getFixedBody();
    auto made = std::make_unique<btGeneric6DofSpring2Constraint>(parent, *bodies_[joint.child], P, C);
    for (int row = 0; row < 6; ++row) made->setLimit(row, 0, 0);
    for (const int row : free_rows(joint.type)) made->setLimit(row, 1, -1);
    world_->addConstraint(made.get(), true);
    joints_.push_back(std::move(made));
  }

  const oracle::Case& problem_;
  const Targets& targets_;
  double h_;
  bool direct_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver impulses_;
  btDantzigSolver dantzig_;
  btMLCPSolver mlcp_{&dantzig_};
  btSphereShape shape_{1e-3};  // does not collide
  std::optional<btDiscreteDynamicsWorld> world_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btGeneric6DofSpring2Constraint>> joints_;
};

template <bool direct>
std::unique_ptr<Peer> make(const oracle::Case& problem, const Targets& targets, double h) {
  return std::make_unique<BulletRigid>(problem, targets, h, direct);
}

bool has_joints(const oracle::Case& problem) { return is_short(problem) && !problem.joints.empty(); }

const bool added =
    add_peer(FreePeer{
        .engine = "Bullet 3.24 rigid 50 it", .aim = {.mean = true}, .can = is_short, .make = make<false>}) &&
    add_peer(FreePeer{
        .engine = "Bullet 3.24 rigid direct", .aim = {.mean = true}, .can = has_joints, .make = make<true>});

}  // namespace
}  // namespace godobject::bench
