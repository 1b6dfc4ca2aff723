// The scenes on which error is set against run time.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/oracle/case.h"

namespace godobject::study {

struct ReferenceScene {
  std::string name;
  std::string about;     // one line for the report
  oracle::Case problem;  // one body
  double duration = 0;   // s
  double from = 0;       // s: errors count from here
};

/// S1: a free tool on an analytic target, 20 s, errors from 0.5 s on.
ReferenceScene scene_s1();

/// Every reference scene. Those whose motion is a file come from `shared` (the folder with reference/); a
/// scene whose file is not there is named in `skipped`, with the reason. Throws for a malformed file.
std::vector<ReferenceScene> reference_scenes(const std::filesystem::path& shared,
                                             std::vector<std::string>& skipped);

}  // namespace godobject::study
