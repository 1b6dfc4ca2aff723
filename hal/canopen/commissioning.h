// Sets up the nodes of a rig that have a profile, before the loop runs. Per node (CiA 301, CiA 402):
//   reset communication, wait for boot-up, pre-operational; identity 1000h, 1018h; heartbeat producer 1017h,
//   consumer 1016h; options and the profile's own writes; PDO mapping with read-back; 60C2h; 6076h against
//   the scene; 6060h, wait for 6061h.
// All nodes at once, one outstanding SDO request each. The node is left pre-operational: NMT start and the
// CiA 402 state machine are the Rig's. It does not belong on the real-time thread: SDO takes what bus time
// the rig's cycle leaves, and the errors are strings.
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
  /// buses: one per params.buses, open, outliving this. Reads all that arrives on them until done().
  /// Allocates; poll does not.
  Commissioning(const RigParams& params, const RigProfiles& profiles, std::span<CanBus* const> buses);
  ~Commissioning();
  Commissioning(const Commissioning&) = delete;
  Commissioning& operator=(const Commissioning&) = delete;

  /// Takes in what has arrived and sends what is due; never waits. Call it every millisecond or so, and when
  /// something has arrived, until done(). now: any monotonic clock, the same in every call.
  void poll(Nanoseconds now) noexcept;

  /// Every node is set up or has failed; at once where no node has a profile.
  bool done() const noexcept;
  /// A node has failed: the rig must not be started. errors() says why.
  bool failed() const noexcept;
  /// One line per failed node: device, bus, node, object, what happened, line of the profile.
  std::vector<std::string> errors() const;
  /// One line per node that is still at it, for a status line: device and what it waits for.
  std::vector<std::string> pending() const;

 private:
  std::vector<CanBus*> buses_;
  std::vector<std::unique_ptr<NodeCommissioning>> nodes_;
};

}  // namespace godobject
