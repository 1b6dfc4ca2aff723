// Devices from their first period to their last: booting, running, running down, closing. A session goes through it, and
// whoever has a step of his own.
#pragma once

#include <vector>

#include "platform/device/hand_device.h"

namespace godobject {

/// Time of the devices that booting may take; a rig's own boot_timeout_s is shorter, and says which node.
inline constexpr double usual_boot_limit_s = 10;
inline constexpr double shut_down_limit_s = 2;

/// What a period is for. A run goes through them in this order; a fault or stop() leaves some out.
enum class RunPhase : std::uint8_t {
  off,
  booting,       // the nodes come up, the hand of a simulated rig at rest
  running,       // motion and steps
  running_down,  // torque runs down to zero
  closing,       // drives disabled, nodes pre-operational: their frames leave
  ended,
};

class DevicePhases {
 public:
  /// step: s.
  explicit DevicePhases(double step) { period_.step = step; }

  /// One more device, which outlives this; devices go through each period in the order in which they are added. Allocates.
  void add(HandDevice& device) { devices_.push_back(&device); }
  std::span<HandDevice* const> devices() const noexcept { return devices_; }

  /// off -> booting, given up after `limit_s`, or the limit of the slowest device; where none boots -> running.
  void start(double limit_s) noexcept;
  /// One period that is no step. t: of the motion, s.
  void advance(double t) noexcept;
  /// One period that is a step: it begins.
  Period& begin(double t) noexcept;
  /// booting, running -> running_down; without a device that makes torque, or before start() -> ended.
  void stop() noexcept;
  /// stop() without running down.
  void quick_stop() noexcept;
  /// ended -> off: the devices know nothing of what was. Allocates.
  void restart();

  RunPhase phase() const noexcept { return phase_; }
  const Period& period() const noexcept { return period_; }
  Period& period() noexcept { return period_; }
  bool makes_torque() const noexcept;
  bool boots() const noexcept;

 private:
  void boot(Period& period) noexcept;
  bool arm() noexcept;
  void run_down(Period& period) noexcept;
  void close(Period& period) noexcept;
  void give_up_running() noexcept;
  std::int64_t periods(double time_s) const noexcept;

  std::vector<HandDevice*> devices_;
  Period period_;
  RunPhase phase_ = RunPhase::off;
  std::int64_t periods_left_ = 0;  // of this phase at most
};

}  // namespace godobject
