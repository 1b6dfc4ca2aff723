// The dozen lines of `check` about a valid scene.
#pragma once

#include <string>
#include <vector>

#include "platform/cli/run/options.h"

namespace godobject {

/// Returns scene, device, load of the buses and bounds as lines.
std::vector<std::string> check_lines(const RunOptions& options, const PreparedRun& prepared);

}  // namespace godobject
