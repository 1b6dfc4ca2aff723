// Smooth curves through samples at increasing times: cubic, once continuously differentiable, fourth order accurate where
// the samples are even; where they are not, between their neighbours: rates are limited (Steffen 1990), and nothing
// overshoots. Evaluation neither allocates nor fails.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/math/types.h"

namespace godobject {

/// The times of the samples, strictly increasing, at least one.
class TimeGrid {
 public:
  /// Where t lies: between samples i and i + 1 at fraction s, h apart. resting: before the first or
  /// after the last sample, or there is only one; then i is that sample.
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
  /// The sample that holds at t: the last one not after t; before the first sample, the first.
  std::size_t held(double t) const noexcept;

  /// Derivative at sample i of the polynomial through up to five samples around it:
  /// sum_j weights[j] x[begin + j]. Fourth order with five samples.
  struct Stencil {
    std::size_t begin = 0;
    std::size_t size = 0;
    std::array<double, 5> weights{};
  };
  Stencil derivative_at(std::size_t i) const noexcept;

  /// Between the times of the stencil of sample i no interval is more than max_unevenness times as long as another. Where
  /// they are not even the polynomial through the samples swings far beyond them.
  bool is_even_at(std::size_t i) const noexcept;
  static constexpr double max_unevenness = 3;
  /// From sample i to the one after it, s; from the last one none.
  double interval(std::size_t i) const noexcept { return times_[i + 1] - times_[i]; }

 private:
  std::vector<double> times_;
};

/// Value and time derivative of T.
template <class T>
struct Sample {
  T value;
  T rate;
};

/// Curve of numbers or vectors: the cubic with given values and rates at both ends of an interval.
template <class T>
class VectorCurve {
 public:
  /// values: one per time of the grid.
  VectorCurve(const TimeGrid& grid, std::vector<T> values);
  Sample<T> at(const TimeGrid::Place& place) const noexcept;

 private:
  std::vector<T> values_, rates_;
};

/// Curve of attitudes: q(t) = q_i exp(phi(t)), phi the cubic in the tangent space at q_i whose ends have
/// the attitudes and angular velocities of both samples.
class RotationCurve {
 public:
  /// attitudes: unit, one per time of the grid, either sign.
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

}  // namespace godobject
