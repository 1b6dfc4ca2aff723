// Sets up the nodes of a rig that have a profile, before the loop runs. Steps per node (CiA 301, CiA 402):
//   reset communication, wait for boot-up, pre-operational; identity 1000h, 1018h; heartbeat producer 1017h,
//   consumer 1016h; options and the profile's own writes; PDO mapping with read-back; 60C2h; 6076h against
//   the scene; 6060h, wait for 6061h.
// All nodes are set up concurrently, with one outstanding SDO request each. A node is left pre-operational:
// Rig does NMT start and runs the CiA 402 state machine. Not for the real-time thread: SDO uses only the bus
// time that the rig's cycle leaves, and errors are strings.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/can/bus.h"
#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

class NodeCommissioning;

class Commissioning {
 public:
  /// cycle_s: SYNC period of the rig, s. buses: one per params.buses, open, outliving this; all their frames
  /// are read until done(). Allocates; poll() does not.
  Commissioning(const RigParams& params, double cycle_s, const RigProfiles& profiles,
                std::span<CanBus* const> buses);
  ~Commissioning();
  Commissioning(const Commissioning&) = delete;
  Commissioning& operator=(const Commissioning&) = delete;

  /// Processes received frames and sends due ones; never waits. Call it every 1 ms or so, and when a frame
  /// has arrived, until done(). now: any monotonic clock, the same in every call, ns.
  void poll(Nanoseconds now) noexcept;

  /// True if every node is set up or has failed; immediately if no node has a profile.
  bool done() const noexcept;
  /// True if a node has failed. The rig must not be started then; errors() returns the reasons.
  bool failed() const noexcept;
  /// Returns one line per failed node: device, bus, node, object, error, line of the profile.
  std::vector<std::string> errors() const;
  /// Returns one status line per unfinished node: device and the event it waits for.
  std::vector<std::string> pending() const;

 private:
  std::vector<CanBus*> buses_;
  std::vector<std::unique_ptr<NodeCommissioning>> nodes_;
};

}  // namespace godobject
