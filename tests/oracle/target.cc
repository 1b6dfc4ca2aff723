#include "tests/oracle/target.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace godobject::oracle {

namespace {

constexpr std::size_t stencil_size = 7;

/// Weights of the samples at `nodes` in the first and second derivative at t of the polynomial through them.
/// They are the derivatives of the Lagrange basis, node by node, by the product rule.
struct DerivativeWeights {
  std::array<double, stencil_size> d1{};
  std::array<double, stencil_size> d2{};
};

DerivativeWeights derivative_weights(std::span<const double> nodes, double t) {
  DerivativeWeights weights;
  for (std::size_t j = 0; j < nodes.size(); ++j) {
    double value = 1, d1 = 0, d2 = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      if (i == j) continue;
      const double slope = 1 / (nodes[j] - nodes[i]);
      const double factor = slope * (t - nodes[i]);
      d2 = d2 * factor + 2 * d1 * slope;
      d1 = d1 * factor + value * slope;
      value *= factor;
    }
    weights.d1[j] = d1;
    weights.d2[j] = d2;
  }
  return weights;
}

}  // namespace

TabulatedTarget::TabulatedTarget(std::vector<double> times, const std::vector<Vector3d>& p,
                                 const std::vector<Quaterniond>& q)
    : times_(std::move(times)), samples_(times_.size()) {
  if (times_.size() < 2 || p.size() != times_.size() || q.size() != times_.size()) {
    throw std::invalid_argument("a tabulated target needs two or more rows of equal length");
  }
  if (std::adjacent_find(times_.begin(), times_.end(), std::greater_equal<>()) != times_.end()) {
    throw std::invalid_argument("the times of a tabulated target must ascend");
  }
  Eigen::Vector4d previous = Eigen::Vector4d::Zero();
  for (std::size_t i = 0; i < times_.size(); ++i) {
    Eigen::Vector4d wxyz(q[i].w(), q[i].x(), q[i].y(), q[i].z());
    if (wxyz.dot(previous) < 0) wxyz = -wxyz;  // q and -q are one attitude: stay on one side
    previous = wxyz;
    samples_[i].value << p[i], wxyz;
  }
  for (std::size_t i = 0; i < times_.size(); ++i) differentiate(i);
}

void TabulatedTarget::differentiate(std::size_t i) {
  const std::size_t count = std::min(stencil_size, times_.size());
  const std::size_t centred = i - std::min(i, count / 2);
  const std::size_t first = std::min(centred, times_.size() - count);
  const DerivativeWeights weights = derivative_weights(std::span(times_).subspan(first, count), times_[i]);
  // The weights of a derivative sum to zero: differences to sample i lose fewer digits.
  for (std::size_t j = 0; j < count; ++j) {
    const Coordinates difference = samples_[first + j].value - samples_[i].value;
    samples_[i].d1 += weights.d1[j] * difference;
    samples_[i].d2 += weights.d2[j] * difference;
  }
}

RigidState TabulatedTarget::at(double t) const {
  const double rounding = 1e-12 * std::max(1.0, std::abs(times_.back()));
  if (!(t >= times_.front() - rounding && t <= times_.back() + rounding)) {
    throw std::out_of_range("the target's motion is not known at t = " + std::to_string(t));
  }
  const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  const auto i = static_cast<std::size_t>(after - times_.begin()) - 1;
  const Sample& a = samples_[i];
  const Sample& b = samples_[i + 1];

  // Taylor to second order from a, plus s^3 times the quadratic that meets value, d1, d2 at b; s = 0..1.
  const double h = times_[i + 1] - times_[i];
  const double s = (t - times_[i]) / h;
  const Coordinates a1 = h * a.d1, a2 = 0.5 * h * h * a.d2;
  const Coordinates r0 = b.value - a.value - a1 - a2;
  const Coordinates r1 = h * b.d1 - a1 - 2 * a2;
  const Coordinates r2 = h * h * b.d2 - 2 * a2;
  const Coordinates c3 = 10 * r0 - 4 * r1 + 0.5 * r2;
  const Coordinates c4 = -15 * r0 + 7 * r1 - r2;
  const Coordinates c5 = 6 * r0 - 3 * r1 + 0.5 * r2;
  const Coordinates value = a.value + s * (a1 + s * (a2 + s * (c3 + s * (c4 + s * c5))));
  const Coordinates rate = (a1 + s * (2 * a2 + s * (3 * c3 + s * (4 * c4 + s * 5 * c5)))) / h;

  const Quaterniond q(value[3], value[4], value[5], value[6]);
  const Quaterniond qd(rate[3], rate[4], rate[5], rate[6]);
  RigidState motion;
  motion.p = value.head<3>();
  motion.v = rate.head<3>();
  motion.q = q.normalized();
  motion.w = 2 * (qd * q.conjugate()).vec() / q.squaredNorm();  // (1) q' = 1/2 W q; the norm drops out
  return motion;
}

}  // namespace godobject::oracle
