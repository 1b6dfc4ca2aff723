// --spacemouse: checks of the option, and the connection to the daemon.
#pragma once

#include <string>

#include "platform/cli/run/options.h"

namespace godobject {

/// Checks that the scene has a SpaceMouse and that no other option moves the tool. Adds errors and notes to
/// the run.
void check_spacemouse(const RunOptions& options, const SceneConfig& scene, PreparedRun& run);

/// Connects the SpaceMouse of the run, if any, to its daemon and starts a thread. Returns why this failed;
/// empty on success.
std::string connect_spacemouse(const RunOptions& options, PreparedRun& run);

}  // namespace godobject
