// Injects faults into the wires, ports and nodes of a simulated rig.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/bus/random.h"
#include "sim/fault/sensor_fault.h"
#include "sim/fault/target.h"
#include "sim/node/encoder.h"
#include "sim/node/stranger.h"

namespace godobject {

struct ActiveFault {
  SimFault fault;
  Nanoseconds t_begin_ns;
  std::optional<Nanoseconds> t_end_ns;  // none: until the end
};

class FaultInjector {
 public:
  /// Maximum number of simultaneously active or waiting faults, besides those scheduled at set-up.
  static constexpr std::size_t capacity = 64;

  // Set-up, in the order of the rig's buses. Added objects must outlive the injector. Allocates.

  /// seed: of the counts at power-on of incremental sensors.
  explicit FaultInjector(std::uint64_t seed = 1) noexcept : random_(seed) {}

  /// nodes: nodes that run on the wire; impostors and strangers are added to it. rig: parameters of all
  /// buses.
  void add_bus(SimCanWire& wire, SimCanPort& host, std::vector<SimNode*>& nodes, const RigParams& rig);
  /// Returns the index for shown().
  std::size_t add_node(std::size_t bus, SimCanPort& port, SimNode& node, const Calibration& calibration);
  void schedule_all(std::span<const SimFault> faults);

  // Run time; no call allocates.

  /// Schedules a fault from the next run() on whose motion time has reached its `at`. Returns false if full.
  [[nodiscard]] bool schedule(const SimFault& fault) noexcept;
  /// Begins and ends due faults; call it once per period, before its SYNC.
  void run(Nanoseconds now, double motion_time) noexcept;
  /// Ends all active faults and drops all waiting ones.
  void clear(Nanoseconds now) noexcept;

  /// Sets the coordinate q of a node's joint, rad or m.
  void move(std::size_t node, double q) noexcept { nodes_[node].q = q + nodes_[node].power_on; }
  /// Returns the coordinate shown by a node's sensor, after move() of all nodes.
  double shown(std::size_t node) const noexcept;
  /// True while a fault presses the button.
  bool is_pressed(const ButtonParams& button) const noexcept {
    const std::optional<double> input = level(FaultVerb::press, button.bus, button.node_id);
    return input && presses(*input, button);
  }
  std::span<const ActiveFault> active() const noexcept { return active_; }
  std::uint64_t begun() const noexcept { return begun_; }
  /// Returns the port of an added node; null if it does not exist.
  const SimCanPort* port_of(std::size_t bus, std::uint8_t node_id) const noexcept;

 private:
  struct Stranger {
    Stranger(SimCanWire& wire, std::vector<CanFrame> frames)
        : port(std::make_unique<SimCanPort>(wire)),
          node(std::make_unique<SimStranger>(*port, std::move(frames))) {}
    std::unique_ptr<SimCanPort> port;  // closed while it is not on the bus
    std::unique_ptr<SimStranger> node;
  };
  struct BusEntry {
    SimCanPort* host;
    std::vector<SimNode*>* nodes;
    std::unique_ptr<SimCanPort> impostor_port;  // for a second node with an existing id; closed without one
    SimEncoder* impostor = nullptr;             // the one on the bus now
    Stranger second_host, flood;
  };
  struct NodeEntry {
    std::size_t bus;
    SimCanPort* port;
    SimNode* node;
    std::unique_ptr<SimEncoder> impostor;
    Calibration calibration;
    SensorFault sensor{};
    std::size_t shows;  // index into nodes_ of the node whose sensor is sent under this id
    double q = 0;       // coordinate of its joint, since its power-on
    double power_on;    // displacement of an incremental sensor since its power-on, rad or m
    double clock_error_ppm = 0;
  };

  void begin(const SimFault& fault, Nanoseconds now) noexcept;
  void end(const SimFault& fault) noexcept;
  void apply(Nanoseconds now) noexcept;
  void apply(SimCanPort& port, std::size_t bus, std::uint8_t node_id) const noexcept;
  std::optional<double> level(FaultVerb verb, std::size_t bus, std::uint8_t node_id) const noexcept;
  void admit_impostor(const SimFault& fault, Nanoseconds now) noexcept;
  void dismiss_impostor(BusEntry& bus) noexcept;
  void admit(Stranger BusEntry::*which, const SimFault& fault, double period_s, Nanoseconds now) noexcept;
  void dismiss(Stranger BusEntry::*which, const SimFault& fault) noexcept;
  void swap_ids() noexcept;
  double draw_power_on(const Calibration& calibration) noexcept;
  std::size_t index_of(std::size_t bus, std::uint8_t node_id) const noexcept;
  NodeEntry* node_of(const SimFault& fault) noexcept;
  template <class Function>
  void for_each_port(const SimFault& fault, Function&& function) noexcept;

  std::vector<BusEntry> buses_;
  std::vector<NodeEntry> nodes_;
  std::vector<SimFault> waiting_;
  std::vector<ActiveFault> active_;
  std::uint64_t begun_ = 0;
  SplitMix64 random_;
};

}  // namespace godobject
