// Plays faults on the wires, ports and nodes of a simulated rig.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sim/fault/sensor_fault.h"
#include "sim/fault/target.h"
#include "sim/node/encoder.h"
#include "sim/node/second_host.h"

namespace godobject {

struct ActiveFault {
  SimFault fault;
  std::optional<Nanoseconds> t_end_ns;  // none: to the end
};

class FaultInjector {
 public:
  /// Faults that are active or wait at the same time, besides those scheduled at set-up.
  static constexpr std::size_t capacity = 64;

  // Set-up, in the rig's order of buses. What is added outlives the injector. Allocates.

  /// nodes: those that run on the wire; a second node of an id and a second host join them. rig: that of all buses.
  void add_bus(SimCanWire& wire, SimCanPort& host, std::vector<SimNode*>& nodes, const RigParams& rig);
  /// Index for shown().
  std::size_t add_node(std::size_t bus, SimCanPort& port, SimNode& node, const Calibration& calibration);
  void schedule_all(std::span<const SimFault> faults);

  // Then. Nothing allocates.

  /// From the next run() on, in which its motion time has come. False when full.
  [[nodiscard]] bool schedule(const SimFault& fault) noexcept;
  /// Once a period, before its SYNC: begins and ends what is due.
  void run(Nanoseconds now, double motion_time) noexcept;
  /// Ends all that is active and forgets all that waits.
  void clear(Nanoseconds now) noexcept;

  /// The joint of a node is at q now.
  void move(std::size_t node, double q) noexcept { nodes_[node].q = q; }
  /// What its sensor shows there; all nodes have been moved.
  double shown(std::size_t node) const noexcept;
  std::span<const ActiveFault> active() const noexcept { return active_; }
  std::uint64_t begun() const noexcept { return begun_; }
  /// Port of a node that was added; null where there is none.
  const SimCanPort* port_of(std::size_t bus, std::uint8_t node_id) const noexcept;

 private:
  struct BusEntry {
    SimCanPort* host;
    std::vector<SimNode*>* nodes;
    std::unique_ptr<SimCanPort> impostor_port;  // of the second nodes of an id: closed without one
    SimEncoder* impostor = nullptr;             // that is on the bus now
    std::unique_ptr<SimCanPort> second_port;    // of the second host: closed without it
    std::unique_ptr<SimSecondHost> second_host;
  };
  struct NodeEntry {
    std::size_t bus;
    SimCanPort* port;
    SimNode* node;
    std::unique_ptr<SimEncoder> impostor;
    Calibration calibration;
    SensorFault sensor{};
    std::size_t shows;  // of nodes_: the one whose sensor sends under its id
    double q = 0;       // where its joint is
    double clock_error_ppm = 0;
  };

  void begin(const SimFault& fault, Nanoseconds now) noexcept;
  void end(const SimFault& fault) noexcept;
  void apply(Nanoseconds now) noexcept;
  void apply(SimCanPort& port, std::size_t bus, std::uint8_t node_id) const noexcept;
  std::optional<double> level(FaultVerb verb, std::size_t bus, std::uint8_t node_id) const noexcept;
  void admit_impostor(const SimFault& fault, Nanoseconds now) noexcept;
  void dismiss_impostor(BusEntry& bus) noexcept;
  void admit_second_host(const SimFault& fault, Nanoseconds now) noexcept;
  void dismiss_second_host(BusEntry& bus) noexcept;
  void swap_ids() noexcept;
  std::size_t index_of(std::size_t bus, std::uint8_t node_id) const noexcept;
  NodeEntry* node_of(const SimFault& fault) noexcept;
  template <class Function>
  void for_each_port(const SimFault& fault, Function&& function) noexcept;

  std::vector<BusEntry> buses_;
  std::vector<NodeEntry> nodes_;
  std::vector<SimFault> waiting_;
  std::vector<ActiveFault> active_;
  std::uint64_t begun_ = 0;
};

}  // namespace godobject
