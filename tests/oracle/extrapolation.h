// Integrator of smooth ordinary differential equations to near rounding error: Gragg's modified midpoint
// rule, extrapolated to step zero. (Gragg-Bulirsch-Stoer; Hairer, Norsett, Wanner, Solving ODEs I, section
// II.9.)
#pragma once

#include <array>
#include <functional>

#include "tests/oracle/precision.h"

namespace godobject::oracle {

/// y' = f(t, y); writes y' into dy_dt, which has the size of y.
using OdeFunction = std::function<void(Scalar t, const ScalarVector& y, ScalarVector& dy_dt)>;

/// Order 12, explicit: six midpoint solutions with 2, 4, .., 12 sub-steps per step. Steps are chosen so that
/// the last extrapolation changes no component by more than tolerance * (1 + |y|). That is the error of the
/// order-10 result, so the one kept is better.
class ExtrapolationIntegrator {
 public:
  /// tolerance > 0; below about 1e-17 rounding prevents any step from passing.
  ExtrapolationIntegrator(OdeFunction f, Scalar tolerance);

  /// Takes y from t to t_end >= t. Throws std::runtime_error if the step size must fall below the resolution
  /// of t.
  void advance(Scalar t, Scalar t_end, ScalarVector& y);

  /// One step of size h from (t, y) into y_next; returns its error in units of the tolerance (accept if <=
  /// 1).
  Scalar step(Scalar t, Scalar h, const ScalarVector& y, ScalarVector& y_next);

 private:
  static constexpr int num_columns = 6;

  void midpoint_increment(Scalar t, Scalar h, int num_substeps, const ScalarVector& y, ScalarVector& dy);

  OdeFunction f_;
  Scalar tolerance_;
  Scalar h_ = 0;  // step size to try next; 0: not known yet
  ScalarVector f0_, f1_, before_, now_;
  std::array<ScalarVector, num_columns>
      increments_;  // last row of the extrapolation table of y(t + h) - y(t)
};

}  // namespace godobject::oracle
