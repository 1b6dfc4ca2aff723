#include "platform/session/passivity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "hal/drive/link.h"
#include "hal/joint/inverse_kinematics.h"

namespace godobject {
namespace {

using Matrix = Eigen::MatrixXd;

constexpr double stable_growth = 1 + 1e-6;  // 1 plus rounding: a free mass neither grows nor decays

/// Computes exp(A) by scaling and squaring, with two terms of the Taylor series.
Matrix exponential(Matrix A) {
  const int halvings = std::max(0, std::ilogb(A.norm()) + 16);
  A /= std::exp2(halvings);
  Matrix E = A + A.lazyProduct(A) / 2;  // exp(A) - 1, which keeps small terms
  for (int i = 0; i < halvings; ++i) E = (2 * E + E.lazyProduct(E)).eval();
  return Matrix::Identity(A.rows(), A.cols()) + E;
}

/// Returns the largest absolute eigenvalue, the limit of |A^n|^(1/n), at n = 2^40 by squaring. Eigen's
/// solvers of eigenvalues cost 12 s of each compilation.
double spectral_radius(Matrix A) {
  double log_radius = 0, share = 1;
  for (int squarings = 0; squarings < 40; ++squarings) {
    const double size = A.norm();
    if (!(size > 0)) return size;
    log_radius += share * std::log(size);
    share /= 2;
    A /= size;
    A = A.lazyProduct(A).eval();
  }
  return std::exp(log_radius);
}

/// Returns a handle's gains in joint coordinates, J^T G J.
Matrix at_joints(const HandleJacobian& J, double rotational, double translational) {
  Eigen::Vector<double, 6> gains;
  gains << Vec3::Constant(rotational), Vec3::Constant(translational);
  return J.transpose().lazyProduct(gains.asDiagonal() * J);
}

/// Returns the largest gains that the handle can display. A device that grips bodies displays the largest
/// gains of any body.
SpringParams shown_at(const SceneConfig& scene, const HandleParams& handle) {
  SpringParams most;
  for (const BodyConfig& body : scene.bodies) {
    if (!body.feedback || (!grips_bodies(scene) && body.name != handle.body)) continue;
    most.k = std::max(most.k, body.feedback->k);
    most.g = std::max(most.g, body.feedback->g);
    most.k_r = std::max(most.k_r, body.feedback->k_r);
    most.g_r = std::max(most.g_r, body.feedback->g_r);
  }
  // both the target's shift and the force are scaled
  const double scale = scene.device->display_ratio * scene.device->display_ratio;
  most.k *= scale;
  most.g *= scale;
  return most;
}

/// Returns the periods from a sample to its torque. A command takes effect at the SYNC after the sampling
/// one, or, without SYNC, within a period.
/// A drive that measures its joint only at every n-th SYNC has its sample used for n periods.
int delay_of(const RigParams& rig, const DriveParams& drive) {
  const bool own_sensor =
      std::ranges::none_of(rig.encoders, [&](const EncoderParams& e) { return e.joint == drive.joint; });
  return 1 + (own_sensor ? drive.status_every_nth_sync - 1 : 0);
}

/// Returns the largest eigenvalue of N scaled by the axes' own damping; up to 1 the axes are passive.
double largest_share(const Matrix& needed, const Matrix& damping) {
  if (needed.isZero(0)) return 0;
  const Eigen::LLT<Matrix> factor(damping);
  if (factor.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  const Matrix half = factor.matrixL().solve(needed);
  return spectral_radius(factor.matrixL().solve(Matrix(half.transpose())));
}

template <class... Args>
std::string formatted(const char* format, Args... args) {
  std::array<char, 320> text{};
  std::snprintf(text.data(), text.size(), format, args...);
  return text.data();
}

const char* damping_unit(const JointMargin& joint) { return joint.hinge ? "N m s/rad" : "N s/m"; }

/// Returns the gain to lower, and the percentage that remains.
std::string remedy(const SampledAxis& axis) {
  const double of_spring = axis.needed() - std::abs(axis.B);
  const double left = axis.damping - of_spring;
  if (left > 0 || of_spring == 0)
    return formatted("lower the feedback's damping to %.3g %% of its present value",
                     std::floor(1000 * std::max(left, 0.0) / std::abs(axis.B)) / 10);
  return formatted("set the feedback's damping to 0 and lower its stiffness to %.3g %% of its present value",
                   std::floor(1000 * axis.damping / of_spring) / 10);
}

/// Returns the stiffness that the compensation of weight adds to the joints, -d tau / dq of (weight_torques).
/// The weight itself has the opposite one, without delay.
Matrix weight_stiffness(const RigParams& rig, const JointVector& q) {
  const Vec3& g_W = rig.compensation.gravity_W;
  const KinematicTree tree(rig.tree);
  const Eigen::Index n = q.size();
  Matrix K = Matrix::Zero(n, n);
  constexpr double dq = 1e-5;
  for (Eigen::Index j = 0; j < n && !g_W.isZero(); ++j) {
    JointVector before = q, after = q;
    before(j) -= dq;
    after(j) += dq;
    K.col(j) = (tree.at(after).weight_torques(g_W) - tree.at(before).weight_torques(g_W)) / (2 * dq);
  }
  return K;
}

}  // namespace

double SampledAxis::needed() const noexcept { return K * period_s * (0.5 + delay) + std::abs(B); }

// State: q_k, q'_k, q_(k-1), and the pending torques u_(k-1) ... u_(k-delay).
double growth_per_period(const SampledAxis& axis, double hand_stiffness, double hand_damping) {
  const double T = axis.period_s, m = axis.inertia;
  Matrix A = Matrix::Zero(3, 3);  // matrix of q, q', u over a period
  A(0, 1) = T;
  A(1, 0) = -T * hand_stiffness / m;
  A(1, 1) = -T * (axis.damping + hand_damping) / m;
  A(1, 2) = T / m;
  const Matrix E = exponential(A);

  const Eigen::Index n = 3 + axis.delay;
  Matrix u_k = Matrix::Zero(1, n);  // torque commanded from sample k
  u_k(0, 0) = -axis.K - axis.B / T;
  u_k(0, 2) = axis.B / T;
  Matrix applied = Matrix::Zero(1, n);
  if (axis.delay == 0) applied = u_k;
  else applied(0, n - 1) = 1;

  Matrix step = Matrix::Zero(n, n);
  step.topLeftCorner(2, 2) = E.topLeftCorner(2, 2);
  step.topRows(2) += E.block(0, 2, 2, 1) * applied;
  step(2, 0) = 1;
  if (axis.delay > 0) step.row(3) = u_k;
  for (Eigen::Index i = 4; i < n; ++i) step(i, i - 1) = 1;
  return spectral_radius(step);
}

// Root of z^(d+1) (z - 1) + beta (z + 1) / 2 on the unit circle, beta = B T / m. There z = exp(i a) with a (d
// + 1) = pi/2 (odd), i.e. a = pi / (2 (d + 1)), and beta = 2 tan(a / 2).
double largest_stable_damping(double inertia, double period_s, int delay) {
  const double a = std::numbers::pi / (2 * (delay + 1));
  return 2 * std::tan(a / 2) * inertia / period_s;
}

Passivity passivity(const SceneConfig& scene, const JointVector& q) {
  Passivity result;
  if (!scene.device || !scene.device->rig) return result;
  const RigParams& rig = *scene.device->rig;
  const TreeConfiguration at = KinematicTree(rig.tree).at(q);
  const auto num_joints = static_cast<Eigen::Index>(at.num_joints());
  Matrix K = Matrix::Zero(num_joints, num_joints), B = K;
  for (std::size_t i = 0; i < at.num_handles(); ++i) {
    const SpringParams gains = shown_at(scene, rig.tree.handles[i]);
    K += at_joints(at.jacobian(i), gains.k_r, gains.k);
    B += at_joints(at.jacobian(i), gains.g_r, gains.g);
  }
  B += rig.compensation.ahead_s * K;
  const Matrix of_weight = weight_stiffness(rig, q);
  K += of_weight;
  if (K.isZero(0) && B.isZero(0)) return result;
  const Transmission transmission(rig.transmissions, rig.tree.joints);
  const auto at_actuators = [&](double JointPlant::*number) {
    Matrix A = Matrix::Zero(num_joints, num_joints);
    for (Eigen::Index i = 0; i < num_joints; ++i)
      A(i, i) = scene.device->plant.of(rig.tree.joints[static_cast<std::size_t>(i)].name).*number;
    return transmission.at_actuators(A);
  };
  K = transmission.at_actuators(K);
  B = transmission.at_actuators(B);
  const Matrix K_weight = transmission.at_actuators(of_weight);
  const Matrix M = at_actuators(&JointPlant::inertia), D = at_actuators(&JointPlant::damping),
               K_hand = at_actuators(&JointPlant::hand_stiffness),
               D_hand = at_actuators(&JointPlant::hand_damping);

  std::vector<Eigen::Index> driven;
  for (const DriveParams& drive : rig.drives) {
    const auto j =
        std::ranges::find(rig.tree.joints, drive.joint, &DeviceJoint::name) - rig.tree.joints.begin();
    JointMargin margin{.joint = drive.joint,
                       .hinge = is_rotary(rig, drive.joint),
                       .axis = {.inertia = M(j, j),
                                .damping = D(j, j),
                                .K = K(j, j),
                                .B = B(j, j),
                                .period_s = scene.step,
                                .delay = delay_of(rig, drive)},
                       .K_weight = K_weight(j, j)};
    margin.stable_alone = growth_per_period(margin.axis, -margin.K_weight) <= stable_growth;
    margin.stable_held =
        growth_per_period(margin.axis, K_hand(j, j) - margin.K_weight, D_hand(j, j)) <= stable_growth;
    result.joints.push_back(margin);
    driven.push_back(j);
  }
  int delay = 0;
  for (const JointMargin& joint : result.joints) delay = std::max(delay, joint.axis.delay);
  if (driven.empty()) return result;
  result.worst_direction = largest_share(
      scene.step * (0.5 + delay) * K(driven, driven) + Matrix(B(driven, driven)), D(driven, driven));
  return result;
}

std::vector<PassivityParams> passivity_controllers(const SceneConfig& scene, const JointVector& q) {
  if (!scene.device || !scene.device->rig) return {};
  const RigParams& rig = *scene.device->rig;
  // an inactive one without feedback
  std::vector<PassivityParams> controllers(rig.drives.size());
  const Passivity margins = passivity(scene, q);
  for (std::size_t i = 0; i < margins.joints.size(); ++i) {
    const SampledAxis& axis = margins.joints[i].axis;
    const DriveParams& drive = rig.drives[i];
    controllers[i] = {.inertia = axis.inertia,
                      .damping = axis.damping,
                      .needed = axis.needed(),
                      .stiffness = axis.K - margins.joints[i].K_weight,  // of the displayed torque
                      .resolution = 1 / sensor_of(rig, drive.joint)->counts_per_unit,
                      .period_s = axis.period_s,
                      .delay = axis.delay,
                      // without SYNC a command acts within its period
                      .acts_after = bus_protocol(drive.protocol).canopen ? 1 : 0,
                      .energy_J = scene.device->controls_passivity ? PassivityParams{}.energy_J : 0};
  }
  return controllers;
}

JointVector joints_at_start(const SceneConfig& scene, const Motion& motion) {
  if (!scene.device || !scene.device->rig) return {};
  if (motion.has_joints()) return motion.joints(0).q;
  const KinematicTreeParams& tree = scene.device->rig->tree;
  const std::vector<std::optional<std::size_t>> targets = driven_by_handles(scene);
  InverseKinematics ik(tree);
  if (!ik.invertible() || targets.empty())
    return JointVector::Zero(static_cast<Eigen::Index>(tree.joints.size()));
  return ik.solve(motion.target(targets.front().value_or(0), 0).X_WD).q;
}

std::vector<std::string> passivity_table(const Passivity& passivity) {
  if (passivity.joints.empty()) return {};
  std::vector<std::string> lines{
      "# passivity of the driven axes at the start: b > K (T/2 + t_d) + |B|, see docs/theory/passivity.md",
      formatted("#   %-16s %10s %10s %8s %10s %10s %10s  %s", "joint", "K", "B", "t_d ms", "needed", "b",
                "margin", "verdict")};
  for (const JointMargin& joint : passivity.joints) {
    const SampledAxis& axis = joint.axis;
    const char* const verdict = axis.passive()       ? "passive"
                                : joint.stable_alone ? "stable, not passive"
                                : joint.stable_held  ? "stable only in a hand"
                                                     : "unstable";
    lines.push_back(formatted("#   %-16s %10.3g %10.3g %8.3g %10.3g %10.3g %+10.3g  %s", joint.joint.c_str(),
                              axis.K, axis.B, 1e3 * axis.period_s * axis.delay, axis.needed(), axis.damping,
                              axis.margin(), verdict));
  }
  if (passivity.joints.size() > 1)
    lines.push_back(formatted("#   all at once: the worst direction needs %.3g times the present damping",
                              passivity.worst_direction));
  lines.push_back(
      "#   K, B: the feedback's gains at the joint, N m/rad and N m s/rad, of a slider N/m and N s/m; t_d: "
      "from "
      "a sample to its torque");
  lines.push_back(
      "#   b: damping of the device without a hand, from [device.plant]; of a real device, measure it and "
      "enter it there");
  return lines;
}

std::vector<std::string> passivity_warnings(const Passivity& passivity) {
  std::vector<std::string> lines;
  for (const JointMargin& joint : passivity.joints) {
    const SampledAxis& axis = joint.axis;
    if (axis.passive()) continue;
    std::string line = formatted("axis %s is not passive: it needs %.3g %s of its own damping and has %.3g: ",
                                 joint.joint.c_str(), axis.needed(), damping_unit(joint), axis.damping) +
                       remedy(axis) + ", shorten the step, or build it with more damping";
    if (!joint.stable_alone)
      line += formatted("; %s it is unstable and chatters (feedback damping alone: from %.3g %s on)",
                        joint.stable_held ? "released" : "even in a hand",
                        largest_stable_damping(axis.inertia, axis.period_s, axis.delay), damping_unit(joint));
    lines.push_back(std::move(line));
  }
  if (lines.empty() && !passivity.passive())
    lines.push_back(
        formatted("the axes are passive one by one, but not together: the worst direction needs "
                  "%.3g times the present damping: divide the feedback's gains by that",
                  passivity.worst_direction));
  return lines;
}

}  // namespace godobject
