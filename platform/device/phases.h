// Phases of devices from the first to the last period: booting, running, running down, closing. Used by
// Session and by programs with a step of their own.
#pragma once

#include <vector>

#include "platform/device/hand_device.h"

namespace godobject {

/// Limit for booting, s. A rig's own boot_timeout_s is shorter and reports the missing node.
inline constexpr double usual_boot_limit_s = 10;
inline constexpr double shut_down_limit_s = 2;

/// Purpose of a period. A run passes through these in order; a fault or stop() skips some.
enum class RunPhase : std::uint8_t {
  off,
  booting,       // nodes boot; the hand of a simulated rig is at rest
  running,       // motion and steps
  running_down,  // torque runs down to zero
  closing,       // drives disabled, nodes pre-operational; their frames are sent
  ended,
};

class DevicePhases {
 public:
  /// step: period, s.
  explicit DevicePhases(double step) { period_.step = step; }

  /// Adds a device, which must outlive this object. Devices run each period in the order of adding.
  /// Allocates.
  void add(HandDevice& device) { devices_.push_back(&device); }
  std::span<HandDevice* const> devices() const noexcept { return devices_; }

  /// Enters booting from off, or running if no device boots.
  /// limit_s: time after which booting fails, s; the slowest device may prolong it.
  void start(double limit_s) noexcept;
  /// Runs one period that is no step. t: time of the motion, s.
  void advance(double t) noexcept;
  /// Starts a period that is a step. t: time of the motion, s.
  Period& begin(double t) noexcept;
  /// Enters running_down from booting or running. Enters ended if no device makes torque, or before start().
  void stop() noexcept;
  /// stop() without running down.
  void quick_stop() noexcept;
  /// Enters off from ended; the devices discard their state. Allocates.
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
  std::int64_t periods_left_ = 0;  // maximum for the present phase
};

}  // namespace godobject
