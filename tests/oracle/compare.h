// Largest differences between two solutions of one case.
#pragma once

#include <cmath>
#include <stdexcept>

#include "tests/oracle/solve.h"

namespace godobject::oracle {

/// Largest component-wise difference over all times and bodies; q up to its sign. NaN where a state has NaN.
struct WorstDifference {
  double p = 0;  // m
  double q = 0;
  double v = 0;  // m/s
  double w = 0;  // rad/s
};

/// The larger of two numbers, NaN if either is.
inline double larger(double a, double b) { return std::isnan(b) || a <= b ? b : a; }

template <class Vector>
double largest_component(const Vector& difference) {
  return difference.cwiseAbs().template maxCoeff<Eigen::PropagateNaN>();
}

inline WorstDifference larger(const WorstDifference& a, const WorstDifference& b) {
  return {larger(a.p, b.p), larger(a.q, b.q), larger(a.v, b.v), larger(a.w, b.w)};
}

inline WorstDifference worst_difference(const RigidState& a, const RigidState& b) {
  const double sign = a.q.dot(b.q) < 0 ? -1 : 1;
  return {largest_component(a.p - b.p), largest_component(a.q.coeffs() - sign * b.q.coeffs()),
          largest_component(a.v - b.v), largest_component(a.w - b.w)};
}

/// The solutions must have the same times and bodies; throws std::invalid_argument if not.
inline WorstDifference worst_difference(const Solution& a, const Solution& b) {
  if (a.times != b.times) throw std::invalid_argument("solutions at different times");
  WorstDifference worst;
  for (std::size_t i = 0; i < a.states.size(); ++i) {
    if (a.states[i].size() != b.states[i].size())
      throw std::invalid_argument("solutions of different bodies");
    for (std::size_t body = 0; body < a.states[i].size(); ++body) {
      worst = larger(worst, worst_difference(a.states[i][body], b.states[i][body]));
    }
  }
  return worst;
}

}  // namespace godobject::oracle
