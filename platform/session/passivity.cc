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
Matrix weight_stiffness(const RigParams& rig, const KinematicTree& tree, const JointVector& q) {
  const Vec3& g_W = rig.compensation.gravity_W;
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

/// Adds to each axis the damping for motions of all axes at once, sum of |N_ij| s_j / s_i. If b_i is as
/// large, diag(b) - N is diagonally dominant, hence positive. s_i = m_i^-1/2 makes the
/// units of hinges and sliders equal.
void add_coupling(const Matrix& N, std::vector<JointMargin>& joints) {
  for (std::size_t i = 0; i < joints.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < joints.size(); ++j)
      sum += std::abs(N(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j))) *
             std::sqrt(joints[i].axis.inertia / joints[j].axis.inertia);
    joints[i].needed_together = std::max(joints[i].needed, sum);
  }
}

/// The driven axes of a device, and their margins at any pose.
class DrivenAxes {
 public:
  explicit DrivenAxes(const SceneConfig& scene);

  /// Returns the margins at a pose, without the verdicts on stability. No joints without any gain.
  Passivity at(const JointVector& q) const;
  /// Adds the verdicts on stability.
  void judge(JointMargin& margin) const;

 private:
  struct Drive {
    JointMargin without_gains;
    Eigen::Index joint;
    double needed_for_inertia;
  };

  Matrix at_actuators(double JointPlant::*number) const;

  const SceneConfig& scene_;
  const RigParams& rig_;
  KinematicTree tree_;
  Transmission transmission_;
  std::vector<SpringParams> shown_;  // one per handle
  std::vector<Drive> drives_;
  std::vector<Eigen::Index> driven_;
  Matrix D_driven_;
  int delay_ = 0;  // longest, periods
};

DrivenAxes::DrivenAxes(const SceneConfig& scene)
    : scene_(scene),
      rig_(*scene.device->rig),
      tree_(rig_.tree),
      transmission_(rig_.transmissions, rig_.tree.joints) {
  for (const HandleParams& handle : rig_.tree.handles) shown_.push_back(shown_at(scene, handle));
  const Matrix M = at_actuators(&JointPlant::inertia), D = at_actuators(&JointPlant::damping);
  for (const DriveParams& drive : rig_.drives) {
    const auto j =
        std::ranges::find(rig_.tree.joints, drive.joint, &DeviceJoint::name) - rig_.tree.joints.begin();
    JointMargin margin{.joint = drive.joint,
                       .hinge = is_rotary(rig_, drive.joint),
                       .axis = {.inertia = M(j, j),
                                .damping = D(j, j),
                                .period_s = scene.step,
                                .delay = delay_of(rig_, drive),
                                .carried = carried_inertia(rig_.compensation, static_cast<std::size_t>(j)),
                                .cutoff = rig_.compensation.inertia_cutoff}};
    delay_ = std::max(delay_, margin.axis.delay);
    driven_.push_back(j);
    const double of_inertia = margin.axis.needed_for_inertia();
    drives_.push_back({.without_gains = std::move(margin), .joint = j, .needed_for_inertia = of_inertia});
  }
  D_driven_ = D(driven_, driven_);
}

Matrix DrivenAxes::at_actuators(double JointPlant::*number) const {
  const auto n = static_cast<Eigen::Index>(rig_.tree.joints.size());
  Matrix A = Matrix::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    A(i, i) = scene_.device->plant.of(rig_.tree.joints[static_cast<std::size_t>(i)].name).*number;
  return transmission_.at_actuators(A);
}

Passivity DrivenAxes::at(const JointVector& q) const {
  Passivity result;
  const TreeConfiguration at = tree_.at(q);
  Matrix K = Matrix::Zero(q.size(), q.size()), B = K;
  for (std::size_t i = 0; i < at.num_handles(); ++i) {
    K += at_joints(at.jacobian(i), shown_[i].k_r, shown_[i].k);
    B += at_joints(at.jacobian(i), shown_[i].g_r, shown_[i].g);
  }
  B += rig_.compensation.ahead_s * K;
  const Matrix of_weight = weight_stiffness(rig_, tree_, q);
  K += of_weight;
  if (drives_.empty() || (K.isZero(0) && B.isZero(0) && rig_.compensation.inertia.empty())) return result;
  K = transmission_.at_actuators(K);
  B = transmission_.at_actuators(B);
  const Matrix K_weight = transmission_.at_actuators(of_weight);
  Matrix needed = scene_.step * (0.5 + delay_) * K(driven_, driven_) + Matrix(B(driven_, driven_));
  for (std::size_t i = 0; i < drives_.size(); ++i) {
    const Eigen::Index j = drives_[i].joint;
    JointMargin margin = drives_[i].without_gains;
    margin.axis.K = K(j, j);
    margin.axis.B = B(j, j);
    margin.K_weight = K_weight(j, j);
    margin.needed = margin.axis.needed_for_feedback() + drives_[i].needed_for_inertia;
    margin.needed_together = margin.needed;
    margin.q = q;
    result.joints.push_back(std::move(margin));
    needed(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) += drives_[i].needed_for_inertia;
  }
  result.worst_direction = largest_share(needed, D_driven_);
  result.worst_q = q;
  if (result.worst_direction > 1) add_coupling(needed, result.joints);
  return result;
}

void DrivenAxes::judge(JointMargin& margin) const {
  const auto drive = std::ranges::find(
      drives_, margin.joint, [](const Drive& d) -> const std::string& { return d.without_gains.joint; });
  const Eigen::Index j = drive->joint;
  const double K_hand = at_actuators(&JointPlant::hand_stiffness)(j, j),
               D_hand = at_actuators(&JointPlant::hand_damping)(j, j);
  margin.stable_alone = growth_per_period(margin.axis, -margin.K_weight) <= stable_growth;
  margin.stable_held = growth_per_period(margin.axis, K_hand - margin.K_weight, D_hand) <= stable_growth;
}

/// Keeps the larger of each need.
void take_worse(Passivity& worst, const Passivity& other) {
  if (worst.joints.empty()) {
    worst = other;
    return;
  }
  for (std::size_t i = 0; i < other.joints.size(); ++i) {
    const double together = std::max(other.joints[i].needed_together, worst.joints[i].needed_together);
    if (other.joints[i].needed > worst.joints[i].needed) worst.joints[i] = other.joints[i];
    worst.joints[i].needed_together = together;
  }
  if (other.worst_direction <= worst.worst_direction) return;
  worst.worst_direction = other.worst_direction;
  worst.worst_q = other.worst_q;
}

/// Moves the worst pose of one axis by one coordinate at a time, as long as the axis needs more there.
void refine(const DrivenAxes& axes, const JointRanges& ranges, std::size_t axis, Passivity& worst) {
  constexpr int num_halvings = 6;
  double share = 0.125;  // of the ranges
  for (int k = 0; k < num_halvings; ++k, share /= 2)
    for (Eigen::Index j = 0; j < worst.worst_q.size(); ++j)
      for (const double sign : {1.0, -1.0})
        if (ranges.varies(j))
          take_worse(worst, axes.at(ranges.moved(worst.joints[axis].q, j, sign * share * ranges.width(j))));
}

}  // namespace

Passivity passivity(const SceneConfig& scene, const JointVector& q) {
  if (!scene.device || !scene.device->rig) return {};
  const DrivenAxes axes(scene);
  Passivity result = axes.at(q);
  for (JointMargin& joint : result.joints) axes.judge(joint);
  return result;
}

Passivity worst_passivity(const SceneConfig& scene, const JointVector& start) {
  if (!scene.device || !scene.device->rig) return {};
  constexpr std::size_t num_poses = 256;
  const DrivenAxes axes(scene);
  const JointRanges ranges(scene.device->rig->tree, start);
  Passivity worst;
  for (const JointVector& q : ranges.poses(num_poses)) take_worse(worst, axes.at(q));
  if (ranges.vary())
    for (std::size_t i = 0; i < worst.joints.size(); ++i) refine(axes, ranges, i, worst);
  for (JointMargin& joint : worst.joints) axes.judge(joint);
  worst.ranges = ranges;
  return worst;
}

std::vector<PassivityParams> passivity_controllers(const SceneConfig& scene, const JointVector& start) {
  if (!scene.device || !scene.device->rig) return {};
  const RigParams& rig = *scene.device->rig;
  // an inactive one without feedback
  std::vector<PassivityParams> controllers(rig.drives.size());
  const Passivity margins = worst_passivity(scene, start);
  for (std::size_t i = 0; i < margins.joints.size(); ++i) {
    const SampledAxis& axis = margins.joints[i].axis;
    const DriveParams& drive = rig.drives[i];
    controllers[i] = {.inertia = axis.inertia,
                      .damping = axis.damping,
                      .needed = margins.joints[i].needed_together,
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
