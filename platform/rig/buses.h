// The buses of a rig on this machine: which address each has, opened, filtered, and how promptly they are served.
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
  std::vector<std::string> texts;     // the same as given

  /// True if the frames of every bus are in a log.
  bool are_logs() const {
    return !addresses.empty() &&
           std::ranges::all_of(addresses, [](const BusAddress& bus) { return bus.backend->is_file; });
  }
};

/// An address where the scene has one bus, NAME=ADDRESS for each where it has several; `pty` alone stands for
/// one of each, `replay:FILE` alone for a log that has all. Logs do not go with other buses: those keep time
/// of their own.
/// option: of the command line that gives them, "--bus"; empty: arguments.
RigAddresses rig_addresses(std::span<const std::string> given, const SceneConfig& scene,
                           const std::string& option, std::vector<std::string>& errors);

/// The buses, closed. step: s. everything: also the frames that the rig does not listen to.
std::unique_ptr<LinuxLink> make_link(const RigAddresses& where, const RigParams& rig, double step,
                                     bool everything);

/// Opens all that are closed. One line for each that does not open: bus, address, why, what to do.
std::vector<std::string> open_buses(LinuxLink& link, const RigAddresses& where, const RigParams& rig);

/// One line for each bus with something to say about it, as open_buses.
std::vector<std::string> bus_troubles(LinuxLink& link, const RigAddresses& where, const RigParams& rig);

}  // namespace godobject
