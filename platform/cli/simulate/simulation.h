// A simulated device in wall time: a rig with real buses at the host's end of its wires, trackers on pseudo-terminals.
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

/// One bus of the scene and the address where it is offered.
struct OfferedBus {
  std::string name;     // of the scene's bus
  std::string address;  // as on the command line
  std::size_t wire = 0;
  bool is_tap = false;  // a node of its own on the wire, which hears all of it
  std::unique_ptr<LinuxBus> bus;
};

/// The motors of a drive, as the plant feels them.
struct MotorWatch {
  double torque_Nm = 0;
  double max_torque_Nm = 0;  // largest absolute value so far
  double t_nonzero_s = 0;    // until when it was not zero, at the latest; of simulated time
  double t_commanded_s = 0;  // when a command of the host for this drive last came
};

class Simulation {
 public:
  /// buses: open; one per wire, then taps. trackers: open; one per tracker of the scene. scene: where it has a rig
  /// SimRig::why_not() is empty. Without a rig the motion waits for the first byte to a tracker instead of SYNC.
  /// Allocates; step() does not.
  /// devices: profiles of the devices that the nodes play.
  Simulation(const SceneConfig& scene, const RigProfiles& devices, const Motion& motion,
             std::vector<OfferedBus> buses, bool motion_waits_for_sync,
             std::vector<std::unique_ptr<TrackerLine>> trackers = {});

  /// Everything up to `now`, since the start: frames in, wires, nodes, mechanics, frames out.
  void step(Nanoseconds now) noexcept;
  /// When step() has something to do again, if no frame comes before.
  Nanoseconds next_event() const noexcept;

  /// For ppoll.
  std::vector<int> descriptors() const;
  const std::vector<OfferedBus>& buses() const noexcept { return buses_; }
  std::span<const std::unique_ptr<TrackerLine>> trackers() const noexcept { return trackers_; }
  /// Plays a fault from the next step on. Empty, or why not. Allocates.
  std::string play(const FaultConfig& config);
  void clear_faults() noexcept;
  Nanoseconds now() const noexcept { return now_ns_; }
  double motion_time() const noexcept;
  /// All there is to say about it, for status and report.
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

  RigParams params_;  // without buses where the device has no rig
  std::vector<TrackerParams> tracker_params_;
  Nanoseconds period_ns_;
  std::vector<OfferedBus> buses_;
  std::optional<SimRig> rig_;
  std::vector<BusBridge> bridges_;  // one per buses_
  std::vector<MotorWatch> motors_;  // one per drive
  std::vector<std::unique_ptr<TrackerLine>> trackers_;
  std::optional<SimTrackers> tools_;  // of the trackers
  Nanoseconds now_ns_ = 0;
  Nanoseconds t_plant_ns_ = 0;              // up to which the mechanics have run
  Nanoseconds t_sync_ns_ = 0;               // of the latest SYNC
  std::optional<Nanoseconds> t_motion_ns_;  // at which the motion began
  std::uint64_t syncs_ = 0;
};

}  // namespace godobject
