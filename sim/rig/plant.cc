#include "sim/rig/plant.h"

#include <algorithm>
#include <utility>

namespace godobject {

SimPlant::SimPlant(std::vector<JointPlant> joints, bool haptic, const JointVector& q0, Nanoseconds t_ns)
    : joints_(std::move(joints)), haptic_(haptic), t_ns_(t_ns), q_(q0) {
  joints_.resize(std::min(joints_.size(), max_joints));
  const auto n = static_cast<Eigen::Index>(joints_.size());
  q_dot_.setZero(n);
  tau_motor_.setZero(n);
  tau_hand_.setZero(n);
}

SimPlant::SimPlant(const JointPlant& each, std::size_t num_joints, bool haptic, const JointVector& q0,
                   Nanoseconds t_ns)
    : SimPlant(std::vector<JointPlant>(num_joints, each), haptic, q0, t_ns) {}

void SimPlant::set_motor_torque(std::size_t joint, double tau) noexcept {
  const auto i = static_cast<Eigen::Index>(joint);
  if (i < tau_motor_.size()) tau_motor_(i) = tau;
}

void SimPlant::advance(Nanoseconds t_ns, const JointVector& q_ref, const JointVector& q_ref_dot) noexcept {
  if (!haptic_) {
    t_ns_ = t_ns;
    q_ = q_ref;
    q_dot_ = q_ref_dot;
    return;
  }
  while (t_ns - t_ns_ >= substep_ns) {
    t_ns_ += substep_ns;
    const double ahead_s = 1e-9 * static_cast<double>(t_ns - t_ns_);
    for (Eigen::Index i = 0; i < q_.size(); ++i) {
      substep(i, q_ref(i) - ahead_s * q_ref_dot(i), q_ref_dot(i));
    }
  }
}

// Solves (I/h + b + d_h + h k_h) v+ + f_c sign(v+) = I/h v + tau_motor + k_h (q_ref - q) + d_h q_ref'.
void SimPlant::substep(Eigen::Index joint, double q_ref, double q_ref_dot) noexcept {
  constexpr double h = 1e-9 * static_cast<double>(substep_ns);
  const JointPlant& plant = joints_[static_cast<std::size_t>(joint)];
  const double k_h = plant.hand_stiffness, d_h = plant.hand_damping, f_c = plant.friction;
  double& q = q_(joint);
  double& v = q_dot_(joint);

  const double a = plant.inertia / h + plant.damping + d_h + h * k_h;
  const double b = plant.inertia / h * v + tau_motor_(joint) + k_h * (q_ref - q) + d_h * q_ref_dot;
  // a v+ + f_c sign(v+) = b with sign(0) = [-1, 1]: at rest while |b| <= f_c
  v = (b - std::clamp(b, -f_c, f_c)) / a;
  q += h * v;
  tau_hand_(joint) = k_h * (q_ref - q) + d_h * (q_ref_dot - v);
}

}  // namespace godobject
