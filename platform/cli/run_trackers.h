// --tracker: which trackers of a run are real, and where.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "platform/cli/run_buses.h"

namespace godobject {

/// What --tracker asks for: NAME=PORT for each tracker of the scene, a port alone where it has one, or "scene" for the
/// ports that the scene has. Puts the ports into the scene; makes the plan of a device without buses `real`. None
/// given: trackers are simulated. The trackers' clock is the buses': where those are simulated, real ones are an error.
void plan_trackers(std::span<const std::string> given, bool buses_are_given, SceneConfig& scene,
                   BusPlan& plan, std::vector<std::string>& errors);

}  // namespace godobject
