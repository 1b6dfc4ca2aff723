// --tracker: selects the real trackers of a run and their ports.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "platform/cli/run/buses.h"
#include "platform/linux/tracker_thread.h"

namespace godobject {

/// Applies the values of --tracker. Each is NAME=PORT, or a port alone for a single tracker, or "scene" for
/// the scene's ports. Writes the ports into the scene, and plans a device without buses as `real`. Default:
/// trackers are simulated. Trackers share the clock of the buses, so real trackers with simulated buses are
/// an error.
void plan_trackers(std::span<const std::string> given, bool buses_are_given, SceneConfig& scene,
                   BusPlan& plan, std::vector<std::string>& errors);

/// Reads the definition files of a tracker's tools, relative to `folder`, that of the scene. Errors name the
/// tool and the file.
ToolDefinitions read_tool_definitions(const TrackerParams& params, const std::filesystem::path& folder,
                                      std::vector<std::string>& errors);

/// Starts a thread for each tracker; none if there are errors.
std::vector<std::unique_ptr<TrackerThread>> start_trackers(const std::vector<TrackerParams>& trackers,
                                                           const std::filesystem::path& folder,
                                                           std::vector<std::string>& errors);

}  // namespace godobject
