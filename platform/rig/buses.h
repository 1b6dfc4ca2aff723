// Buses of a rig on this machine: addresses, opening, filters, and transmit slots.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "platform/linux/bus/bus.h"
#include "platform/linux/link.h"
#include "platform/scene/scene.h"

namespace godobject {

struct RigAddresses {
  std::vector<BusAddress> addresses;  // one per bus of the scene, in its order
  std::vector<std::string> texts;     // the same as text, as given

  /// True if the frames of every bus are in a log.
  bool are_logs() const {
    return !addresses.empty() &&
           std::ranges::all_of(addresses, [](const BusAddress& bus) { return bus.backend->is_file; });
  }
};

/// Assigns the given addresses to the buses of the scene. A bus is given as NAME=ADDRESS, or as ADDRESS if
/// the scene has one bus.
/// `pty` alone stands for one pseudo-terminal per bus, `replay:FILE` alone for a log of all buses. Logs and
/// other buses do not mix, because those have clocks of their own.
/// option: name of the command line option, such as "--bus", for messages; empty for arguments.
RigAddresses rig_addresses(std::span<const std::string> given, const SceneConfig& scene,
                           const std::string& option, std::vector<std::string>& errors);

/// Makes the buses, closed. step: period, s. everything: true to receive all frames, not only those of the
/// rig.
std::unique_ptr<LinuxLink> make_link(const RigAddresses& where, const RigParams& rig, double step,
                                     bool everything);

/// Opens all closed buses. Returns one line for each that fails: bus, address, reason, remedy.
std::vector<std::string> open_buses(LinuxLink& link, const RigAddresses& where, const RigParams& rig);

/// Returns one line for each bus with a problem, in the form of open_buses().
std::vector<std::string> bus_troubles(LinuxLink& link, const RigAddresses& where, const RigParams& rig);

}  // namespace godobject
