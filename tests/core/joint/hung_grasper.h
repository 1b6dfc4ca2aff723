// The grasper of scene S3 with gravity and full feedback, on a device with the same joints. The tool is
// vertical, its tip below the trocar.
#pragma once

#include <array>
#include <memory>

#include "core/godobject.h"
#include "hal/joint/kinematic_tree.h"

namespace godobject {

class HungGrasper {
 public:
  struct S {
    static constexpr std::size_t max_bodies = 4;
    using Integrator = TrBdf2;
    using Device = PoseDevice;
    using Joints = TreeJoints<>;
    using Coupling = DampedSpring;
    using Feedback = LimitedFeedback;
  };
  static constexpr Real gravity = 9.81;
  static constexpr Real h = 1e-3;
  static constexpr Eigen::Index insertion = 2;  // coordinates: pitch, yaw, insertion, roll, left, right

  HungGrasper() : device_(tree()) {
    Params<S>& par = all_->par;
    par.h = h;
    par.num_bodies = 4;
    par.gravity_W = Vec3(0, 0, -gravity);
    set_body(0, 0.05, Vec3(1e-5, 1e-5, 1e-5), 1000, 0.5);
    set_body(1, 0.08, Vec3(8.1667e-4, 8.1667e-4, 1e-6), 1000, 1);
    set_body(2, 0.005, Vec3(1.7e-7, 1.7e-7, 4e-8), 200, 0.02);
    set_body(3, 0.005, Vec3(1.7e-7, 1.7e-7, 4e-8), 200, 0.02);
    const Quat x_for_z(Eigen::AngleAxisd(pi / 2, Vec3::UnitY()));  // z of the frame along the body's x
    set_joint(0, JointKind::universal, world, {}, {});
    set_joint(1, JointKind::cylindrical, 0, {}, {});
    for (const std::size_t i : {2u, 3u})
      set_joint(i, JointKind::hinge, 1, {Vec3(0, 0, -0.175), x_for_z}, {Vec3(0, 0, 0.01), x_for_z});
  }

  void set_driven(std::size_t i, bool driven) { all_->par.bodies[i].joint.driven = driven; }

  /// Runs with the device at rest at q.
  void hold(const JointVector& q, int steps) {
    set_device(q, JointVector::Zero(6));
    start();
    for (int n = 0; n < steps; ++n) step();
  }
  /// Step n of a motion in all joints.
  void follow(int n) {
    const Real t = n * h;
    JointVector q(6), rates(6);
    for (Eigen::Index j = 0; j < 6; ++j) {
      const Real amplitude = j == insertion ? 0.03 : 0.3, w = 2 + static_cast<Real>(j);
      q[j] = amplitude * std::sin(w * t);
      rates[j] = amplitude * w * std::cos(w * t);
    }
    set_device(q, rates);
    if (n == 1) start();
    step();
  }

  Real mass(std::size_t i) const { return all_->par.bodies[i].body.m; }
  Real stiffness(std::size_t i) const { return all_->par.bodies[i].coupling.k; }
  const Target& target(std::size_t i) const { return all_->x.bodies[i].device.last; }
  const BodyOutput<S>& body(std::size_t i) const { return all_->out.bodies[i]; }
  const Wrench& reaction(std::size_t i) const { return all_->out.bodies[i].joint.F_C; }
  const Wrench& feedback(std::size_t i) const { return all_->out.bodies[i].feedback.F_D; }
  Wrench coupling(std::size_t i) const { return coupling_at(all_->par, all_->x, i).F_WB; }
  const JointVector& device_rates() const { return rates_; }

  /// Returns the sum of weight, coupling and joint wrenches of a body at rest about its centre of mass: zero
  /// for correct reactions.
  Wrench unbalanced(std::size_t i) const {
    Wrench F = coupling(i);
    F.f.z() -= mass(i) * gravity;
    for (std::size_t c = i; c < 4; ++c) {
      const JointParams& joint = all_->par.bodies[c].joint;
      if (c != i && joint.parent != i) continue;
      const Real sign = c == i ? 1 : -1;
      const Pose& X = body(c).X_WB;
      const Vec3 r = X.p + X.q * joint.C.p - body(i).X_WB.p;
      F.f += sign * reaction(c).f;
      F.tau += sign * (reaction(c).tau + r.cross(reaction(c).f));
    }
    return F;
  }

  /// By the device's Jacobians.
  JointVector motor_torques() const {
    std::array<Wrench, 4> F;
    for (std::size_t i = 0; i < 4; ++i) F[i] = feedback(i);
    return device_.at(q_).joint_torques(F);
  }
  /// (9) from the leaves up, then about the axes of the joint above each link.
  JointVector motor_torques_walked_up() const {
    std::array<Wrench, 4> F;
    for (std::size_t i = 0; i < 4; ++i) F[i] = feedback(i);
    for (const std::size_t child : {3u, 2u, 1u}) {
      const std::size_t parent = child == 1 ? 0 : 1;
      const Wrench up = moved_to_parent(F[child], target(child).X_WD.p, target(parent).X_WD.p);
      F[parent].tau += up.tau;
      F[parent].f += up.f;
    }
    const Mat3 trocar = target(0).X_WD.q.toRotationMatrix(), tube = target(1).X_WD.q.toRotationMatrix();
    JointVector tau(6);
    tau[0] = F[0].tau.x();  // the trocar's origin is on both its axes
    tau[1] = F[0].tau.dot(trocar.col(1));
    tau[2] = F[1].f.dot(trocar.col(2));
    tau[3] = F[1].tau.dot(trocar.col(2));
    for (const std::size_t i : {2u, 3u}) {
      const Pose& X = target(i).X_WD;
      const Vec3 hinge = X.p + X.q * Vec3(0, 0, 0.01);
      tau[i == 2 ? 4 : 5] = (i == 2 ? 1 : -1) * tube.col(0).dot(F[i].tau + (X.p - hinge).cross(F[i].f));
    }
    return tau;
  }

 private:
  struct All {
    Params<S> par;
    State<S> x;
    Scratch<S> w;
    Input<S> in;
    Output<S> out;
  };

  static KinematicTreeParams tree() {
    KinematicTreeParams tree;
    const auto joint = [&](const char* name, const char* parent, DeviceJointKind kind, const Vec3& p,
                           const Vec3& axis) {
      tree.joints.push_back(
          {.name = name, .parent = parent, .kind = kind, .X_PJ = {.p = p, .q = {}}, .axis_J = axis});
      tree.joints.back().X_PJ.q.setIdentity();
    };
    joint("pitch", "base", DeviceJointKind::hinge, Vec3::Zero(), Vec3::UnitX());
    joint("yaw", "pitch", DeviceJointKind::hinge, Vec3::Zero(), Vec3::UnitY());
    joint("insertion", "yaw", DeviceJointKind::slider, Vec3(0, 0, 0.025), Vec3::UnitZ());
    joint("roll", "insertion", DeviceJointKind::hinge, Vec3::Zero(), Vec3::UnitZ());
    joint("left", "roll", DeviceJointKind::hinge, Vec3(0, 0, -0.175), Vec3::UnitX());
    joint("right", "roll", DeviceJointKind::hinge, Vec3(0, 0, -0.175), -Vec3::UnitX());
    const auto handle = [&](const char* body, const char* on, Real z) {
      tree.handles.push_back({.body = body, .joint = on, .X_LH = {}});
      tree.handles.back().X_LH.p.z() = z;
    };
    handle("trocar", "yaw", 0);
    handle("tube", "roll", 0);
    handle("left", "left", -0.01);
    handle("right", "right", -0.01);
    return tree;
  }

  void set_body(std::size_t i, Real m, const Vec3& moments, Real k, Real k_r) {
    BodyParams<S>& body = all_->par.bodies[i];
    body.body = rigid_body(m, moments.asDiagonal());
    body.coupling = {
        .k = k, .g = 1.4 * std::sqrt(m * k), .k_r = k_r, .g_r = 1.4 * std::sqrt(k_r * moments.maxCoeff())};
    body.device.rise = 0;
    body.feedback = {.gains = body.coupling,
                     .max_force = 1e9,
                     .max_torque = 1e9,
                     .max_force_rate = 1e15,
                     .max_torque_rate = 1e15};
  }
  void set_joint(std::size_t i, JointKind kind, std::size_t parent, const Pose& X_BP, const Pose& X_BC) {
    auto& joint = all_->par.bodies[i].joint;
    joint.kind = kind;
    joint.parent = parent;
    joint.P = joint_frame(X_BP);
    joint.C = joint_frame(X_BC);
  }

  void set_device(const JointVector& q, const JointVector& rates) {
    q_ = q;
    rates_ = rates;
    const TreeConfiguration at = device_.at(q);
    for (std::size_t i = 0; i < 4; ++i)
      all_->in.devices[i] = {.target = {.X_WD = at.X_WH(i), .V_WD = at.twist(i, rates)}};
  }
  void start() {
    all_->x = {};
    for (std::size_t i = 0; i < 4; ++i) {
      const PoseDevice::Input& D = all_->in.devices[i];
      place(all_->x, i, Start{.X_WB = D.target.X_WD, .V_WB = D.target.V_WD});
      engage_at(all_->x, i, D.target);
    }
  }
  void step() { godobject::step(all_->par, all_->in, all_->x, all_->w, all_->out); }

  std::unique_ptr<All> all_ = std::make_unique<All>();
  KinematicTree device_;
  JointVector q_, rates_;
};

}  // namespace godobject
