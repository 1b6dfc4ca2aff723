// Simbody 3.7: reduced coordinates. Runge-Kutta-Merson in fixed steps, or CPodes, an implicit multi-step
// method (BDF), which chooses its steps for an accuracy of (h / 1 s)^2. Both evaluate the coupling and its
// target at any instant within the step.
#include <limits>
#include <stdexcept>

#include <Simbody.h>

#include "tests/bench/peer/peer.h"

namespace godobject::bench {
namespace {

using oracle::RigidState;
using oracle::Vector3d;

SimTK::Vec3 vector(const Vector3d& a) { return {a.x(), a.y(), a.z()}; }
Vector3d vector(const SimTK::Vec3& a) { return {a[0], a[1], a[2]}; }
SimTK::Rotation rotation(const oracle::Quaterniond& q) {
  return SimTK::Rotation(SimTK::Quaternion(q.w(), q.x(), q.y(), q.z()));
}
SimTK::Transform transform(const RigidState& x) { return {rotation(x.q), vector(x.p)}; }
RigidState state_of(const SimTK::MobilizedBody& body, const SimTK::State& state) {
  const SimTK::Quaternion q = body.getBodyRotation(state).convertRotationToQuaternion();
  RigidState x;
  x.p = vector(body.getBodyOriginLocation(state));
  x.q = {q[0], q[1], q[2], q[3]};
  return x;
}

class Couplings final : public SimTK::Force::Custom::Implementation {
 public:
  Couplings(const oracle::Case& problem, const std::vector<SimTK::MobilizedBody>& bodies)
      : problem_(problem), bodies_(bodies) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& on_bodies,
                 SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector&) const override {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const oracle::Coupling& c = *problem_.bodies[i].coupling;
      const RigidState D = target_at(c, state.getTime());
      const RigidState x = state_of(bodies_[i], state);
      const Vector3d v = vector(bodies_[i].getBodyOriginVelocity(state));
      const Vector3d w = vector(bodies_[i].getBodyAngularVelocity(state));
      const Eigen::AngleAxisd turn(D.q * x.q.conjugate());
      const Vector3d f = c.k_t * (D.p - x.p) + c.g_t * (D.v - v);
      const Vector3d tau = c.k_r * turn.angle() * turn.axis() + c.g_r * (D.w - w);
      bodies_[i].applyBodyForce(state, SimTK::SpatialVec(vector(tau), vector(f)), on_bodies);
    }
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0; }

 private:
  const oracle::Case& problem_;
  const std::vector<SimTK::MobilizedBody>& bodies_;
};

/// Returns the axes of a joint's frame: x and y of a universal joint, otherwise z.
SimTK::Rotation axes_of(const oracle::Joint& joint) {
  if (joint.type != oracle::JointType::universal)
    return rotation(oracle::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), joint.axis_P));
  oracle::Matrix3d R;
  R << joint.axis_P, joint.axis_C, joint.axis_P.cross(joint.axis_C);
  return rotation(oracle::Quaterniond(R));
}

SimTK::MobilizedBody add_joint(SimTK::MobilizedBody& parent, const SimTK::Body& body,
                               const oracle::Joint& joint) {
  const SimTK::Transform P(axes_of(joint), vector(joint.anchor_P)), C(axes_of(joint), vector(joint.anchor_C));
  switch (joint.type) {
    case oracle::JointType::ball: return SimTK::MobilizedBody::Ball(parent, P, body, C);
    case oracle::JointType::hinge: return SimTK::MobilizedBody::Pin(parent, P, body, C);
    case oracle::JointType::universal: return SimTK::MobilizedBody::Universal(parent, P, body, C);
    case oracle::JointType::cylindrical: return SimTK::MobilizedBody::Cylinder(parent, P, body, C);
    default: throw std::invalid_argument("a case has a joint that simbody.cc does not make");
  }
}

class Simbody final : public Peer {
 public:
  /// implicit: true for CPodes, else Merson.
  Simbody(const oracle::Case& problem, double h, bool implicit)
      : problem_(problem), h_(h), implicit_(implicit), matter_(system_), forces_(system_) {
    const SimTK::Force::Gravity gravity(forces_, matter_, vector(problem.gravity));
    for (std::size_t i = 0; i < problem.bodies.size(); ++i) add_body(i);
    if (is_coupled(problem))
      SimTK::Force::Custom(forces_, new Couplings(problem_, bodies_));  // which owns it
    start_ = system_.realizeTopology();
    matter_.setUseEulerAngles(start_, false);
    system_.realizeModel(start_);
    for (std::size_t i = 0; i < problem.bodies.size(); ++i) place(i);
    restart();
  }

  void restart() override {
    failed_ = false;
    if (implicit_) {
      integrator_ = std::make_unique<SimTK::CPodesIntegrator>(system_, SimTK::CPodes::BDF);
      integrator_->setAccuracy(h_ * h_);
    } else {
      integrator_ = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
      integrator_->setFixedStepSize(h_);
    }
    integrator_->initialize(start_);
  }

  void step(std::size_t n) override {
    if (failed_) return;
    try {
      integrator_->stepTo(static_cast<double>(n + 1) * h_);
      system_.realize(integrator_->getState(), SimTK::Stage::Position);
    } catch (const SimTK::Exception::Base&) {
      failed_ = true;
    }
  }

  RigidState pose(std::size_t i) const override {
    RigidState x;
    x.p.setConstant(std::numeric_limits<double>::quiet_NaN());
    if (failed_) return x;
    return state_of(bodies_[i], integrator_->getState());
  }

 private:
  const oracle::Joint* joint(std::size_t child) const {
    for (const oracle::Joint& j : problem_.joints)
      if (j.child == child) return &j;
    return nullptr;
  }

  void add_body(std::size_t i) {
    const oracle::Body& par = problem_.bodies[i];
    const Vector3d I = par.I_B.diagonal();
    const SimTK::Body::Rigid body(
        SimTK::MassProperties(par.m, SimTK::Vec3(0), SimTK::Inertia(I.x(), I.y(), I.z())));
    SimTK::MobilizedBody& ground = matter_.updGround();
    const oracle::Joint* const own = joint(i);
    if (own == nullptr) {
      bodies_.push_back(SimTK::MobilizedBody::Free(ground, SimTK::Transform(), body, SimTK::Transform()));
    } else {
      SimTK::MobilizedBody parent = own->parent ? bodies_[*own->parent] : ground;
      bodies_.push_back(add_joint(parent, body, *own));
    }
  }

  /// Sets coordinates and rates of a body's joint from the poses and velocities at the start.
  void place(std::size_t i) {
    const oracle::Joint* const own = joint(i);
    const RigidState& C = problem_.bodies[i].start;
    const RigidState P = own != nullptr && own->parent ? problem_.bodies[*own->parent].start : RigidState{};
    const SimTK::MobilizedBody& body = bodies_[i];
    const SimTK::Transform X_WF = transform(P) * body.getInboardFrame(start_);
    const SimTK::Transform X_WM = transform(C) * body.getOutboardFrame(start_);
    body.setQToFitTransform(start_, ~X_WF * X_WM);
    const Vector3d M = vector(X_WM.p());
    const Vector3d v = C.v + C.w.cross(M - C.p) - P.v - P.w.cross(M - P.p);
    body.setUToFitVelocity(start_,
                           SimTK::SpatialVec(~X_WF.R() * vector(Vector3d(C.w - P.w)), ~X_WF.R() * vector(v)));
  }

  const oracle::Case& problem_;
  double h_;
  bool implicit_, failed_ = false;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  std::vector<SimTK::MobilizedBody> bodies_;
  SimTK::State start_;
  std::unique_ptr<SimTK::Integrator> integrator_;
};

template <bool implicit>
std::unique_ptr<Peer> make(const oracle::Case& problem, const Targets&, double h) {
  return std::make_unique<Simbody>(problem, h, implicit);
}

const bool added = add_peer(FreePeer{"Simbody 3.7 Merson", {}, is_short, make<false>}) &&
                   add_peer(FreePeer{"Simbody 3.7 CPodes", {}, is_short, make<true>});

}  // namespace
}  // namespace godobject::bench
