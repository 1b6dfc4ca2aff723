#include "hal/rig/identification.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Dense>

namespace godobject {
namespace {

constexpr double widths_per_period = 40;   // smoothing widths in the fastest period
constexpr double least_width = 2;          // of the smoothing, in samples
constexpr double least_speed = 0.15;       // share of the peak speed; slower samples are left out
constexpr double stride_widths = 2.5;      // distance of rows, so that their errors are nearly independent
constexpr double own_mass_lever = 0.1;     // m: lever at which the moment of a hinge without mass is printed
constexpr double least_visible = 1e-3;     // share of gravity that a joint must feel of its own link
constexpr double max_inertia_error = 0.1;  // of the inertia
constexpr double max_torque_error = 0.05;  // of the drive's torque, by each other estimate
constexpr double max_residual = 0.2;       // of the drive's torque
constexpr std::size_t least_rows = 20;     // of a joint

/// Values of a joint's motion, smoothed by a Gaussian.
struct Smoothed {
  double speed = 0, acceleration = 0, torque = 0;
  JointVector q;
};

/// Gaussian of a width of `width_s`, and the weights that it gives to the neighbours of a sample.
class Smoother {
 public:
  Smoother(double width_s, const IdentificationParams& params)
      : reach_(static_cast<Eigen::Index>(std::ceil(4 * width_s / params.period_s))) {
    const Eigen::ArrayXd t =
        Eigen::ArrayXd::LinSpaced(size(), -static_cast<double>(reach_), static_cast<double>(reach_)) *
        params.period_s;
    const Eigen::ArrayXd s = t / width_s;
    value_ = (-0.5 * s.square()).exp();
    value_ /= value_.sum();
    torque_ = (-0.5 * (s + params.torque_delay * params.period_s / width_s).square()).exp();
    torque_ /= torque_.sum();
    speed_ = s * value_;
    speed_ /= (speed_ * t).sum();
    acceleration_ = (s.square() - 1) * value_;
    acceleration_ -= value_ * acceleration_.sum();
    acceleration_ /= 0.5 * (acceleration_ * t.square()).sum();
  }

  Eigen::Index reach() const noexcept { return reach_; }

  /// at: at least reach() from both ends.
  Smoothed operator()(const JointExcitation& motion, Eigen::Index at) const {
    Smoothed out;
    out.q = JointVector::Zero(motion.q.front().size());
    const auto joint = static_cast<Eigen::Index>(motion.joint);
    const double origin = motion.q[static_cast<std::size_t>(at)](joint);
    for (Eigen::Index i = 0; i < size(); ++i) {
      const auto k = static_cast<std::size_t>(at + i - reach_);
      out.q += value_(i) * motion.q[k];
      out.speed += speed_(i) * (motion.q[k](joint) - origin);
      out.acceleration += acceleration_(i) * (motion.q[k](joint) - origin);
      out.torque += torque_(i) * motion.torque[k];
    }
    return out;
  }

 private:
  Eigen::Index size() const noexcept { return 2 * reach_ + 1; }
  Eigen::Index reach_;
  Eigen::ArrayXd value_, torque_, speed_, acceleration_;
};

/// Returns the smoothed samples of one direction of motion each, away from reversals.
std::vector<Smoothed> rows_of(const JointExcitation& motion, const IdentificationParams& params) {
  const double width_s = std::max(motion.fastest_period_s / widths_per_period, least_width * params.period_s);
  const Smoother smooth(width_s, params);
  const auto n = static_cast<Eigen::Index>(std::min(motion.q.size(), motion.torque.size()));
  const auto stride = std::max<Eigen::Index>(1, std::llround(stride_widths * width_s / params.period_s));
  std::vector<Smoothed> all, rows;
  for (Eigen::Index at = smooth.reach(); at + smooth.reach() < n; at += stride)
    all.push_back(smooth(motion, at));
  double peak = 0;
  for (const Smoothed& one : all) peak = std::max(peak, std::abs(one.speed));
  const auto moves_on = [&](const Smoothed& a, const Smoothed& b) {
    return a.speed * b.speed > 0 && std::abs(b.speed) > least_speed * peak;
  };
  for (std::size_t i = 2; i + 2 < all.size(); ++i)
    if (moves_on(all[i], all[i]) && moves_on(all[i], all[i - 2]) && moves_on(all[i], all[i + 2]))
      rows.push_back(all[i]);
  return rows;
}

/// Returns two unit vectors across the unit vector `axis`.
std::pair<Vec3, Vec3> across(const Vec3& axis) {
  const Vec3 u = axis.unitOrthogonal();
  return {u, axis.cross(u)};
}

/// Weights of the links: their share that is given, and a column for each parameter that is estimated.
class Weights {
 public:
  explicit Weights(const IdentificationParams& params) : gravity_W_(params.gravity_W), given_(params.tree) {}

  /// Estimates the weight of this joint's link. Its mass is given if the joint is a hinge.
  void estimate(std::size_t joint) {
    DeviceJoint& link = given_.joints[joint];
    KinematicTreeParams alone = given_;
    for (DeviceJoint& other : alone.joints) other.mass = 0;
    alone.joints[joint].mass = 1;
    if (link.kind == DeviceJointKind::slider) {
      columns_.push_back({joint, KinematicTree(alone), std::nullopt});
      link.mass = 0;
      return;
    }
    alone.joints[joint].p_LM.setZero();
    const KinematicTree without(alone);
    const auto [u, v] = across(link.axis_J);
    for (const Vec3& p : {u, v}) {
      alone.joints[joint].p_LM = p;
      columns_.push_back({joint, KinematicTree(alone), without});
    }
    link.p_LM = link.axis_J * link.axis_J.dot(link.p_LM);
  }

  std::size_t num_columns() const noexcept { return columns_.size(); }
  std::size_t joint_of(std::size_t column) const noexcept { return columns_[column].joint; }
  /// Returns the torque on a joint that holds a unit of the column's parameter.
  double holding(std::size_t column, const JointVector& q, std::size_t joint) const {
    const auto at = static_cast<Eigen::Index>(joint);
    const Column& c = columns_[column];
    const double whole = c.tree.at(q).weight_torques(gravity_W_)(at);
    return (c.without ? c.without->at(q).weight_torques(gravity_W_)(at) : 0) - whole;
  }
  /// Returns the torque on a joint that holds the given weights.
  double holding_given(const JointVector& q, std::size_t joint) const {
    return -KinematicTree(given_).at(q).weight_torques(gravity_W_)(static_cast<Eigen::Index>(joint));
  }
  const DeviceJoint& given(std::size_t joint) const noexcept { return given_.joints[joint]; }

 private:
  struct Column {
    std::size_t joint;
    KinematicTree tree;
    std::optional<KinematicTree> without;  // subtracted: the mass at the joint's origin
  };
  Vec3 gravity_W_;
  KinematicTreeParams given_;
  std::vector<Column> columns_;
};

constexpr std::size_t own_columns = 3;  // inertia, damping, friction

struct Fit {
  Eigen::VectorXd x, error;
  std::vector<double> residual_rms;
};

/// Solves the stacked rows of all excitations. Returns none if a column is zero or depends on the others.
std::optional<Fit> solve(const std::vector<JointExcitation>& excitations,
                         const std::vector<std::vector<Smoothed>>& rows, const Weights& weights) {
  const std::size_t own = own_columns * excitations.size();
  std::size_t num_rows = 0;
  for (const auto& of_joint : rows) num_rows += of_joint.size();
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(num_rows),
                                            static_cast<Eigen::Index>(own + weights.num_columns()));
  Eigen::VectorXd b(A.rows()), scale(A.rows());
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < excitations.size(); ++k) {
    const std::size_t joint = excitations[k].joint;
    for (const Smoothed& at : rows[k]) {
      const auto first = static_cast<Eigen::Index>(own_columns * k);
      A(row, first) = at.acceleration;
      A(row, first + 1) = at.speed;
      A(row, first + 2) = at.speed > 0 ? 1 : -1;
      for (std::size_t c = 0; c < weights.num_columns(); ++c)
        A(row, static_cast<Eigen::Index>(own + c)) = weights.holding(c, at.q, joint);
      b(row++) = at.torque - weights.holding_given(at.q, joint);
    }
  }
  // Rows of a joint have the scale of its torque, because joints may differ in unit and size.
  row = 0;
  for (const auto& of_joint : rows) {
    const auto n = static_cast<Eigen::Index>(of_joint.size());
    const double rms = b.segment(row, n).norm() / std::sqrt(static_cast<double>(n));
    scale.segment(row, n).setConstant(rms > 0 ? rms : 1);
    row += n;
  }
  const Eigen::MatrixXd A_scaled = scale.cwiseInverse().asDiagonal() * A;
  const Eigen::VectorXd norm = A_scaled.colwise().norm().transpose();
  if (A.rows() <= A.cols() || !(norm.minCoeff() > 0)) return std::nullopt;
  const Eigen::MatrixXd A_unit = A_scaled * norm.cwiseInverse().asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A_unit);
  qr.setThreshold(1e-7);
  if (qr.rank() < A.cols()) return std::nullopt;
  Fit fit;
  fit.x = qr.solve(b.cwiseQuotient(scale)).cwiseQuotient(norm);
  const Eigen::VectorXd residual = b - A * fit.x;
  const double variance =
      residual.cwiseQuotient(scale).squaredNorm() / static_cast<double>(A.rows() - A.cols());
  const Eigen::MatrixXd covariance = (A_unit.transpose() * A_unit).inverse();
  fit.error = (variance * covariance.diagonal()).cwiseSqrt().cwiseQuotient(norm);
  row = 0;
  for (const auto& of_joint : rows) {
    const auto n = static_cast<Eigen::Index>(of_joint.size());
    fit.residual_rms.push_back(residual.segment(row, n).norm() / std::sqrt(static_cast<double>(n)));
    row += n;
  }
  return fit;
}

/// Root mean square of the motion's values.
template <class Value>
double rms(const std::vector<Smoothed>& rows, const Value& value) {
  double sum = 0;
  for (const Smoothed& row : rows) sum += value(row) * value(row);
  return std::sqrt(sum / static_cast<double>(rows.size()));
}

/// Adds the reasons why the estimates of a joint must not be used.
void check(const IdentifiedJoint& joint, const std::string& name, const std::vector<Smoothed>& rows,
           std::vector<std::string>& errors) {
  const double speed = rms(rows, [](const Smoothed& at) { return at.speed; });
  const auto refuse = [&](const char* quantity, double value, double bound, const char* remedy) {
    char text[200];
    std::snprintf(text, sizeof text, "joint '%s': %s is %.2g, more than %.2g: %s", name.c_str(), quantity,
                  value, bound, remedy);
    errors.emplace_back(text);
  };
  constexpr const char* more = "the excitation is too small: raise the amplitude or lower --period";
  constexpr const char* differs =
      "the device differs from the model: check signs and scales, and that nobody touches it";
  if (joint.residual_rms > max_residual * joint.torque_rms)
    return refuse("the unexplained torque", joint.residual_rms, max_residual * joint.torque_rms, differs);
  if (!(joint.inertia.error < max_inertia_error * std::abs(joint.inertia.value)))
    return refuse("the standard error of the inertia", joint.inertia.error,
                  max_inertia_error * std::abs(joint.inertia.value), more);
  const double bound = max_torque_error * joint.torque_rms;
  if (joint.damping.error * speed > bound)
    return refuse("the standard error of the damping torque", joint.damping.error * speed, bound, more);
  if (joint.friction.error > bound)
    return refuse("the standard error of the friction", joint.friction.error, bound, more);
  if (joint.inertia.value <= 0 || joint.damping.value * speed < -bound || joint.friction.value < -bound)
    errors.push_back("joint '" + name + "': a negative estimate: " + differs);
  if (joint.mass < 0) errors.push_back("joint '" + name + "': the mass of its link is negative: " + differs);
}

/// True if the joint feels the weight of its own link. rows: of the joint.
bool shows_weight(const IdentificationParams& params, std::size_t joint, const std::vector<Smoothed>& rows) {
  Weights alone(params);
  alone.estimate(joint);
  double largest = 0;
  for (const Smoothed& at : rows)
    for (std::size_t c = 0; c < alone.num_columns(); ++c)
      largest = std::max(largest, std::abs(alone.holding(c, at.q, joint)));
  return largest > least_visible * params.gravity_W.norm();
}

Vec3 moment_of(const Fit& fit, const Weights& weights, std::size_t own, std::size_t column) {
  const auto [u, v] = across(weights.given(weights.joint_of(column)).axis_J);
  const auto at = static_cast<Eigen::Index>(own + column);
  return fit.x(at) * u + fit.x(at + 1) * v;
}

}  // namespace

Identification identify(const IdentificationParams& params, const std::vector<JointExcitation>& excitations) {
  Identification out;
  const std::size_t own = own_columns * excitations.size();
  std::vector<std::vector<Smoothed>> rows;
  for (const JointExcitation& motion : excitations) {
    rows.push_back(rows_of(motion, params));
    if (rows.back().size() < least_rows)
      out.errors.push_back("joint '" + params.tree.joints[motion.joint].name +
                           "' hardly moved: raise --torque, its amplitude, or the inertia in [device.plant]");
  }
  if (!out.errors.empty() || excitations.empty()) return out;

  // The mass of a hinge's link is free. It is chosen after a first fit, if the scene has none.
  IdentificationParams known = params;
  std::optional<Fit> fit;
  std::optional<Weights> weights;
  for (int pass = 0; pass < 2; ++pass) {
    weights.emplace(known);
    for (std::size_t k = 0; k < excitations.size(); ++k)
      if (shows_weight(params, excitations[k].joint, rows[k])) weights->estimate(excitations[k].joint);
    fit = solve(excitations, rows, *weights);
    if (!fit) {
      out.errors.emplace_back("the motion does not separate the parameters: raise the amplitude");
      return out;
    }
    for (std::size_t c = 0; pass == 0 && c < weights->num_columns(); ++c) {
      DeviceJoint& link = known.tree.joints[weights->joint_of(c)];
      if (link.kind == DeviceJointKind::slider || link.mass > 0) continue;
      link.mass = moment_of(*fit, *weights, own, c).norm() / own_mass_lever;
      ++c;
    }
  }

  for (std::size_t k = 0; k < excitations.size(); ++k) {
    const auto first = static_cast<Eigen::Index>(own_columns * k);
    const auto estimate = [&](Eigen::Index i) { return Estimate{fit->x(i), fit->error(i)}; };
    IdentifiedJoint joint{.joint = excitations[k].joint,
                          .inertia = estimate(first),
                          .damping = estimate(first + 1),
                          .friction = estimate(first + 2),
                          .torque_rms = rms(rows[k], [](const Smoothed& at) { return at.torque; }),
                          .residual_rms = fit->residual_rms[k]};
    for (std::size_t c = 0; c < weights->num_columns() && !joint.has_weight; ++c) {
      if (weights->joint_of(c) != joint.joint) continue;
      const DeviceJoint& link = weights->given(joint.joint);
      const auto at = static_cast<Eigen::Index>(own + c);
      joint.has_weight = true;
      joint.weight_error = fit->error(at);
      joint.p_LM = link.p_LM;
      joint.mass = link.mass;
      if (link.kind == DeviceJointKind::slider) {
        joint.mass = fit->x(at);
        continue;
      }
      if (link.mass > 0) joint.p_LM += moment_of(*fit, *weights, own, c) / link.mass;
      joint.weight_error = std::max(joint.weight_error, fit->error(at + 1));
    }
    check(joint, params.tree.joints[joint.joint].name, rows[k], out.errors);
    joint.damping.value = std::max(joint.damping.value, 0.0);
    joint.friction.value = std::max(joint.friction.value, 0.0);
    out.joints.push_back(joint);
  }
  return out;
}

}  // namespace godobject
