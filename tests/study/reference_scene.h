// Scenes for error against run time.
#pragma once

#include <string>
#include <vector>

#include "tests/oracle/case/case.h"

namespace godobject::study {

struct ReferenceScene {
  std::string name;
  std::string about;     // one line for the report
  oracle::Case problem;  // all bodies coupled, or none
  double duration = 0;   // s
  double from = 0;       // s: start of the error comparison
  bool stiff = false;    // the explicit oracle would take minutes

  bool is_coupled() const { return problem.bodies.front().coupling.has_value(); }
  bool is_articulated() const { return !problem.joints.empty(); }
};

/// S1: a free tool on an analytic target, 20 s, errors from 0.5 s on.
ReferenceScene scene_s1();

/// Articulated scenes: S3, 10 s, and S5 with five links, 0.5 s (chaotic later).
ReferenceScene reference_s3();
ReferenceScene reference_chain();

/// Returns every reference scene.
std::vector<ReferenceScene> reference_scenes();

}  // namespace godobject::study
