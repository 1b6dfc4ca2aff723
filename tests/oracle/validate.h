// The rules of a case that the oracle solves.
#pragma once

#include "tests/oracle/case/case.h"

namespace godobject::oracle {

/// How far joints may be open at the start (m, rad, and per second): files round, and the solver projects.
inline constexpr double start_tolerance = 1e-6;

/// Throws std::invalid_argument for a case that breaks a rule of case.h or joint.h, or with joints that do
/// not hold at the start. The message names the body or joint and the rule.
void validate(const Case& problem);

}  // namespace godobject::oracle
