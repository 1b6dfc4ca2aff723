// --spacemouse: whether it goes with the rest, and the connection to its daemon.
#pragma once

#include <string>

#include "platform/cli/run/options.h"

namespace godobject {

/// Complaints and notes go into the run. The SpaceMouse is the only hand, and there is one in the scene.
void check_spacemouse(const RunOptions& options, const SceneConfig& scene, PreparedRun& run);

/// Where the run has a SpaceMouse: to its daemon, with a thread from here on. Empty, or why not.
std::string connect_spacemouse(const RunOptions& options, PreparedRun& run);

}  // namespace godobject
