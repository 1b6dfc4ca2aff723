#include "platform/motion/curve.h"

#include <algorithm>
#include <cmath>

#include "core/math/so3.h"

namespace godobject {

namespace {

/// Evaluates a cubic Hermite polynomial on an interval of length h at fraction s, and its time derivative.
template <class T>
Sample<T> hermite(const T& x0, const T& rate0, const T& x1, const T& rate1, double h, double s) noexcept {
  const double r = 1 - s;
  return {T(x0 * (r * r * (1 + 2 * s)) + rate0 * (h * s * r * r) + x1 * (s * s * (1 + 2 * r)) -
            rate1 * (h * s * s * r)),
          T((x1 - x0) * (6 * s * r / h) + rate0 * (r * (1 - 3 * s)) + rate1 * (s * (3 * s - 2)))};
}

/// Returns the rotation vector of q, with an angle in [0, 2 pi) so that a neighbour more than half a turn
/// away keeps its side.
Vec3 short_rotation(const Quat& q) noexcept {
  const double sine = q.vec().norm();
  if (sine < 1e-12) return 2 * q.vec();
  return q.vec() * (2 * std::atan2(sine, q.w()) / sine);
}

Quat turn_by(const Vec3& phi) noexcept {
  const double angle = phi.norm();
  const double s = angle < 1e-12 ? 0.5 : std::sin(0.5 * angle) / angle;
  return Quat(std::cos(0.5 * angle), s * phi.x(), s * phi.y(), s * phi.z());
}

/// Returns J(phi), with w_B = J phi' for q = exp(phi), a = |phi|:
/// I - (1 - cos a)/a^2 [phi]x + (a - sin a)/a^3 [phi]x^2.
Mat3 tangent(const Vec3& phi) noexcept {
  const double a_sq = phi.squaredNorm(), a = std::sqrt(a_sq);
  const bool small = a < 1e-4;
  const double half_sine = std::sin(0.5 * a);
  const double b = small ? 0.5 - a_sq / 24 : 2 * half_sine * half_sine / a_sq;
  const double c = small ? 1.0 / 6 - a_sq / 120 : (a - std::sin(a)) / (a_sq * a);
  const Mat3 S = skew(phi);
  return Mat3::Identity() - b * S + c * S * S;
}

/// Returns the inverse of J: I + [phi]x / 2 + (1 - (a/2) cot(a/2))/a^2 [phi]x^2, for a < 2 pi.
Mat3 inverse_tangent(const Vec3& phi) noexcept {
  const double a_sq = phi.squaredNorm(), a = std::sqrt(a_sq);
  const double c = a < 1e-4 ? 1.0 / 12 + a_sq / 720 : (1 - 0.5 * a / std::tan(0.5 * a)) / a_sq;
  const Mat3 S = skew(phi);
  return Mat3::Identity() + 0.5 * S + c * S * S;
}

/// Returns Steffen's rate at a sample between intervals of lengths h_l and h_r with mean rates l and r. It is
/// the rate of the parabola through the three samples, zero at a turning point, and at most twice the smaller
/// mean rate. The cubic is monotone then.
double limited_rate(double h_l, double l, double h_r, double r) noexcept {
  if (!(l * r > 0)) return 0;
  const double parabola = std::abs(l * h_r + r * h_l) / (h_l + h_r);
  return std::copysign(std::min({parabola, 2 * std::abs(l), 2 * std::abs(r)}), l);
}
Vec3 limited_rate(double h_l, const Vec3& l, double h_r, const Vec3& r) noexcept {
  Vec3 rate;
  for (Eigen::Index c = 0; c < 3; ++c) rate[c] = limited_rate(h_l, l[c], h_r, r[c]);
  return rate;
}

/// Returns the limited rate at sample i; at either end the rate of the end interval.
/// step(i, j): difference from sample i to its neighbour j.
template <class Step>
auto limited_rate_at(const TimeGrid& grid, std::size_t i, Step step) noexcept {
  using T = decltype(step(i, i));
  if (grid.size() == 1) return T(step(i, i));
  const bool first = i == 0, last = i + 1 == grid.size();
  T l = first ? T(step(i, i)) : T(step(i, i - 1) * (-1 / grid.interval(i - 1)));
  T r = last ? T(step(i, i)) : T(step(i, i + 1) * (1 / grid.interval(i)));
  if (first) return r;
  if (last) return l;
  return T(limited_rate(grid.interval(i - 1), l, grid.interval(i), r));
}

}  // namespace

bool TimeGrid::is_even_at(std::size_t i) const noexcept {
  const Stencil stencil = derivative_at(i);
  if (stencil.size < 2) return true;
  const auto begin = times_.begin() + static_cast<std::ptrdiff_t>(stencil.begin);
  double least = begin[1] - begin[0], most = least;
  for (std::ptrdiff_t j = 1; j + 1 < static_cast<std::ptrdiff_t>(stencil.size); ++j) {
    least = std::min(least, begin[j + 1] - begin[j]);
    most = std::max(most, begin[j + 1] - begin[j]);
  }
  return most <= max_unevenness * least;
}

TimeGrid::Place TimeGrid::locate(double t) const noexcept {
  if (size() == 1 || !(t >= first())) return {.resting = true};
  if (t > last()) return {.i = size() - 1, .resting = true};
  const auto after = std::upper_bound(times_.begin(), times_.end(), t);
  const std::size_t i = std::min(static_cast<std::size_t>(after - times_.begin()) - 1, size() - 2);
  const double h = times_[i + 1] - times_[i];
  return {.i = i, .s = (t - times_[i]) / h, .h = h};
}

std::size_t TimeGrid::held(double t) const noexcept {
  if (!(t >= first())) return 0;
  const auto after = std::upper_bound(times_.begin(), times_.end(), t);
  return static_cast<std::size_t>(after - times_.begin()) - 1;
}

TimeGrid::Stencil TimeGrid::derivative_at(std::size_t i) const noexcept {
  Stencil stencil;
  stencil.size = std::min<std::size_t>(5, size());
  stencil.begin = std::min(i - std::min<std::size_t>(i, 2), size() - stencil.size);
  const std::size_t centre = i - stencil.begin;
  const auto time = [&](std::size_t j) { return times_[stencil.begin + j]; };
  // Lagrange: l_j'(t_i) = prod_{k != i,j} (t_i - t_k) / prod_{k != j} (t_j - t_k); the weights sum to zero.
  for (std::size_t j = 0; j < stencil.size; ++j) {
    if (j == centre) continue;
    double weight = 1 / (time(j) - time(centre));
    for (std::size_t k = 0; k < stencil.size; ++k) {
      if (k != j && k != centre) weight *= (time(centre) - time(k)) / (time(j) - time(k));
    }
    stencil.weights[j] = weight;
    stencil.weights[centre] -= weight;
  }
  return stencil;
}

template <class T>
VectorCurve<T>::VectorCurve(const TimeGrid& grid, std::vector<T> values) : values_(std::move(values)) {
  for (std::size_t i = 0; i < grid.size(); ++i) {
    if (!grid.is_even_at(i)) {
      rates_.push_back(limited_rate_at(
          grid, i, [&](std::size_t from, std::size_t to) { return T(values_[to] - values_[from]); }));
      continue;
    }
    const TimeGrid::Stencil stencil = grid.derivative_at(i);
    T rate = values_[i] * 0;
    for (std::size_t j = 0; j < stencil.size; ++j) rate += stencil.weights[j] * values_[stencil.begin + j];
    rates_.push_back(rate);
  }
}

template <class T>
Sample<T> VectorCurve<T>::at(const TimeGrid::Place& place) const noexcept {
  const std::size_t i = place.i;
  if (place.resting) return {values_[i], T(values_[i] * 0)};
  return hermite<T>(values_[i], rates_[i], values_[i + 1], rates_[i + 1], place.h, place.s);
}

template class VectorCurve<double>;
template class VectorCurve<Vec3>;

RotationCurve::RotationCurve(const TimeGrid& grid, std::vector<Quat> attitudes)
    : attitudes_(std::move(attitudes)) {
  const std::size_t n = attitudes_.size();
  for (std::size_t i = 1; i < n; ++i) {
    if (attitudes_[i].dot(attitudes_[i - 1]) < 0) attitudes_[i].coeffs() *= -1;
  }
  // At phi = 0 the derivative of log(q_i^-1 q(t)) is the angular velocity in body axes.
  std::vector<Vec3> w_B(n, Vec3::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    if (!grid.is_even_at(i)) {
      w_B[i] = limited_rate_at(grid, i, [&](std::size_t from, std::size_t to) {
        return short_rotation(attitudes_[from].conjugate() * attitudes_[to]);
      });
      continue;
    }
    const TimeGrid::Stencil stencil = grid.derivative_at(i);
    for (std::size_t j = 0; j < stencil.size; ++j) {
      w_B[i] +=
          stencil.weights[j] * short_rotation(attitudes_[i].conjugate() * attitudes_[stencil.begin + j]);
    }
  }
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const Vec3 phi = short_rotation(attitudes_[i].conjugate() * attitudes_[i + 1]);
    intervals_.push_back({phi, w_B[i], inverse_tangent(phi) * w_B[i + 1]});
  }
}

RotationCurve::Attitude RotationCurve::at(const TimeGrid::Place& place) const noexcept {
  const Quat& q_i = attitudes_[place.i];
  if (place.resting) return {q_i, Vec3::Zero()};
  const Interval& interval = intervals_[place.i];
  const Sample<Vec3> phi =
      hermite<Vec3>(Vec3::Zero(), interval.rate_begin, interval.phi, interval.rate_end, place.h, place.s);
  const Quat q = (q_i * turn_by(phi.value)).normalized();
  return {q, to_world(q, tangent(phi.value) * phi.rate)};
}

}  // namespace godobject
