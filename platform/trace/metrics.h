// Metrics of a motion and of forces over time, for the assessment of skill. Pure functions on samples.
//
// Positions and quaternions are smoothed by polynomials of degree 5 that are fitted by least squares in a
// window of 0.3 s (Savitzky and Golay, Analytical Chemistry 36, 1964). Half of the power passes at 5.6 Hz.
// Derivatives are those of the polynomials. At both ends the polynomials of the first and last window are
// continued (Gorry, Analytical Chemistry 62, 1990). Forces are not smoothed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/math/types.h"

namespace godobject {

inline constexpr double smoothing_window = 0.3;  // s
inline constexpr double least_sample_rate = 50;  // 1/s, so that a window has 15 samples or more
inline constexpr double least_gap = 0.05;        // s; shorter interruptions belong to an episode

/// Samples of one body.
struct MotionSamples {
  std::vector<double> t{};  // s, ascending
  std::vector<Vec3> p{};    // m
  std::vector<Quat> q{};    // of length 1
};

struct MotionMetrics {
  double time = 0;                                 // s, from the first sample to the last
  double path = 0;                                 // m, integral of the speed
  double angle = 0;                                // rad, integral of the angular speed
  double mean_speed = 0, peak_speed = 0;           // m/s
  double idle_share = 0;                           // of the time
  std::optional<double> log_dimensionless_jerk{};  // none without motion
};

struct ForceMetrics {
  double peak = 0, mean = 0;  // N
  double above = 0;           // s, time above the threshold
};

/// Intervals in which a condition holds.
struct Episodes {
  std::size_t begun = 0, ended = 0;  // an episode from the first sample counts as begun
  double time = 0;                   // s
};

/// Smoothing of samples at equal intervals: derivatives of the fitted polynomials.
class Smoothing {
 public:
  /// dt: interval, s, at most 1 / least_sample_rate.
  explicit Smoothing(double dt)
      : dt_(dt), half_(static_cast<Eigen::Index>(std::lround(0.5 * smoothing_window / dt))) {
    Eigen::MatrixXd powers(num_weights(), degree + 1);
    for (Eigen::Index k = 0; k < num_weights(); ++k)
      for (int j = 0; j <= degree; ++j) powers(k, j) = std::pow(place(k), j);
    fit_ = powers.completeOrthogonalDecomposition().pseudoInverse();
  }

  /// Least number of samples.
  std::size_t min_samples() const noexcept { return static_cast<std::size_t>(num_weights()); }

  /// Returns the derivative of each column of x, a row per sample. order: 0 for the smoothed values.
  Eigen::MatrixXd derivative(const Eigen::MatrixXd& x, int order) const {
    const Eigen::Index n = x.rows();
    Eigen::MatrixXd result(n, x.cols());
    const Eigen::RowVectorXd inner = weights(0, order);
    for (Eigen::Index i = 0; i < n; ++i) {
      const Eigen::Index first = std::clamp<Eigen::Index>(i - half_, 0, n - num_weights());
      const auto window = x.middleRows(first, num_weights());
      const bool is_inner = i - first == half_;
      result.row(i) = (is_inner ? inner : weights(place(i - first), order)) * window;
    }
    return result;
  }

 private:
  static constexpr int degree = 5;

  Eigen::Index num_weights() const noexcept { return 2 * half_ + 1; }
  /// Place of sample k of a window, -1 to 1.
  double place(Eigen::Index k) const noexcept {
    return static_cast<double>(k - half_) / static_cast<double>(half_);
  }
  /// Returns the weights of a window's samples for the derivative at u, from -1 to 1.
  Eigen::RowVectorXd weights(double u, int order) const {
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(num_weights());
    for (int j = order; j <= degree; ++j) {
      double factor = std::pow(u, j - order);
      for (int k = 0; k < order; ++k) factor *= j - k;
      sum += factor * fit_.row(j);
    }
    return sum / std::pow(static_cast<double>(half_) * dt_, order);
  }

  double dt_;
  Eigen::Index half_;
  Eigen::MatrixXd fit_;  // coefficients of the polynomial by the samples of a window
};

/// Returns the median interval between samples, s.
inline double usual_interval(std::span<const double> t) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < t.size(); ++i) intervals.push_back(t[i] - t[i - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::nth_element(intervals.begin(), middle, intervals.end());
  return *middle;
}

/// Interpolates linearly to equal intervals close to dt. Columns 0 to 2: position; 3 to 6: quaternion with
/// continuous signs.
inline Eigen::MatrixXd at_equal_intervals(const MotionSamples& samples, double dt) {
  const auto pose = [&](std::size_t i) {
    Eigen::Matrix<double, 1, 7> row;
    row << samples.p[i].transpose(), samples.q[i].coeffs().transpose();
    return row;
  };
  const double begin = samples.t.front(), time = samples.t.back() - begin;
  const auto num_intervals = static_cast<Eigen::Index>(std::lround(time / dt));
  Eigen::MatrixXd rows(num_intervals + 1, 7);
  Eigen::Matrix<double, 1, 7> before = pose(0), after = before;
  std::size_t next = 0;  // first sample not before the row
  for (Eigen::Index i = 0; i <= num_intervals; ++i) {
    const double t = begin + time * static_cast<double>(i) / static_cast<double>(num_intervals);
    while (next + 1 < samples.t.size() && samples.t[next] < t) {
      before = after;
      after = pose(++next);
      if (before.tail<4>().dot(after.tail<4>()) < 0) after.tail<4>() *= -1;
    }
    const double interval = next > 0 ? samples.t[next] - samples.t[next - 1] : 0;
    const double s = interval > 0 ? std::clamp((t - samples.t[next - 1]) / interval, 0.0, 1.0) : 1;
    rows.row(i) = (1 - s) * before + s * after;
  }
  return rows;
}

/// Integrates values at equal intervals by the trapezoidal rule.
inline double integral(const Eigen::VectorXd& x, double dt) {
  return dt * (x.sum() - 0.5 * (x(0) + x(x.size() - 1)));
}

/// A motion at equal intervals dt, s, and its smoothed speed, m/s. x: see at_equal_intervals().
struct SmoothedMotion {
  double dt = 0;
  Smoothing smoothing;
  Eigen::MatrixXd x, x_dot;
  Eigen::VectorXd speed;
};

/// Smooths a motion. None if it is shorter than the window or has fewer samples a second than
/// least_sample_rate. None too if its gaps are longer in all than ten times the rest.
inline std::optional<SmoothedMotion> smoothed(const MotionSamples& samples) {
  if (samples.t.size() < 2) return std::nullopt;
  constexpr double rounding = 1e-6;
  const double usual = usual_interval(samples.t);
  if (!(usual > 0) || usual * least_sample_rate > 1 + rounding) return std::nullopt;
  const double time = samples.t.back() - samples.t.front();
  if (time > 10 * usual * static_cast<double>(samples.t.size())) return std::nullopt;
  Eigen::MatrixXd x = at_equal_intervals(samples, usual);
  const double dt = time / static_cast<double>(x.rows() - 1);
  const Smoothing smoothing(dt);
  if (static_cast<std::size_t>(x.rows()) < smoothing.min_samples()) return std::nullopt;
  Eigen::MatrixXd x_dot = smoothing.derivative(x, 1);
  Eigen::VectorXd speed = x_dot.leftCols<3>().rowwise().norm();
  return SmoothedMotion{.dt = dt,
                        .smoothing = smoothing,
                        .x = std::move(x),
                        .x_dot = std::move(x_dot),
                        .speed = std::move(speed)};
}

/// Returns the metrics of a motion; none if it cannot be smoothed. idle_below: speed, m/s.
inline std::optional<MotionMetrics> motion_metrics(const MotionSamples& samples, double idle_below) {
  const std::optional<SmoothedMotion> motion = smoothed(samples);
  if (!motion) return std::nullopt;
  const auto& [dt, smoothing, x, x_dot, speed] = *motion;
  MotionMetrics m{.time = samples.t.back() - samples.t.front()};
  m.path = integral(speed, dt);
  m.mean_speed = m.path / m.time;
  m.peak_speed = speed.maxCoeff();
  m.idle_share = integral((speed.array() < idle_below).cast<double>(), dt) / m.time;

  // |w| = 2 |q_dot| of the part normal to q
  const Eigen::MatrixXd q = smoothing.derivative(x.rightCols<4>(), 0);
  Eigen::VectorXd turn_rate(x.rows());
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    const Eigen::RowVector4d n = q.row(i).normalized(), q_dot = x_dot.row(i).tail<4>();
    turn_rate(i) = 2 * (q_dot - q_dot.dot(n) * n).norm() / q.row(i).norm();
  }
  m.angle = integral(turn_rate, dt);

  // -ln(T^3 / v_peak^2 integral of |jerk|^2 dt), with the vector of jerk (Balasubramanian et al., J.
  // NeuroEngineering and Rehabilitation 12:112, 2015, table 3). Hogan and Sternad (J. Motor Behavior 41,
  // 2009) show that it must be dimensionless. Below the idle speed throughout there is no motion.
  if (m.peak_speed < idle_below) return m;
  const Eigen::VectorXd jerk2 = smoothing.derivative(x.leftCols<3>(), 3).rowwise().squaredNorm();
  const double dimensionless = std::pow(m.time, 3) / std::pow(m.peak_speed, 2) * integral(jerk2, dt);
  if (dimensionless > 0) m.log_dimensionless_jerk = -std::log(dimensionless);
  return m;
}

/// Returns the metrics of the length of a force. t: s, ascending. F: N, as many. threshold: N.
inline ForceMetrics force_metrics(std::span<const double> t, std::span<const double> F, double threshold) {
  ForceMetrics m;
  double impulse = 0;
  for (std::size_t i = 0; i < t.size(); ++i) {
    m.peak = std::max(m.peak, F[i]);
    if (i == 0) continue;
    const double dt = t[i] - t[i - 1], low = std::min(F[i], F[i - 1]), high = std::max(F[i], F[i - 1]);
    impulse += 0.5 * dt * (low + high);
    if (low > threshold) m.above += dt;
    else if (high > threshold) m.above += dt * (high - threshold) / (high - low);
  }
  if (t.size() > 1) m.mean = impulse / (t.back() - t.front());
  return m;
}

/// Counts the episodes of a condition. Interruptions shorter than min_gap, s, do not end one.
inline Episodes episodes(std::span<const double> t, const std::vector<bool>& holds, double min_gap) {
  Episodes e;
  std::optional<double> end{};  // of the last interval, while nothing holds
  bool held = false;
  for (std::size_t i = 0; i < t.size(); ++i) {
    if (holds[i] && !held && !(end && t[i] - *end < min_gap)) ++e.begun;
    if (!holds[i] && held) end = t[i];
    if (i > 0 && held) e.time += t[i] - t[i - 1];
    held = holds[i];
  }
  // an interruption at the end counts only if it is long enough
  e.ended = e.begun - (e.begun > 0 && (held || t.back() - *end < min_gap) ? 1 : 0);
  return e;
}

}  // namespace godobject
