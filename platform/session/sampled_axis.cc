#include "platform/session/sampled_axis.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "hal/rig/inertia_compensation.h"

namespace godobject {
namespace {

using Matrix = Eigen::MatrixXd;

/// Computes exp(A) by scaling and squaring, with two terms of the Taylor series.
Matrix exponential(Matrix A) {
  const int halvings = std::max(0, std::ilogb(A.norm()) + 16);
  A /= std::exp2(halvings);
  Matrix E = A + A.lazyProduct(A) / 2;  // exp(A) - 1, which keeps small terms
  for (int i = 0; i < halvings; ++i) E = (2 * E + E.lazyProduct(E)).eval();
  return Matrix::Identity(A.rows(), A.cols()) + E;
}

}  // namespace

// Limit of |A^n|^(1/n), at n = 2^40 by squaring. Eigen's solvers of eigenvalues cost 12 s of a compilation.
double spectral_radius(Eigen::MatrixXd A) {
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

// Maximum over theta of T / (2 (1 - cos theta)) Re{(1 - z^-1) H} with z = exp(i theta) and
//   H = -m_c z^-d (c / T)^2 (1 - z^-1)^2 / (1 - (1 - c) z^-1)^2.
double SampledAxis::needed_for_inertia() const noexcept {
  if (!(carried > 0)) return 0;
  using Complex = std::complex<double>;
  constexpr int num_angles = 400;
  const double c = InertiaCompensation::share_of(cutoff, period_s);
  const double lowest = std::min(0.1 * c, 0.1);
  double most = 0;
  for (int i = 0; i <= num_angles; ++i) {
    const double theta = lowest * std::pow(std::numbers::pi / lowest, static_cast<double>(i) / num_angles);
    const Complex z = std::polar(1.0, -theta), change = 1.0 - z, lag = 1.0 - (1 - c) * z;
    const Complex H =
        -carried * c * c / (period_s * period_s) * std::pow(z, delay) * change * change / lag / lag;
    most = std::max(most, period_s / (2 * (1 - std::cos(theta))) * (change * H).real());
  }
  return most;
}

double SampledAxis::needed_for_feedback() const noexcept {
  return K * period_s * (0.5 + delay) + std::abs(B);
}

// State: q_k, q'_k, q_(k-1), both low-passes of the acceleration, and the pending torques u_(k-1) ...
// u_(k-delay). Its eigenvalues are those of differences, scaled by the share c of the low-passes. Otherwise
// the ones near 1 would be lost in rounding.
double growth_per_period(const SampledAxis& axis, double hand_stiffness, double hand_damping) {
  const double T = axis.period_s, m = axis.inertia;
  Matrix A = Matrix::Zero(3, 3);  // matrix of q, q', u over a period
  A(0, 1) = T;
  A(1, 0) = -T * hand_stiffness / m;
  A(1, 1) = -T * (axis.damping + hand_damping) / m;
  A(1, 2) = T / m;
  const Matrix E = exponential(A);

  constexpr Eigen::Index first_torque = 5;
  const Eigen::Index n = first_torque + axis.delay;
  const bool moves = axis.carried > 0;
  const double c = moves ? InertiaCompensation::share_of(axis.cutoff, T) : 1;
  Matrix once = Matrix::Zero(1, n), twice = once;  // low-passes after sample k
  once(0, 0) = c;
  once(0, 3) = 1 - c;
  twice(0, 4) = 1 - c;
  twice += c * once;
  Matrix u_k = Matrix::Zero(1, n);  // torque commanded from sample k
  u_k(0, 0) = 1;
  u_k = (moves ? axis.carried * InertiaCompensation::gain_of(axis.cutoff, T) : 0) * (u_k - 2 * once + twice);
  u_k(0, 0) -= axis.K + axis.B / T;
  u_k(0, 2) += axis.B / T;
  Matrix applied = Matrix::Zero(1, n);
  if (axis.delay == 0) applied = u_k;
  else applied(0, n - 1) = 1;

  Matrix step = Matrix::Zero(n, n);
  step.topLeftCorner(2, 2) = E.topLeftCorner(2, 2);
  step.topRows(2) += E.block(0, 2, 2, 1) * applied;
  step(2, 0) = 1;
  step.row(3) = once;
  step.row(4) = twice;
  if (axis.delay > 0) step.row(first_torque) = u_k;
  for (Eigen::Index i = first_torque + 1; i < n; ++i) step(i, i - 1) = 1;
  Matrix P = Matrix::Identity(n, n), P_inverse = P;  // P x of the differences x
  P(1, 1) = c / T;
  P.block(2, 0, 3, 1).setOnes();
  P(2, 2) = P(3, 3) = P(4, 3) = P(4, 4) = -c;
  P_inverse(1, 1) = T / c;
  P_inverse(2, 0) = P_inverse(3, 0) = P_inverse(4, 3) = 1 / c;
  P_inverse(2, 2) = P_inverse(3, 3) = P_inverse(4, 4) = -1 / c;
  for (Eigen::Index i = first_torque; i < n; ++i) {
    P(i, i) = m * c * c / (T * T);
    P_inverse(i, i) = 1 / P(i, i);
  }
  return spectral_radius(P_inverse.lazyProduct(step.lazyProduct(P).eval()));
}

// Root of z^(d+1) (z - 1) + beta (z + 1) / 2 on the unit circle, beta = B T / m. There z = exp(i a) with a (d
// + 1) = pi/2 (odd), i.e. a = pi / (2 (d + 1)), and beta = 2 tan(a / 2).
double largest_stable_damping(double inertia, double period_s, int delay) {
  const double a = std::numbers::pi / (2 * (delay + 1));
  return 2 * std::tan(a / 2) * inertia / period_s;
}

}  // namespace godobject
