// What `godobject run` was asked for, and what becomes of it: a session that is ready to boot, or every
// complaint with its place. Nothing is written here.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/bus_load.h"
#include "platform/cli/report/files.h"
#include "platform/cli/run/buses.h"
#include "platform/cli/run/cycle.h"
#include "platform/cli/run/trackers.h"
#include "platform/linux/spacemouse_thread.h"
#include "platform/rig/log_link.h"
#include "platform/session/passivity.h"
#include "platform/session/simulated_devices.h"
#include "platform/view/joint_pointer.h"
#include "platform/view/pointer.h"

namespace godobject {

struct RunOptions {
  std::string scene;                  // path
  bool realtime = false;              // on real buses always
  bool fast = false;                  // asked for, rather than by default
  std::vector<std::string> buses;     // see plan_buses()
  std::vector<std::string> trackers;  // see plan_trackers()
  Rearm rearm = Rearm::never;
  bool strict = false;             // an axis without passivity margin is an error
  std::optional<double> duration;  // s
  std::optional<double> step;      // s
  std::string integrator;          // empty: the scene's; the same goes for the paths below
  std::string motion;
  RunFileNames files;
  std::string report;
  std::optional<std::string> spacemouse;  // socket of its daemon; empty: the usual one
  std::optional<std::uint16_t> view;      // port of the view; 0: a default one
  std::string view_address = "127.0.0.1";
  bool view_input = false;       // the page's pointer is the device
  bool quiet = false;            // nothing but warnings, faults and the exit code
  bool only_check = false;       // as `check`: nothing is opened, started or written
  SimulatedDevices simulated{};  // those of the program
};

struct PreparedRun {
  std::unique_ptr<PointerDevice> pointer;               // --view-input; null without
  std::unique_ptr<JointPointer> joint_pointer;          // instead of `pointer` where pages move joints
  std::unique_ptr<SpaceMouse> spacemouse;               // --spacemouse; null without
  std::unique_ptr<SpaceMouseThread> spacemouse_thread;  // see platform/cli/run/spacemouse.h
  std::unique_ptr<Session> session;                     // null where there are errors
  RunPlan plan;
  BusPlan buses;
  LinuxLink* link = nullptr;          // the session's, where its buses are real; they are closed
  const LogLink* log = nullptr;       // the session's, where its buses are logs
  RigProfiles profiles;               // of the scene's nodes
  std::vector<BusLoad> bus_loads;     // what the scene's buses carry at worst; empty with --bus direct
  Passivity passivity;                // of the driven axes; empty with --bus direct
  std::vector<std::string> errors;    // "file:line:column: what", "file: what" or "--option: what"
  std::vector<std::string> warnings;  // the same forms
  std::vector<std::string> notes;
};

PreparedRun prepare(const RunOptions& options);

/// Makes the folders of the outputs that are not there yet. Empty, or why one cannot be made.
std::string make_folders(const RunOptions& options);

}  // namespace godobject
