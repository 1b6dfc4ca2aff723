// What comes before the loop on real buses: their other ends, and nodes that have a profile.
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
  const RigProfiles& profiles;

  /// A pseudo-terminal, whose other end whoever plays the device opens.
  bool has_other_end(std::size_t bus) const { return where.addresses[bus].backend->makes_terminal; }
};

/// Waits for the other end of what has one (a pseudo-terminal), then sets up the nodes that have a profile. One
/// line for each that could not be; none where `stop` ended it.
std::vector<std::string> bring_up(const RigOnBuses& real, const std::atomic<bool>& stop);
/// Without the first.
std::vector<std::string> commission(const RigOnBuses& real, const std::atomic<bool>& stop);

/// What has arrived also says how a bus is. The frames were for a loop that has ended.
void drain(LinuxLink& link);
/// Waits that long, or for `stop`. False: stop.
bool pause(double s, const std::atomic<bool>& stop);

}  // namespace godobject
