// Preparation of real buses before the loop: other ends of pseudo-terminals, and nodes that have a profile.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "platform/rig/buses.h"

namespace godobject {

/// A rig on this machine's buses.
struct RigOnBuses {
  LinuxLink& link;
  const RigAddresses& where;
  const RigParams& rig;
  double cycle_s;  // SYNC period, s
  const RigProfiles& profiles;

  /// True for a pseudo-terminal. The program that simulates the device opens its other end.
  bool has_other_end(std::size_t bus) const { return where.addresses[bus].backend->makes_terminal; }
};

/// Waits for the other ends of pseudo-terminals, then sets up the nodes that have a profile. Returns one line
/// for each failed node; none if `stop` ended it.
std::vector<std::string> bring_up(const RigOnBuses& real, const std::atomic<bool>& stop);
/// As bring_up(), without the wait for other ends.
std::vector<std::string> commission(const RigOnBuses& real, const std::atomic<bool>& stop);

/// Reads and discards the received frames, which updates the state of each bus. They were sent to a loop that
/// has ended.
void drain(LinuxLink& link);
/// Waits for s seconds or until `stop`. Returns false at `stop`.
bool pause(double s, const std::atomic<bool>& stop);

}  // namespace godobject
