// Buses of a rig on this machine: addresses, opening, filters, transmit slots, and advice on their load.
#pragma once

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/can/filter.h"
#include "hal/rig/bus_load.h"
#include "hal/rig/params.h"
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

/// Returns the filters of each bus of the rig. They pass all frames of the rig's own nodes and of the host.
/// The kernel or an adapter may drop all others before they wake the loop.
/// Frames of nodes: the predefined connection set (CiA 301 7.3.3: PDO, EMCY, SDO, heartbeat), and those of
/// drives with other protocols.
/// Frames of the host: NMT and SYNC among them, because a bus confirms a transmission by returning the frame.
std::vector<std::vector<CanFilter>> rig_filters(const RigParams& rig);

/// Worst-case loads with advice. No run starts above the last one.
inline constexpr double advised_load_percent = 50, planned_load_percent = 70, full_load_percent = 100;

/// Returns the advice on the worst-case load; empty up to advised_load_percent.
std::string load_advice(const BusLoad& load);
/// True if the load exceeds the capacity of the bus; no run may start on it.
constexpr bool is_overloaded(const BusLoad& load) noexcept { return load.worst_percent > full_load_percent; }

}  // namespace godobject
