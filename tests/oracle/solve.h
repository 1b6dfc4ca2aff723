// The oracle's entry: a case in, its states at given times out.
#pragma once

#include <span>
#include <vector>

#include "tests/oracle/case/case.h"
#include "tests/oracle/joint/joint.h"

namespace godobject::oracle {

struct Solution {
  std::vector<double> times;                             // s
  std::vector<std::vector<RigidState>> states;           // [time][body]
  std::vector<std::vector<JointWrench>> reactions = {};  // [time][joint]
  double joint_drift = 0;                                // largest joint error before a projection, m or rad
};

/// Tolerance for coupled bodies, which damp their errors: leaves them near rounding. A free body that tumbles
/// amplifies the errors of its first steps a million times, so use 1e-16 there. With a target, tolerances
/// below 1e-13 cost many small steps, because its own values are rounded to double.
inline constexpr double default_tolerance = 1e-12;

/// Integrates `problem` from t = 0 and samples it at `times` (ascending, >= 0). `tolerance` bounds the local
/// error of each number of the state, see ExtrapolationIntegrator. The joints are projected shut at the
/// start, at every knot of a target or a prescribed joint, and at every one of `times`. Throws
/// std::invalid_argument for a case that breaks a rule of case.h or joint.h, and std::runtime_error if the
/// tolerance cannot be met. Exceptions of the targets pass.
Solution solve(const Case& problem, std::span<const double> times, double tolerance = default_tolerance);

/// 0, step, 2 step, .. up to duration (included when it is a multiple of step up to rounding).
std::vector<double> uniform_times(double duration, double step);

}  // namespace godobject::oracle
