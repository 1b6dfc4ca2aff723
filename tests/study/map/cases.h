// Extreme cases one by one, each with its expected property, by name and integrator.
#pragma once

#include <string>
#include <vector>

#include "tests/study/map/sample.h"

namespace godobject::study {

struct CaseResult {
  std::string name;
  std::string measure;  // measured quantity, with its unit
  double limit = 0, value = 0;
  std::string integrator = {};
  MapSample run = {};  // its fault, gain and steps

  bool holds() const { return run.fault == 0 && run.gain <= MapSample::max_silent_gain && value <= limit; }
};

/// Runs the cases of bodies on joints. Instances: ImplicitEuler, TrBdf2.
template <class I>
std::vector<CaseResult> cases_of_joints();

/// Runs all cases with both integrators. steps_at_rest: length of the case of a body at rest.
std::vector<CaseResult> study_cases(long steps_at_rest = 10'000'000);

}  // namespace godobject::study
