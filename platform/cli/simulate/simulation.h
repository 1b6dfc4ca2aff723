// A simulated device in wall time: a rig with real buses at the host's end of its wires, trackers on
// pseudo-terminals.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "platform/cli/simulate/bridge.h"
#include "platform/cli/simulate/tracker_line.h"
#include "platform/motion/motion.h"
#include "sim/rig/rig.h"
#include "sim/tracker/trackers.h"

namespace godobject {

/// One bus of the scene and the address at which it is offered.
struct OfferedBus {
  std::string name;     // name of the scene's bus
  std::string address;  // as on the command line
  std::size_t wire = 0;
  bool is_tap = false;  // true: a node of its own on the wire, which receives all frames
  std::unique_ptr<LinuxBus> bus;
};

/// Torque of a drive's motor as applied to the plant.
struct MotorWatch {
  double torque_Nm = 0;
  double max_torque_Nm = 0;  // largest absolute value so far
  double t_nonzero_s = 0;    // latest simulated time with a torque other than zero
  double t_commanded_s = 0;  // time of the host's latest command for this drive
};

class Simulation {
 public:
  /// Allocates; step() does not.
  /// buses: open; one per wire, then taps.
  /// trackers: open; one per tracker of the scene.
  /// scene: with a rig, SimRig::why_not() must be empty. Without a rig the motion waits for the first byte to
  /// a tracker instead of SYNC.
  /// devices: profiles of the simulated nodes.
  Simulation(const SceneConfig& scene, const RigProfiles& devices, const Motion& motion,
             std::vector<OfferedBus> buses, bool motion_waits_for_sync,
             std::vector<std::unique_ptr<TrackerLine>> trackers = {});

  /// Simulates up to `now`, since the start: frames in, wires, nodes, mechanics, frames out.
  void step(Nanoseconds now) noexcept;
  /// Returns the time of the next step() if no frame arrives before.
  Nanoseconds next_event() const noexcept;

  /// Descriptors for ppoll.
  std::vector<int> descriptors() const;
  const std::vector<OfferedBus>& buses() const noexcept { return buses_; }
  std::span<const std::unique_ptr<TrackerLine>> trackers() const noexcept { return trackers_; }
  /// Plays a fault from the next step on. Returns why this failed; empty on success. Allocates.
  std::string play(const FaultConfig& config);
  void clear_faults() noexcept;
  Nanoseconds now() const noexcept { return now_ns_; }
  double motion_time() const noexcept;
  /// Returns the state for `status` and the report.
  nlohmann::ordered_json to_json() const;

 private:
  void run_rig(Nanoseconds now) noexcept;
  void run_trackers() noexcept;
  nlohmann::ordered_json faults_json() const;
  nlohmann::ordered_json bus_off_json() const;
  void take_frames() noexcept;
  void on_sync() noexcept;
  void watch_commands(std::size_t bus, const CanFrame& frame) noexcept;
  void run_plant() noexcept;
  void watch_motors() noexcept;

  RigParams params_;  // without buses if the device has no rig
  std::vector<TrackerParams> tracker_params_;
  Nanoseconds period_ns_;
  std::vector<OfferedBus> buses_;
  std::optional<SimRig> rig_;
  std::vector<BusBridge> bridges_;  // one per bus of buses_
  std::vector<MotorWatch> motors_;  // one per drive
  std::vector<std::unique_ptr<TrackerLine>> trackers_;
  std::optional<SimTrackers> tools_;  // tools of the trackers
  Nanoseconds now_ns_ = 0;
  Nanoseconds t_plant_ns_ = 0;              // end of the simulated mechanics
  Nanoseconds t_sync_ns_ = 0;               // time of the latest SYNC
  std::optional<Nanoseconds> t_motion_ns_;  // start of the motion
  std::uint64_t syncs_ = 0;
};

}  // namespace godobject
