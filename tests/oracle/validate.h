// The rules of a case that the oracle solves.
#pragma once

#include "tests/oracle/case/case.h"

namespace godobject::oracle {

/// How far joints may be open at the start (m, rad, and per second): files round, and the solver projects.
inline constexpr double start_tolerance = 1e-6;

/// Throws std::invalid_argument, naming the body or joint and the rule, for a case that breaks a rule of
/// case.h or joint.h, or whose joints do not hold at the start.
void validate(const Case& problem);

}  // namespace godobject::oracle
