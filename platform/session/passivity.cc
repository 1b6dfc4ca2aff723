#include "platform/session/passivity.h"

#include <algorithm>
#include <cmath>

#include "hal/drive/link.h"
#include "hal/joint/inverse_kinematics.h"

namespace godobject {
namespace {

using Matrix = Eigen::MatrixXd;

constexpr double stable_growth = 1 + 1e-6;  // 1 plus rounding: a free mass neither grows nor decays

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
  if (K.isZero(0) && B.isZero(0) && rig.compensation.inertia.empty()) return result;
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
                                .delay = delay_of(rig, drive),
                                .carried = carried_inertia(rig.compensation, static_cast<std::size_t>(j)),
                                .cutoff = rig.compensation.inertia_cutoff},
                       .K_weight = K_weight(j, j)};
    margin.stable_alone = growth_per_period(margin.axis, -margin.K_weight) <= stable_growth;
    margin.stable_held =
        growth_per_period(margin.axis, K_hand(j, j) - margin.K_weight, D_hand(j, j)) <= stable_growth;
    result.joints.push_back(margin);
    driven.push_back(j);
  }
  if (driven.empty()) return result;
  int delay = 0;
  for (const JointMargin& joint : result.joints) delay = std::max(delay, joint.axis.delay);
  Matrix needed = scene.step * (0.5 + delay) * K(driven, driven) + Matrix(B(driven, driven));
  for (std::size_t i = 0; i < driven.size(); ++i) {
    const auto at_drive = static_cast<Eigen::Index>(i);
    needed(at_drive, at_drive) += result.joints[i].axis.needed_for_inertia();
  }
  result.worst_direction = largest_share(needed, D(driven, driven));
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
                      .energy_J = scene.device->controls_passivity ? PassivityParams{}.energy_J : 0,
                      .carried = axis.carried};
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

}  // namespace godobject
