// ODE 0.16: maximal coordinates, joints as constraint rows with error reduction, solved directly (dWorldStep).
//
// A coupling as rows: F = k (x_D+ - x - h v+) + g (v_D+ - v+) is a motor of velocity (k e + g v_D) / (h k + g) with
// e = x_D+ - x, softened by CFM = 1 / (h k + g). The same by axis for the rotation vector: implicit Euler.
#include <ode/ode.h>

#include "tests/bench/bench.h"
#include "tests/bench/peer.h"

namespace godobject::bench {
namespace {

using oracle::Vector3d;

static_assert(sizeof(dReal) == sizeof(double));

/// Anchor and axes in world axes, where the bodies start.
struct Placed {
  Vector3d p, axis_P, axis_C;
};

Placed placed(const oracle::Case& problem, const oracle::Joint& joint) {
  const oracle::RigidState P = joint.parent ? problem.bodies[*joint.parent].start : oracle::RigidState{};
  const oracle::RigidState& C = problem.bodies[joint.child].start;
  return {.p = P.p + P.q * joint.anchor_P, .axis_P = P.q * joint.axis_P, .axis_C = C.q * joint.axis_C};
}

class Ode final : public Peer {
 public:
  Ode(const oracle::Case& problem, const Targets& targets, bool rows)
      : problem_(problem), targets_(targets), rows_(rows) {
    dInitODE2(0);
    world_ = dWorldCreate();
    dWorldSetGravity(world_, problem.gravity.x(), problem.gravity.y(), problem.gravity.z());
    dWorldSetERP(world_, problem.gravity.isZero() ? 0.4 : 0.2);
    dWorldSetCFM(world_, 0);
    for (const oracle::Body& body : problem.bodies) add_body(body);
    restart();
    for (const oracle::Joint& joint : problem.joints) add_joint(joint);
    if (rows)
      for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (problem.bodies[i].coupling) add_rows(i);
  }
  ~Ode() override {
    dWorldDestroy(world_);
    dCloseODE();
  }
  Ode(const Ode&) = delete;
  Ode& operator=(const Ode&) = delete;

  void restart() override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const oracle::RigidState& x = problem_.bodies[i].start;
      const dQuaternion q{x.q.w(), x.q.x(), x.q.y(), x.q.z()};
      dBodySetPosition(bodies_[i], x.p.x(), x.p.y(), x.p.z());
      dBodySetQuaternion(bodies_[i], q);
      dBodySetLinearVel(bodies_[i], x.v.x(), x.v.y(), x.v.z());
      dBodySetAngularVel(bodies_[i], x.w.x(), x.w.y(), x.w.z());
    }
  }

  void step(std::size_t n) override {
    // an explicit force acts where the step starts
    for (std::size_t i = 0; i < bodies_.size() && !targets_.empty(); ++i)
      rows_ ? aim_rows(i, targets_[n + 1][i]) : add_force(i, targets_[n][i]);
    dWorldStep(world_, h);
  }

  oracle::RigidState pose(std::size_t i) const override {
    oracle::RigidState x;
    x.p = vector(dBodyGetPosition(bodies_[i]));
    const dReal* const q = dBodyGetQuaternion(bodies_[i]);
    x.q = {q[0], q[1], q[2], q[3]};
    return x;
  }

 private:
  static Vector3d vector(const dReal* a) { return {a[0], a[1], a[2]}; }

  void add_body(const oracle::Body& body) {
    dMass mass;
    const oracle::Matrix3d& I = body.I_B;
    dMassSetParameters(&mass, body.m, 0, 0, 0, I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
    bodies_.push_back(dBodyCreate(world_));
    dBodySetMass(bodies_.back(), &mass);
    dBodySetGyroscopicMode(bodies_.back(), 1);
  }

  void add_joint(const oracle::Joint& joint) {
    const Placed at = placed(problem_, joint);
    const dBodyID child = bodies_[joint.child], parent = joint.parent ? bodies_[*joint.parent] : nullptr;
    const Vector3d &p = at.p, &a = at.axis_P, &c = at.axis_C;
    if (joint.type == oracle::JointType::ball) {
      const dJointID j = dJointCreateBall(world_, nullptr);
      dJointAttach(j, child, parent);
      dJointSetBallAnchor(j, p.x(), p.y(), p.z());
    } else if (joint.type == oracle::JointType::hinge) {
      const dJointID j = dJointCreateHinge(world_, nullptr);
      dJointAttach(j, child, parent);
      dJointSetHingeAnchor(j, p.x(), p.y(), p.z());
      dJointSetHingeAxis(j, a.x(), a.y(), a.z());
    } else if (joint.type == oracle::JointType::universal) {
      const dJointID j = dJointCreateUniversal(world_, nullptr);
      dJointAttach(j, child, parent);
      dJointSetUniversalAnchor(j, p.x(), p.y(), p.z());
      dJointSetUniversalAxis1(j, c.x(), c.y(), c.z());
      dJointSetUniversalAxis2(j, a.x(), a.y(), a.z());
    } else {  // cylindrical, the last of S1, S3 and S5
      const dJointID j = dJointCreatePiston(world_, nullptr);
      dJointAttach(j, child, parent);
      dJointSetPistonAnchor(j, p.x(), p.y(), p.z());
      dJointSetPistonAxis(j, a.x(), a.y(), a.z());
    }
  }

  void add_rows(std::size_t i) {
    const oracle::Coupling& c = *problem_.bodies[i].coupling;
    const dJointID slide = dJointCreateLMotor(world_, nullptr), turn = dJointCreateAMotor(world_, nullptr);
    dJointAttach(slide, bodies_[i], nullptr);
    dJointAttach(turn, bodies_[i], nullptr);
    dJointSetLMotorNumAxes(slide, 3);
    dJointSetAMotorMode(turn, dAMotorUser);
    dJointSetAMotorNumAxes(turn, 3);
    for (int k = 0; k < 3; ++k) {
      const Vector3d axis = Vector3d::Unit(k);
      const int group = k * dParamGroup;
      dJointSetLMotorAxis(slide, k, 0, axis.x(), axis.y(), axis.z());
      dJointSetAMotorAxis(turn, k, 0, axis.x(), axis.y(), axis.z());
      dJointSetLMotorParam(slide, dParamFMax + group, dInfinity);
      dJointSetAMotorParam(turn, dParamFMax + group, dInfinity);
      dJointSetLMotorParam(slide, dParamCFM + group, 1 / (h * c.k_t + c.g_t));
      dJointSetAMotorParam(turn, dParamCFM + group, 1 / (h * c.k_r + c.g_r));
    }
    motors_.push_back({slide, turn});
  }

  /// From the body's attitude to the target's, world axes.
  static Vector3d turn_to(const oracle::Quaterniond& q_D, const oracle::Quaterniond& q) {
    const Eigen::AngleAxisd turn(q_D * q.conjugate());
    return turn.angle() * turn.axis();
  }

  void aim_rows(std::size_t i, const oracle::RigidState& D) {
    const oracle::Coupling& c = *problem_.bodies[i].coupling;
    const oracle::RigidState x = pose(i);
    const Vector3d v = (c.k_t * (D.p - x.p) + c.g_t * D.v) / (h * c.k_t + c.g_t);
    const Vector3d w = (c.k_r * turn_to(D.q, x.q) + c.g_r * D.w) / (h * c.k_r + c.g_r);
    for (int k = 0; k < 3; ++k) {
      dJointSetLMotorParam(motors_[i].slide, dParamVel + k * dParamGroup, v[k]);
      dJointSetAMotorParam(motors_[i].turn, dParamVel + k * dParamGroup, w[k]);
    }
  }

  void add_force(std::size_t i, const oracle::RigidState& D) {
    const oracle::Coupling& c = *problem_.bodies[i].coupling;
    const oracle::RigidState x = pose(i);
    const Vector3d f = c.k_t * (D.p - x.p) + c.g_t * (D.v - vector(dBodyGetLinearVel(bodies_[i])));
    const Vector3d t = c.k_r * turn_to(D.q, x.q) + c.g_r * (D.w - vector(dBodyGetAngularVel(bodies_[i])));
    dBodyAddForce(bodies_[i], f.x(), f.y(), f.z());
    dBodyAddTorque(bodies_[i], t.x(), t.y(), t.z());
  }

  struct Motors {
    dJointID slide, turn;
  };

  const oracle::Case& problem_;
  const Targets& targets_;
  bool rows_;
  dWorldID world_;
  std::vector<dBodyID> bodies_;
  std::vector<Motors> motors_;
};

}  // namespace

std::unique_ptr<Peer> make_ode(const oracle::Case& problem, const Targets& targets) {
  return std::make_unique<Ode>(problem, targets, true);
}
std::unique_ptr<Peer> make_ode_explicit(const oracle::Case& problem, const Targets& targets) {
  return std::make_unique<Ode>(problem, targets, false);
}

}  // namespace godobject::bench
