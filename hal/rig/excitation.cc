#include "hal/rig/excitation.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <Eigen/Cholesky>

namespace godobject {
namespace {

constexpr double settling_s = 1;        // the hold becomes still before a joint moves
constexpr double integral_s = 0.5;      // time constant of the integral
constexpr double velocity_s = 5e-3;     // of the smoothed speed
constexpr double range_amplitudes = 3;  // beyond this distance from the start it gives up
constexpr double max_speed_ratio = 5;   // of a joint, of the largest speed of the references
constexpr double least_counts = 50;     // of a sensor in an amplitude
// Stiffness and damping of the hold, by the joint's stated inertia, that need no damping of the device. They
// are those of the passivity controller: docs/theory/passivity.md.
constexpr double stiffness_share = 0.05, damping_share = 0.35;
constexpr int periods_of_delay = 2;

using JointMatrix = Eigen::Matrix<Real, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                  static_cast<int>(max_joints), static_cast<int>(max_joints)>;

/// Returns the sum of J^T J over the handles.
JointMatrix moving(const TreeConfiguration& at) noexcept {
  const auto n = static_cast<Eigen::Index>(at.num_joints());
  JointMatrix sum = JointMatrix::Zero(n, n);
  for (std::size_t h = 0; h < at.num_handles(); ++h) {
    const HandleJacobian J = at.jacobian(h);
    sum += J.transpose() * J;
  }
  return sum;
}

}  // namespace

std::vector<std::string> Excitation::complaints(const RigParams& rig, const ExcitationParams& params) {
  std::vector<std::string> errors;
  if (!rig.transmissions.empty())
    errors.emplace_back("joints of a [[device.transmission]] are not identified");
  for (const DeviceJoint& joint : rig.tree.joints)
    if (!drive_of(rig, joint.name))
      errors.push_back("joint '" + joint.name + "' has no drive that holds it: add [[device.drive]]");
  for (std::size_t k = 0; k < params.joints.size(); ++k) {
    const std::string& name = rig.tree.joints[params.joints[k]].name;
    const Calibration* const sensor = sensor_of(rig, name);
    const double counts = sensor == nullptr ? 0 : params.amplitude[k] * sensor->counts_per_unit;
    if (counts >= least_counts) continue;
    char text[160];
    std::snprintf(text, sizeof text,
                  "joint '%s': an amplitude of %.3g is %.0f counts of its sensor, less than %.0f",
                  name.c_str(), params.amplitude[k], counts, least_counts);
    errors.emplace_back(text);
  }
  if (!errors.empty()) return errors;
  const KinematicTree tree(rig.tree);
  // at an arbitrary pose, because that of the start is not known yet
  const auto n = static_cast<Eigen::Index>(tree.num_joints());
  const JointMatrix sum = moving(tree.at(JointVector::Constant(n, 0.1)));
  if (!(sum.ldlt().isPositive() && sum.ldlt().rcond() > 1e-9))
    errors.emplace_back(
        "the torques of the joints are not those of any wrenches on the handles: add a "
        "[[device.handle]] to the last link of each branch");
  return errors;
}

Excitation::Excitation(const RigParams& rig, const PlantConfig& plant, double step_s, ExcitationParams params)
    : rig_(rig), step_s_(step_s), params_(std::move(params)), tree_(rig.tree) {
  for (std::size_t j = 0; j < rig.tree.joints.size(); ++j) {
    const std::string& name = rig.tree.joints[j].name;
    const std::size_t drive = *drive_of(rig, name);
    const DriveParams& motor = rig.drives[drive];
    const auto moved = std::ranges::find(params_.joints, j);
    // a joint that is only held may move as far as those that are moved, in its own unit
    const double amplitude =
        moved == params_.joints.end()
            ? *std::ranges::max_element(params_.amplitude)
            : params_.amplitude[static_cast<std::size_t>(moved - params_.joints.begin())];
    const double inertia = plant.of(name).inertia;
    const double reach_s = periods_of_delay * step_s;
    Axis axis{.drive = drive, .joint_per_motor = motor.sign / motor.joint_per_motor_rad};
    axis.bound = params_.torque * motor.torque_max_Nm / motor.joint_per_motor_rad;
    axis.stiffness = std::min(axis.bound / amplitude, stiffness_share * inertia / (reach_s * reach_s));
    axis.damping = std::min(1.4 * std::sqrt(axis.stiffness * inertia), damping_share * inertia / reach_s);
    axis.range = range_amplitudes * amplitude;
    axis.max_speed = max_speed_ratio * 2 * std::numbers::pi * amplitude / params_.period_s;
    axes_.push_back(axis);
  }
  const std::size_t size = steps(joint_s()) + 2;
  for (const std::size_t joint : params_.joints) {
    records_.push_back({.joint = joint, .fastest_period_s = params_.period_s / 4, .q = {}, .torque = {}});
    records_.back().q.reserve(size);
    records_.back().torque.reserve(size);
  }
}

std::size_t Excitation::steps(double s) const noexcept {
  return static_cast<std::size_t>(std::llround(s / step_s_));
}

double Excitation::slow_s() const noexcept { return params_.cycles * params_.period_s; }
double Excitation::moving_s() const noexcept { return 1.5 * slow_s(); }

double Excitation::joint_s() const noexcept { return 2 * settling_s + moving_s(); }

double Excitation::duration_s() const noexcept {
  return joint_s() * static_cast<double>(params_.joints.size());
}

double Excitation::peak_speed() const noexcept {
  return 2 * std::numbers::pi * params_.amplitude[std::min(at_, params_.amplitude.size() - 1)] /
         params_.period_s;
}

double Excitation::time_s() const noexcept { return static_cast<double>(step_) * step_s_ - settling_s; }

/// Sines of whole cycles, which begin and end at the start: first the slow one, then the fast one.
JointTarget Excitation::reference() const noexcept {
  JointTarget out{.q = q_0_, .q_dot = JointVector::Zero(q_0_.size())};
  double t = time_s();
  if (t < 0 || t > moving_s()) return out;
  const bool fast = t > slow_s();
  const double ratio = fast ? 4 : 1;
  if (fast) t -= slow_s();
  const double w = 2 * std::numbers::pi * ratio / params_.period_s;
  const double amplitude = params_.amplitude[at_] / ratio;
  const auto joint = static_cast<Eigen::Index>(params_.joints[at_]);
  out.q(joint) += amplitude * std::sin(w * t);
  out.q_dot(joint) = amplitude * w * std::cos(w * t);
  return out;
}

void Excitation::record(const Rig& rig, const JointVector& q) noexcept {
  const double t = time_s();
  JointExcitation& record = records_[at_];
  const Axis& axis = axes_[record.joint];
  // the torque sent after the sample before
  if (!record.q.empty() && record.torque.size() < record.q.size())
    record.torque.push_back(rig.commanded_torque_Nm(axis.drive) * axis.joint_per_motor);
  if (t >= 0 && t <= moving_s() && record.q.size() < record.q.capacity()) record.q.push_back(q);
}

bool Excitation::too_far(const JointVector& q, const JointVector& q_dot) noexcept {
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    const auto i = static_cast<Eigen::Index>(j);
    if (std::abs(q(i) - q_0_(i)) > axes_[j].range) ending_ = Ending::out_of_range;
    else if (std::abs(q_dot(i)) > axes_[j].max_speed) ending_ = Ending::too_fast;
    else continue;
    ended_by_ = j;
    return true;
  }
  return false;
}

bool Excitation::step(const Rig& rig, const JointVector& q, bool valid, std::span<Wrench> F_hand_W) noexcept {
  if (finished()) return false;
  if (q_0_.size() == 0) {
    if (!valid) return true;
    q_0_ = q_before_ = q;
    q_dot_ = JointVector::Zero(q.size());
  }
  const double share = std::min(step_s_ / velocity_s, 1.0);
  q_dot_ += share * ((q - q_before_) / step_s_ - q_dot_);
  q_before_ = q;
  record(rig, q);
  if (too_far(q, q_dot_)) return false;

  const JointTarget wanted = reference();
  JointVector tau(q.size());
  for (std::size_t j = 0; j < axes_.size(); ++j) {
    Axis& axis = axes_[j];
    const auto i = static_cast<Eigen::Index>(j);
    const double pull = axis.stiffness * (wanted.q(i) - q(i));
    axis.integral = std::clamp(axis.integral + pull * step_s_ / integral_s, -axis.bound, axis.bound);
    tau(i) = std::clamp(pull + axis.integral + axis.damping * (wanted.q_dot(i) - q_dot_(i)), -axis.bound,
                        axis.bound);
  }
  const TreeConfiguration at = tree_.at(q);
  const Eigen::LDLT<JointMatrix> moved_by_handles(moving(at));
  const JointVector solved = moved_by_handles.solve(tau);
  for (std::size_t h = 0; h < at.num_handles(); ++h) {
    const Twist F = at.twist(h, solved);
    F_hand_W[h] = {.tau = F.w, .f = F.v};
  }
  ++step_;
  const bool joint_is_done = step_ > steps(joint_s());
  if (joint_is_done) {
    ++at_;
    step_ = 0;
  }
  return !finished();
}

std::string Excitation::why_not() const {
  if (ending_ == Ending::none) return finished() ? "" : "it did not end";
  const std::string& name = rig_.tree.joints[ended_by_].name;
  const Axis& axis = axes_[ended_by_];
  char text[240];
  if (ending_ == Ending::out_of_range)
    std::snprintf(
        text, sizeof text,
        "joint '%s' left its range of %.3g about the start: raise --torque if it fell, and check signs",
        name.c_str(), axis.range);
  else
    std::snprintf(text, sizeof text,
                  "joint '%s' was faster than %.3g per s: lower --torque, or state a smaller inertia in "
                  "[device.plant]",
                  name.c_str(), axis.max_speed);
  return text;
}

}  // namespace godobject
