// Options of `godobject run` and the session prepared from them, ready to boot, or all errors with their
// places. Writes no files.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/bus_load.h"
#include "hal/rig/params.h"
#include "platform/cli/program.h"
#include "platform/cli/report/files.h"
#include "platform/cli/run/loop.h"
#include "platform/linux/device_threads.h"
#include "platform/linux/shared_world.h"
#include "platform/linux/socket_device.h"
#include "platform/rig/buses.h"
#include "platform/rig/log_link.h"
#include "platform/rt/background_file.h"
#include "platform/session/passivity.h"
#include "platform/session/session.h"
#include "platform/view/live.h"
#include "platform/view/pointer.h"

namespace godobject {

struct BusPlan {
  BusChoice choice = BusChoice::sim;
  RigAddresses real;  // addresses, for BusChoice::real
};

struct RunOptions {
  std::string scene;                  // path
  bool realtime = false;              // always true on real buses
  bool fast = false;                  // true if given explicitly
  bool seal = false;                  // true: refuses undocumented system calls of the loop
  bool require_rt = false;            // true: runs only on a machine that meets all real_time_checks()
  std::optional<unsigned> core;       // of the loop's thread alone; none: any core
  double deadline_us = 0;             // runtime of SCHED_DEADLINE in each step; 0: SCHED_FIFO
  std::vector<std::string> buses;     // see plan_buses()
  std::vector<std::string> trackers;  // see plan_trackers()
  Rearm rearm = Rearm::never;
  bool strict = false;             // true: an axis without passivity margin is an error
  std::optional<double> duration;  // s
  std::optional<double> step;      // s
  std::string integrator;          // empty: the scene's; as for the paths below
  std::string motion;
  RunFileNames files;
  bool keeps_faults = true;  // not with --on-fault none
  std::string report;
  std::optional<std::string> spacemouse;  // socket of its daemon; empty: the default one
  std::string device;                     // socket of the program that is the device; empty: none
  std::string world;                      // shared memory of another simulation; empty: none
  std::optional<std::uint16_t> view;      // port of the view; 0: a default one
  std::string view_address = "127.0.0.1";
  std::string openigtlink;  // PORT or ADDRESS:PORT of its server; empty: none
  double openigtlink_rate_hz = 60;
  bool view_input = false;  // true: the page's pointer is the device
  bool quiet = false;       // true: print only warnings and faults
  bool only_check = false;  // true for `check`: nothing is opened, started or written
  ProgramParts parts{};
};

struct PreparedRun {
  std::unique_ptr<PointerDevice> pointer;               // with --view-input; else null
  std::unique_ptr<JointPointer> joint_pointer;          // instead of `pointer`, if pages move joints
  std::unique_ptr<SpaceMouse> spacemouse;               // with --spacemouse; else null
  std::unique_ptr<SpaceMouseThread> spacemouse_thread;  // see connect_spacemouse()
  std::unique_ptr<SocketDevice> socket_device;          // with --device; else null
  bool has_own_device = false;                          // true: the program's device moves the tool
  std::unique_ptr<HandDevice> own_device;               // see add_own_device()
  std::unique_ptr<SharedWorld> shared_world;            // with --world; else null
  std::unique_ptr<WorldPlanes> world;                   // likewise
  std::unique_ptr<Session> session;                     // null if there are errors
  RunPlan plan;
  BusPlan buses;
  LinuxLink* link = nullptr;          // the session's link if its buses are real; they are closed
  const LogLink* log = nullptr;       // the session's log if its buses are logs
  RigProfiles profiles;               // profiles of the scene's nodes
  std::vector<BusLoad> bus_loads;     // worst case; empty with --bus direct
  Passivity passivity;                // margins of the driven axes; empty with --bus direct
  std::vector<std::string> errors;    // "file:line:column: text", "file: text" or "--option: text"
  std::vector<std::string> warnings;  // of the same forms
  std::vector<std::string> notes;
};

PreparedRun prepare(const RunOptions& options);

/// True if a device moves the tool in wall time: real buses, trackers, a SpaceMouse or a program's hand.
bool has_hardware(const RunOptions& options, const PreparedRun& run);

/// Returns why the run cannot be started again; empty if it can: it has no hardware and writes no steps.
std::string why_no_reset(const RunOptions& options, const PreparedRun& run);

/// Prepares the same run again: session and pointers alone, or errors. why_no_reset() must be empty.
PreparedRun prepare_again(const RunOptions& options, const PreparedRun& run);

/// True if the scene has a device on buses.
inline bool has_rig(const SceneConfig& scene) { return scene.device && scene.device->rig; }

// Checks of prepare(), in checks.cc.

/// Checks that every output can be written, and that none overwrites an input or another output.
void check_outputs(const RunOptions& options, std::vector<std::string>& errors);

/// Names the input log of faults by scene and time, for a run on real buses or trackers without --on-fault.
/// Prints why not if the folder cannot be written.
void name_fault_log(RunOptions& options, const PreparedRun& run);

/// Creates missing folders of the outputs. Returns why one cannot be created; empty on success.
std::string make_folders(const RunOptions& options);

/// Checks the options that depend on --view.
void check_view(const RunOptions& options, const SceneConfig& scene, std::vector<std::string>& errors);

/// Checks that the scene has the buses, contacts and nets that the options record.
void check_recorded(const RunOptions& options, BusChoice choice, const SceneConfig& scene,
                    std::vector<std::string>& errors);

/// Checks the options that depend on real buses, trackers and logs.
void check_real_buses(const RunOptions& options, PreparedRun& run);

/// Checks that the machine has the core of --core, and that --deadline is shorter than the step.
void check_scheduling(const RunOptions& options, double step_s, std::vector<std::string>& errors);

/// Returns the checks of the scene's buses at these addresses, where the bus has some.
std::vector<RtStep> check_buses(const SceneConfig& scene, const RigAddresses& where);

/// Returns the requirements that this machine does not meet, with remedies, as lines. Empty if it meets all:
/// with --require-rt real_time_checks() and those of real buses, else the steps of --core and --deadline.
std::string why_not_real_time(const RunOptions& options, const PreparedRun& run);

/// Warns of a motion whose target is faster than a hand.
/// duration: duration of the run, s.
void check_speed(const SceneConfig& scene, const Motion& motion, double duration, const std::string& file,
                 std::vector<std::string>& warnings);

// Texts of `check` about a valid scene.

/// Returns scene, device, load of the buses and bounds as lines.
std::vector<std::string> check_lines(const RunOptions& options, const PreparedRun& prepared);

/// Returns a head and one line for each drive; empty for a rig without drives. cycle_s: step of the scene, s.
std::vector<std::string> time_to_zero_lines(const RigParams& rig, double cycle_s,
                                            const RigProfiles& profiles);

// ---- devices of a run: --bus and --tracker select buses, trackers and ports; --spacemouse its daemon --

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

/// Checks that another simulation can surround the bodies of the scene, and gives it its planes.
void check_world(const RunOptions& options, SceneConfig& scene, std::vector<std::string>& errors);

/// Makes the device of the program and adds it to the session. Returns why this failed; empty on success.
std::string add_own_device(const RunOptions& options, PreparedRun& run);

/// Connects the SpaceMouse of the run, if any, to its daemon and starts a thread. Returns why this failed;
/// empty on success.
std::string connect_spacemouse(const RunOptions& options, PreparedRun& run);

// ---- view of a run: its server, its console lines, and the frames from the loop --------------------

/// Adds the texts for the bits of a frame.
void add_words(ViewAbout& about);
/// Returns lines with the page's address and its warning.
std::vector<std::string> view_lines(const std::string& url, const std::string& address);
/// Returns the warning of a page served on this address; empty: none.
std::string view_warning(const std::string& address);

/// Starts the server of --openigtlink and sets the plan's tap. Null without the option, or with the reason in
/// why_not. wall_origin_ns: time of day when the clock of the buses is 0.
std::unique_ptr<OpenIgtLinkServer> start_openigtlink(const RunOptions& options, PreparedRun& prepared,
                                                     Nanoseconds wall_origin_ns, std::string& why_not);

class RunView {
 public:
  /// Starts the server and sets the plan's tap. Returns why this failed; empty on success.
  std::string start(const RunOptions& options, PreparedRun& prepared);
  /// Replaces the session of the run, which a page has reset, by one at its start. Not while the loop runs.
  /// Returns why this failed; empty on success.
  std::string start_again(const RunOptions& options, PreparedRun& prepared);
  std::vector<std::string> announcement() const { return view_lines(server_->url(), address_); }

 private:
  std::string address_;
  std::unique_ptr<BackgroundFile> console_;
  std::unique_ptr<LiveView> live_;
  std::unique_ptr<ViewServer> server_;
};

}  // namespace godobject
