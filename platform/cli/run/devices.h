// Devices of a run: --bus and --tracker select its buses, its real trackers and their ports; --spacemouse
// connects to the daemon.
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "platform/linux/device_threads.h"
#include "platform/rig/buses.h"
#include "platform/session/session.h"

namespace godobject {

struct PreparedRun;
struct RunOptions;

struct BusPlan {
  BusChoice choice = BusChoice::sim;
  RigAddresses real;  // addresses, for BusChoice::real
};

/// Plans the buses from the values of --bus: "sim", "direct", an address for a scene with one bus, or
/// NAME=ADDRESS for each bus. Default: sim for a scene with buses or trackers; otherwise direct, with a note.
BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes);

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

/// Checks that the scene has a SpaceMouse and that no other option moves the tool. Adds errors and notes to
/// the run.
void check_spacemouse(const RunOptions& options, const SceneConfig& scene, PreparedRun& run);

/// Checks that a program can be the device of the scene, and that no other option moves the tool.
void check_socket_device(const RunOptions& options, const SceneConfig& scene,
                         std::vector<std::string>& errors);

/// Connects the SpaceMouse of the run, if any, to its daemon and starts a thread. Returns why this failed;
/// empty on success.
std::string connect_spacemouse(const RunOptions& options, PreparedRun& run);

}  // namespace godobject
