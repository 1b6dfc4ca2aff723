// A simulated rig in wall time, with real buses at the host's end of its wires.
#pragma once

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "platform/cli/bus_bridge.h"
#include "sim/motion.h"
#include "sim/sim_rig.h"

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
  double t_nonzero_s = 0;    // when it last was not zero, of simulated time
};

class Simulation {
 public:
  /// buses: open; one per wire, then taps. scene: SimRig::why_not() is empty. Allocates; step() does not.
  Simulation(const SceneConfig& scene, const Motion& motion, std::vector<OfferedBus> buses,
             bool motion_waits_for_sync);

  /// Everything up to `now`, since the start: frames in, wires, nodes, mechanics, frames out.
  void step(Nanoseconds now) noexcept;
  /// When step() has something to do again, if no frame comes before.
  Nanoseconds next_event() const noexcept;

  /// For ppoll.
  std::vector<int> descriptors() const;
  const std::vector<OfferedBus>& buses() const noexcept { return buses_; }
  FaultInjector& faults() noexcept { return rig_.faults(); }
  Nanoseconds now() const noexcept { return now_ns_; }
  double motion_time() const noexcept;
  /// All there is to say about it, for status and report.
  nlohmann::ordered_json to_json() const;

 private:
  void take_frames() noexcept;
  void on_sync() noexcept;
  void run_plant() noexcept;
  void watch_motors() noexcept;

  RigParams params_;
  Nanoseconds period_ns_;
  std::vector<OfferedBus> buses_;
  SimRig rig_;
  std::vector<BusBridge> bridges_;  // one per buses_
  std::vector<MotorWatch> motors_;  // one per drive
  Nanoseconds now_ns_ = 0;
  Nanoseconds t_plant_ns_ = 0;              // up to which the mechanics have run
  Nanoseconds t_sync_ns_ = 0;               // of the latest SYNC
  std::optional<Nanoseconds> t_motion_ns_;  // at which the motion began
  std::uint64_t syncs_ = 0;
};

}  // namespace godobject
