// The dozen lines that `check` says about a scene that would run.
#pragma once

#include <string>
#include <vector>

#include "platform/cli/run/options.h"

namespace godobject {

/// What runs, on what, how full its buses are, within which bounds.
std::vector<std::string> check_lines(const RunOptions& options, const PreparedRun& prepared);

}  // namespace godobject
