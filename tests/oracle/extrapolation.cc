#include "tests/oracle/extrapolation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace godobject::oracle {

namespace {

constexpr int num_substeps_of(int column) { return 2 * (column + 1); }

}  // namespace

ExtrapolationIntegrator::ExtrapolationIntegrator(OdeFunction f, Scalar tolerance)
    : f_(std::move(f)), tolerance_(tolerance) {
  if (!(tolerance > 0)) throw std::invalid_argument("the tolerance must be positive");
}

/// Leap-frog: y1 = y0 + d f(y0), y_{i+1} = y_{i-1} + 2 d f(y_i). For an even number of sub-steps the error of
/// the last value is a series in d^2. Increments to y are summed, not y itself: rounding stays relative to
/// them.
void ExtrapolationIntegrator::midpoint_increment(Scalar t, Scalar h, int num_substeps, const ScalarVector& y,
                                                 ScalarVector& dy) {
  const Scalar d = h / num_substeps;
  before_.setZero(y.size());
  dy = d * f0_;
  for (int i = 1; i < num_substeps; ++i) {
    now_ = y + dy;
    f_(t + i * d, now_, f1_);
    before_ += 2 * d * f1_;
    before_.swap(dy);
  }
}

Scalar ExtrapolationIntegrator::step(Scalar t, Scalar h, const ScalarVector& y, ScalarVector& y_next) {
  f0_.resize(y.size());
  f1_.resize(y.size());
  f_(t, y, f0_);
  for (int j = 0; j < num_columns; ++j) {
    midpoint_increment(t, h, num_substeps_of(j), y, increments_[j]);
    // Aitken-Neville in d^2, in place: entry i becomes the extrapolation over columns i..j.
    for (int i = j - 1; i >= 0; --i) {
      const Scalar ratio = static_cast<Scalar>(num_substeps_of(j)) / num_substeps_of(i);
      increments_[i] = increments_[i + 1] + (increments_[i + 1] - increments_[i]) / (ratio * ratio - 1);
    }
  }
  y_next = y + increments_[0];
  const Eigen::Array<Scalar, Eigen::Dynamic, 1> error = (increments_[0] - increments_[1]).array().abs();
  const Eigen::Array<Scalar, Eigen::Dynamic, 1> allowed =
      tolerance_ * (1 + y.array().abs().max(y_next.array().abs()));
  // A NaN must reach the caller; maxCoeff may lose it.
  return (error / allowed).isFinite().all() ? (error / allowed).maxCoeff()
                                            : std::numeric_limits<Scalar>::infinity();
}

void ExtrapolationIntegrator::advance(Scalar t, Scalar t_end, ScalarVector& y) {
  constexpr Scalar order_of_estimate = 2 * num_columns - 1;
  ScalarVector y_next;
  if (h_ == 0) h_ = t_end - t;
  while (t < t_end) {
    const bool is_last = t + h_ >= t_end;
    const Scalar h = is_last ? t_end - t : h_;
    const Scalar error = step(t, h, y, y_next);
    const Scalar factor =
        std::clamp(Scalar(0.85) * std::pow(error, -1 / order_of_estimate), Scalar(0.1), Scalar(3));
    if (!(error <= 1)) {
      h_ = factor * h;
      if (h_ < 1e-16L * std::max(Scalar(1), std::abs(t_end))) {
        throw std::runtime_error("no step is accurate enough at t = " + std::to_string(t));
      }
      continue;
    }
    // A step shortened by t_end does not indicate the possible step size.
    h_ = is_last ? std::max(h_, factor * h) : factor * h;
    t = is_last ? t_end : t + h;
    y.swap(y_next);
  }
}

}  // namespace godobject::oracle
