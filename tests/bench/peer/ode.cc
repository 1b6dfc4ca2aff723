// ODE 0.16: maximal coordinates, joints as constraint rows with error reduction, solved directly
// (dWorldStep).
#include <limits>

#include "tests/bench/peer/ode_rows.h"
#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

using oracle::Vector3d;

/// Anchor and axes in world axes, at the bodies' start.
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
  /// rows: true for couplings as rows, else as forces.
  Ode(const oracle::Case& problem, const Targets& targets, double h, bool rows)
      : problem_(problem), targets_(targets), h_(h), rows_(rows) {
    dInitODE2(0);
    world_ = dWorldCreate();
    dWorldSetGravity(world_, problem.gravity.x(), problem.gravity.y(), problem.gravity.z());
    dWorldSetERP(world_, problem.gravity.isZero() ? 0.4 : 0.2);
    dWorldSetCFM(world_, 0);
    for (const oracle::Body& body : problem.bodies) bodies_.push_back(make_body(world_, body));
    restart();
    for (const oracle::Joint& joint : problem.joints) add_joint(joint);
    if (rows)
      for (std::size_t i = 0; i < bodies_.size(); ++i)
        if (problem.bodies[i].coupling)
          motors_.emplace_back(world_, bodies_[i], *problem.bodies[i].coupling, h);
  }
  ~Ode() override {
    dWorldDestroy(world_);
    dCloseODE();
  }
  Ode(const Ode&) = delete;
  Ode& operator=(const Ode&) = delete;

  void restart() override {
    failed_ = false;
    for (std::size_t i = 0; i < bodies_.size(); ++i) place(bodies_[i], problem_.bodies[i].start);
  }

  void step(std::size_t n) override {
    for (std::size_t i = 0; i < bodies_.size() && !targets_.empty(); ++i)
      rows_ ? motors_[i].aim(targets_[n][i]) : add_force(i, targets_[n][i]);
    constexpr double too_fast = 1e6;  // m/s, rad/s; ODE ends the program for numbers that are not finite
    for (const dBodyID body : bodies_)
      failed_ = failed_ || !(vector(dBodyGetLinearVel(body)).norm() < too_fast &&
                             vector(dBodyGetAngularVel(body)).norm() < too_fast);
    if (!failed_) dWorldStep(world_, h_);
  }

  oracle::RigidState pose(std::size_t i) const override {
    oracle::RigidState x = state_of(bodies_[i]);
    if (failed_) x.p.setConstant(std::numeric_limits<double>::quiet_NaN());
    return x;
  }

 private:
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

  void add_force(std::size_t i, const oracle::RigidState& D) {
    const oracle::Coupling& c = *problem_.bodies[i].coupling;
    const oracle::RigidState x = state_of(bodies_[i]);
    const Vector3d f = c.k_t * (D.p - x.p) + c.g_t * (D.v - x.v);
    const Vector3d t = c.k_r * turn_to(D.q, x.q) + c.g_r * (D.w - x.w);
    dBodyAddForce(bodies_[i], f.x(), f.y(), f.z());
    dBodyAddTorque(bodies_[i], t.x(), t.y(), t.z());
  }

  const oracle::Case& problem_;
  const Targets& targets_;
  double h_;
  bool rows_, failed_ = false;
  dWorldID world_;
  std::vector<dBodyID> bodies_;
  std::vector<OdeRows> motors_;
};

template <bool rows>
std::unique_ptr<Peer> make(const oracle::Case& problem, const Targets& targets, double h) {
  return std::make_unique<Ode>(problem, targets, h, rows);
}

bool is_free_and_coupled(const oracle::Case& problem) {
  return is_coupled(problem) && problem.joints.empty();
}

/// With rows a step is one of implicit Euler. An explicit force acts where the step starts.
const bool added =
    add_peer(FreePeer{.engine = "ODE 0.16 motor rows", .aim = {}, .can = is_short, .make = make<true>}) &&
    add_peer(FreePeer{.engine = "ODE 0.16 motor rows (mean velocity)",
                      .aim = {.mean = true},
                      .can = is_coupled,
                      .make = make<true>}) &&
    add_peer(FreePeer{.engine = "ODE 0.16 explicit force",
                      .aim = {.share = 0},
                      .can = is_free_and_coupled,
                      .make = make<false>});

}  // namespace
}  // namespace godobject::bench
