// --tracker: which trackers of a run are real, and where.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "platform/cli/run/buses.h"
#include "platform/linux/tracker_thread.h"

namespace godobject {

/// What --tracker asks for: NAME=PORT for each tracker of the scene, a port alone where it has one, or "scene" for the
/// ports that the scene has. Puts the ports into the scene; makes the plan of a device without buses `real`. None
/// given: trackers are simulated. The trackers' clock is the buses': where those are simulated, real ones are an error.
void plan_trackers(std::span<const std::string> given, bool buses_are_given, SceneConfig& scene,
                   BusPlan& plan, std::vector<std::string>& errors);

/// The bytes of the definition files of a tracker's tools, relative to `folder` (the scene's). Errors name the tool and
/// the file.
ToolDefinitions read_tool_definitions(const TrackerParams& params, const std::filesystem::path& folder,
                                      std::vector<std::string>& errors);

/// A thread for each tracker; none when there are errors.
std::vector<std::unique_ptr<TrackerThread>> start_trackers(const std::vector<TrackerParams>& trackers,
                                                           const std::filesystem::path& folder,
                                                           std::vector<std::string>& errors);

}  // namespace godobject
