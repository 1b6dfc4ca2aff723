#include "sim/motion.h"

#include <cmath>
#include <numbers>

#include "core/so3.h"

namespace godobject {

namespace {

/// A sin(2 pi f t + phase) per component, and its derivative.
Sample<Vec3> sines(const Vec3& amplitude, const Vec3& frequency_hz, const Vec3& phase, double t) noexcept {
  Sample<Vec3> sample{Vec3::Zero(), Vec3::Zero()};
  for (int i = 0; i < 3; ++i) {
    const double omega = 2 * std::numbers::pi * frequency_hz[i];
    sample.value[i] = amplitude[i] * std::sin(omega * t + phase[i]);
    sample.rate[i] = amplitude[i] * omega * std::cos(omega * t + phase[i]);
  }
  return sample;
}

Quat turn(const Vec3& axis, double angle) noexcept { return Quat(Eigen::AngleAxis<Real>(angle, axis)); }

MotionSample evaluate(const MotionConfig& m, double t) noexcept {
  const Sample<Vec3> p = sines(m.amplitude, m.frequency_hz, m.phase, t);
  const Sample<Vec3> angles = sines(m.angle_amplitude, m.angle_frequency_hz, m.angle_phase, t);
  // q = q_0 qz qy qx;  w_W = q_0 (z a_z' + qz (y a_y' + qy x a_x'))
  const Quat q_z = m.X_WD.q * turn(Vec3::UnitZ(), angles.value[0]);
  const Quat q_zy = q_z * turn(Vec3::UnitY(), angles.value[1]);
  const Quat q = q_zy * turn(Vec3::UnitX(), angles.value[2]);
  const Vec3 w = to_world(m.X_WD.q, Vec3::UnitZ()) * angles.rate[0] +
                 to_world(q_z, Vec3::UnitY()) * angles.rate[1] +
                 to_world(q_zy, Vec3::UnitX()) * angles.rate[2];
  return {{m.X_WD.p + p.value, q.normalized()}, {w, p.rate}};
}

}  // namespace

Motion::Motion(const SceneConfig& scene) : built_in_(scene.motion) {
  for (const std::size_t body : driven_bodies(scene)) starts_.push_back(scene.bodies[body].X_WB);
  if (scene.device && scene.device->rig) chain_.emplace(scene.device->rig->chain);
}

MotionSample Motion::target(std::size_t body, double t) const noexcept {
  if (!poses_.empty()) {
    const TimeGrid::Place place = grid_->locate(t);
    const Sample<Vec3> p = poses_[body].p.at(place);
    const RotationCurve::Attitude q = poses_[body].q.at(place);
    return {{p.value, q.q}, {q.w_W, p.rate}};
  }
  if (body == 0 && has_joints()) {
    const JointTarget sample = joints(t);
    const ChainConfiguration chain = chain_->at(sample.q);
    return {chain.X_WH, chain.twist(sample.q_dot)};
  }
  if (body == 0 && built_in_) return evaluate(*built_in_, t);
  return {starts_[body], {}};
}

Wrench Motion::wrench(std::size_t body, double t) const noexcept {
  if (!wrenches_.empty()) {
    const TimeGrid::Place place = grid_->locate(t);
    return {wrenches_[body].tau.at(place).value, wrenches_[body].f.at(place).value};
  }
  if (body != 0 || !built_in_) return {};
  const MotionConfig& m = *built_in_;
  return {sines(m.torque_amplitude, m.frequency_hz, m.phase, t).value,
          sines(m.force_amplitude, m.frequency_hz, m.phase, t).value};
}

JointTarget Motion::joints(double t) const noexcept {
  const auto n = static_cast<Eigen::Index>(joints_.size());
  JointTarget sample{JointVector::Zero(n), JointVector::Zero(n)};
  if (!has_joints()) return sample;
  const TimeGrid::Place place = grid_->locate(t);
  for (std::size_t i = 0; i < joints_.size(); ++i) {
    const Sample<double> joint = joints_[i].at(place);
    sample.q[static_cast<Eigen::Index>(i)] = joint.value;
    sample.q_dot[static_cast<Eigen::Index>(i)] = joint.rate;
  }
  return sample;
}

MotionSwitches Motion::switches(std::size_t body, double t) const noexcept {
  if (!switch_grid_) return {};
  return switches_[body][switch_grid_->held(t)];
}

std::optional<double> Motion::end() const noexcept {
  if (!grid_) return std::nullopt;
  return grid_->last();
}

}  // namespace godobject
