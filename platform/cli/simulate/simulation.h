// A simulated device in wall time: a rig with real buses at the host's end of its wires, trackers on
// pseudo-terminals. Commands to it, one per line, are each answered by one line of JSON.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "platform/linux/bus/bus.h"
#include "platform/linux/serial_port.h"
#include "platform/motion/motion.h"
#include "sim/bus/can_bus.h"
#include "sim/rig/rig.h"
#include "sim/tracker/tracker.h"
#include "sim/tracker/trackers.h"

namespace godobject {

/// Clock of the simulated hardware: wall time, without the time for which the simulating program is held up.
/// Hardware is never held up. A simulated drive that missed time with its program would find its deadline
/// passed before it has read the frames that arrived meanwhile.
class HeldClock {
 public:
  /// Longest lateness that the simulation makes up for; only the rest is lost. It is below the deadlines of
  /// drives, and long enough for wires to keep their speed on a busy machine.
  static constexpr Nanoseconds made_up_ns = 5'000'000;

  /// Returns the simulated time at `wall_ns`, the time since the start.
  /// due_ns: simulated time at which the program had to go on; it does so earlier if frames arrive.
  Nanoseconds advance(Nanoseconds wall_ns, Nanoseconds due_ns) noexcept {
    const Nanoseconds late_ns = wall_ns - held_ns_ - std::max(due_ns, now_ns_);
    held_ns_ += std::max<Nanoseconds>(0, late_ns - made_up_ns);
    now_ns_ = wall_ns - held_ns_;
    return now_ns_;
  }
  /// Returns the latest simulated time.
  Nanoseconds now() const noexcept { return now_ns_; }
  /// Returns the wall time, since the start, of a simulated time that is not over yet.
  Nanoseconds wall(Nanoseconds simulated_ns) const noexcept { return simulated_ns + held_ns_; }
  /// Returns the total time of all holds.
  Nanoseconds held() const noexcept { return held_ns_; }

 private:
  Nanoseconds now_ns_ = 0;
  Nanoseconds held_ns_ = 0;
};

struct BridgeCounters {
  std::uint64_t from_bus = 0;  // frames received from the real bus
  std::uint64_t to_bus = 0;    // frames sent to it
  std::uint64_t refused = 0;   // frames from the bus refused by the port: queue full or bus-off
  std::uint64_t dropped = 0;   // frames for the bus dropped: it was down, or full for `patience_ns`
};

/// Carries frames both ways between a real bus and a port on a simulated wire.
class BusBridge {
 public:
  /// Longest wait of a frame for a bus with a full transmit queue.
  static constexpr Nanoseconds patience_ns = 20'000'000;

  /// bus, port: open; they outlive the bridge.
  BusBridge(LinuxBus& bus, SimCanPort& port) noexcept : bus_(bus), port_(port) {}

  /// Receives the next frame of the real bus, which deliver() passes on.
  [[nodiscard]] bool try_take(CanFrame& frame) noexcept;
  /// Sends the frame on the simulated wire.
  void deliver(const CanFrame& frame) noexcept;
  /// Sends the frames received by the port on the real bus.
  void forward(Nanoseconds now) noexcept;

  const BridgeCounters& counters() const noexcept { return counters_; }
  LinuxBus& bus() const noexcept { return bus_; }

 private:
  LinuxBus& bus_;
  SimCanPort& port_;
  std::optional<CanFrame> waiting_;  // waits while the bus is full
  Nanoseconds t_waiting_ns_ = 0;     // start of the wait
  BridgeCounters counters_;
};

/// A simulated tracker on a pseudo-terminal, equal to a real one for a host.
class TrackerLine {
 public:
  explicit TrackerLine(std::string name, std::unique_ptr<SimTracker> far)
      : name_(std::move(name)), far_(std::move(far)) {}
  ~TrackerLine();
  TrackerLine(const TrackerLine&) = delete;
  TrackerLine& operator=(const TrackerLine&) = delete;

  /// Returns why there is no pseudo-terminal; empty on success.
  std::string open();
  /// Passes the host's bytes to the tracker, and its bytes to the host. Bytes that are not read wait, and are
  /// lost once the queue is full.
  void step(Nanoseconds now) noexcept;

  const std::string& name() const noexcept { return name_; }
  const std::string& path() const noexcept { return port_.path(); }
  int descriptor() const noexcept { return port_.descriptor(); }
  SimTracker& far() noexcept { return *far_; }
  const SimTracker& far() const noexcept { return *far_; }
  /// Returns the number of bytes received from the host.
  std::uint64_t num_received() const noexcept { return num_received_; }

 private:
  std::string name_;
  std::unique_ptr<SimTracker> far_;
  SerialPort port_;
  int slave_fd_ = -1;
  std::array<std::uint8_t, 512> out_{};
  std::span<const std::uint8_t> unsent_{};  // part of out_
  std::uint64_t num_received_ = 0;
};

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

  /// Simulates up to `wall_ns`, wall time since the start: frames in, wires, nodes, mechanics, frames out.
  /// Simulated time stands still while the program is held up, see HeldClock.
  void step(Nanoseconds wall_ns) noexcept;
  /// Returns the wall time of the next step() if no frame arrives before.
  Nanoseconds next_step() const noexcept { return clock_.wall(next_event()); }

  /// Descriptors for ppoll.
  std::vector<int> descriptors() const;
  const std::vector<OfferedBus>& buses() const noexcept { return buses_; }
  std::span<const std::unique_ptr<TrackerLine>> trackers() const noexcept { return trackers_; }
  /// Plays a fault from the next step on. Returns why this failed; empty on success. Allocates.
  std::string play(const FaultConfig& config);
  void clear_faults() noexcept;
  Nanoseconds now() const noexcept { return clock_.now(); }
  double motion_time() const noexcept;
  /// Returns the state for `status` and the report.
  nlohmann::ordered_json to_json() const;

 private:
  Nanoseconds next_event() const noexcept;
  void run_rig(Nanoseconds now) noexcept;
  void run_trackers() noexcept;
  nlohmann::ordered_json faults_json() const;
  nlohmann::ordered_json bus_off_json() const;
  void start_motion() noexcept;
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
  HeldClock clock_;
  Nanoseconds t_plant_ns_ = 0;              // end of the simulated mechanics
  Nanoseconds t_sync_ns_ = 0;               // time of the latest SYNC
  std::optional<Nanoseconds> t_motion_ns_;  // start of the motion
  double motion_held_s_ = 0;                // least time of the motion
  std::uint64_t syncs_ = 0;
};

/// Executes "fault VERB key=value ...", "clear", "status" or "quit", and returns the answer. Allocates.
/// quit: set by the command of that name.
std::string answer(std::string_view command, Simulation& simulation, bool& quit);

/// Reads whole lines from a descriptor without blocking, which it sets for the descriptor during its life.
class LineInput {
 public:
  explicit LineInput(int descriptor) noexcept;
  ~LineInput();
  LineInput(const LineInput&) = delete;
  LineInput& operator=(const LineInput&) = delete;

  static constexpr std::size_t max_line = 1001;  // bytes

  /// Returns false if no line is complete yet. Of a longer line it returns the first max_line bytes or more,
  /// once.
  [[nodiscard]] bool try_line(std::string& line);
  /// Returns -1 after the end of input.
  int descriptor() const noexcept { return ended_ ? -1 : descriptor_; }

 private:
  int descriptor_;
  int former_flags_;
  bool ended_ = false, skips_ = false;
  std::string text_;
};

}  // namespace godobject
