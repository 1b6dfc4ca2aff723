// Smooth curves through samples at increasing times: cubic and continuously differentiable. They are of
// fourth order where the samples are even. Elsewhere rates are limited (Steffen 1990), so that curves stay
// between neighbouring samples without overshoot. Evaluation neither allocates nor fails.
// sudden_move() detects wrong or missing samples.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/math/types.h"

namespace godobject {

/// The times of the samples, strictly increasing, at least one.
class TimeGrid {
 public:
  /// Interval of t: between samples i and i + 1, h apart, at fraction s.
  /// resting: true before the first or after the last sample, or with one sample only; then i is that sample.
  struct Place {
    std::size_t i = 0;
    double s = 0;
    double h = 1;
    bool resting = false;
  };

  explicit TimeGrid(std::vector<double> times) : times_(std::move(times)) {}

  std::size_t size() const noexcept { return times_.size(); }
  double first() const noexcept { return times_.front(); }
  double last() const noexcept { return times_.back(); }
  Place locate(double t) const noexcept;
  /// Returns the sample in effect at t: the last one not after t, or the first sample before all others.
  std::size_t held(double t) const noexcept;

  /// Weights of the derivative at sample i of the polynomial through up to five samples around it:
  /// sum_j weights[j] x[begin + j]. Fourth order with five samples.
  struct Stencil {
    std::size_t begin = 0;
    std::size_t size = 0;
    std::array<double, 5> weights{};
  };
  Stencil derivative_at(std::size_t i) const noexcept;

  /// True if no interval in the stencil of sample i is more than max_unevenness times as long as another.
  /// Otherwise the polynomial through the samples overshoots far.
  bool is_even_at(std::size_t i) const noexcept;
  static constexpr double max_unevenness = 3;
  /// Returns the time from sample i to the next, s; i is not the last.
  double interval(std::size_t i) const noexcept { return times_[i + 1] - times_[i]; }

 private:
  std::vector<double> times_;
};

/// Value and time derivative.
template <class T>
struct Sample {
  T value;
  T rate;
};

/// Curve of numbers or vectors: the cubic with given values and rates at both ends of each interval.
template <class T>
class VectorCurve {
 public:
  /// values: one per time of the grid.
  VectorCurve(const TimeGrid& grid, std::vector<T> values);
  Sample<T> at(const TimeGrid::Place& place) const noexcept;

 private:
  std::vector<T> values_, rates_;
};

/// Curve of attitudes q(t) = q_i exp(phi(t)). phi is the cubic in the tangent space at q_i with the attitudes
/// and angular velocities of both samples at its ends.
class RotationCurve {
 public:
  /// attitudes: unit quaternions of either sign, one per time of the grid.
  RotationCurve(const TimeGrid& grid, std::vector<Quat> attitudes);

  struct Attitude {
    Quat q;
    Vec3 w_W;  // angular velocity, the exact derivative of q
  };
  Attitude at(const TimeGrid::Place& place) const noexcept;

 private:
  struct Interval {
    Vec3 phi;         // log(q_i^-1 q_{i+1})
    Vec3 rate_begin;  // phi' at both ends
    Vec3 rate_end;
  };
  std::vector<Quat> attitudes_;
  std::vector<Interval> intervals_;
};

/// Interval from sample `from` to the next.
struct SuddenMove {
  std::size_t from = 0;
  double distance = 0;  // m or rad
  double time = 0;      // s
};

/// Returns the fastest interval above least_speed that is more than 10 times as fast as the slower of two
/// intervals on either side. A single wrong sample makes two fast intervals, there and back.
/// distance(i): distance from sample i to the next.
template <class Distance>
std::optional<SuddenMove> sudden_move(const TimeGrid& grid, double least_speed, Distance distance) {
  constexpr double much_faster = 10;
  const std::size_t n = grid.size() - 1;
  const auto speed = [&](std::size_t i) { return distance(i) / grid.interval(i); };
  const auto slower_of = [&](std::size_t near, std::size_t far) {
    return far < n ? std::min(speed(near), speed(far)) : near < n ? speed(near) : 0;
  };
  std::optional<SuddenMove> found;
  double fastest = least_speed;
  for (std::size_t i = 0; i < n && n > 1; ++i) {
    // i - 1 and i - 2 wrap around before the first sample, and are out of range then
    if (speed(i) <= fastest ||
        speed(i) <= much_faster * std::max(slower_of(i - 1, i - 2), slower_of(i + 1, i + 2)))
      continue;
    fastest = speed(i);
    found = {.from = i, .distance = distance(i), .time = grid.interval(i)};
  }
  return found;
}

}  // namespace godobject
