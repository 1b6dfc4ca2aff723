// Preparation of real buses before the loop: other ends of pseudo-terminals, nodes that have a profile, and
// last frames for the death of the program.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"
#include "platform/linux/link.h"
#include "platform/rig/buses.h"
#include "platform/rt/signals.h"
#include "platform/scene/scene.h"

namespace godobject {

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

/// A bus that stores the frames sent to it.
class FrameNotebook final : public CanBus {
 public:
  bool open() noexcept override { return true; }
  void close() noexcept override {}
  SendResult try_send(const CanFrame& frame) noexcept override {
    frames_.push_back(frame);
    return SendResult::queued;
  }
  bool try_receive(ReceivedFrame&) noexcept override { return false; }
  BusState state() const noexcept override { return BusState::error_active; }
  BusCounters counters() const noexcept override { return {}; }

  const std::vector<CanFrame>& frames() const { return frames_; }

 private:
  std::vector<CanFrame> frames_;
};

/// Returns the frames that Rig::stop() would send on each bus, as bytes: drives off, nodes pre-operational.
/// Valid until a bus is closed.
std::vector<LastWords> last_words(const RigParams& params, double cycle_s, LinuxLink& link);

}  // namespace godobject
