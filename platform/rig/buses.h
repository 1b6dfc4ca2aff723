// Buses of a rig on this machine: addresses, opening, filters, transmit slots, and advice on their load.
// Preparation before the loop: other ends of pseudo-terminals, nodes that have a profile, and last frames for
// the death of the program.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "hal/can/filter.h"
#include "hal/canopen/canopen.h"
#include "hal/canopen/node_profile.h"
#include "hal/rig/bus_load.h"
#include "hal/rig/params.h"
#include "platform/linux/bus/bus.h"
#include "platform/linux/link.h"
#include "platform/rt/signals.h"
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

// Preparation.

/// Loads the profiles of the scene's rig (which must exist) from beside the scene file. Drives take their
/// modes and bits from them.
/// Reports an error if the device displays force and a drive would keep its torque when this program dies.
RigProfiles checked_profiles(SceneConfig& scene, const std::string& scene_file,
                             std::vector<std::string>& errors);

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

/// A bus that stores the frames sent to it, as many as the last words of a full bus.
class FrameNotebook final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    if (size_ == frames_.size()) return SendResult::full;
    frames_[size_++] = frame;
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame&) noexcept override { return false; }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  std::span<const CanFrame> frames() const noexcept { return std::span(frames_).first(size_); }

 private:
  std::vector<CanFrame> frames_ = std::vector<CanFrame>(8 * canopen::max_node_id);
  std::size_t size_ = 0;
};

/// Returns the frames that Rig::stop() would send on each bus, as bytes: drives off, nodes pre-operational.
/// Valid until a bus is closed.
std::vector<LastWords> last_words(const RigParams& params, double cycle_s, LinuxLink& link);

}  // namespace godobject
