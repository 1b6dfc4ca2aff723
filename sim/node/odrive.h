// Simulated ODrive: CAN Simple, in torque control.
#pragma once

#include "hal/drive/odrive.h"
#include "sim/node/node.h"

namespace godobject {

/// Deviations of real drives; none by default.
struct SimOdriveQuirks {
  std::uint32_t error_in_closed_loop = 0;  // error raised on the request for closed loop; 0: none
  bool firmware_0_5 = false;               // flags instead of the procedure result in the heartbeat
  // motor error of firmware 0.5, whose axis error stays 0; not 0 until Clear_Errors
  std::uint8_t motor_error = 0;
};

/// Sends heartbeat and torques cyclically, and the encoder estimates on a remote frame. Its own watchdog
/// (DriveWatchdog::drive) is off in factory settings. If it is on, missing Input_Torque in closed loop leads
/// to idle with the watchdog error, which Clear_Errors resets.
class SimOdrive final : public SimNode, public SimMotor {
 public:
  /// bus: opened by the caller, outlives this.
  SimOdrive(CanBus& bus, const DriveParams& params, const SimOdriveQuirks& quirks = {}) noexcept
      : bus_(bus), params_(params), quirks_(quirks) {
    power_cycle(0);
  }

  void poll(Nanoseconds now) noexcept override;
  Nanoseconds next_timer() const noexcept override;
  std::uint8_t node_id() const noexcept override { return params_.node_id; }
  void power_cycle(Nanoseconds now) noexcept override;
  void trip(std::uint16_t error_code) noexcept override { fail(error_code); }
  void set_clock_error(double ppm, Nanoseconds now) noexcept override;

  void set_joint(double q, double q_dot) noexcept override {
    q_ = q;
    q_dot_ = q_dot;
  }
  double applied_torque_Nm() const noexcept override;

  std::uint32_t axis_state() const noexcept { return axis_state_; }
  std::uint32_t error() const noexcept { return error_; }
  /// Returns how often it entered closed loop.
  int times_enabled() const noexcept { return times_enabled_; }

 private:
  void on_frame(const CanFrame& frame, Nanoseconds now) noexcept;
  void fail(std::uint32_t error) noexcept;
  void send(const CanFrame& frame) noexcept { static_cast<void>(bus_.try_send(frame)); }
  void send_estimates() noexcept;
  bool closed_loop() const noexcept { return axis_state_ == odrive::axis_closed_loop; }
  Nanoseconds watchdog_deadline() const noexcept;
  /// Returns a period of its own clock in bus time.
  Nanoseconds period_ns(double period_s) const noexcept;

  CanBus& bus_;
  DriveParams params_;
  SimOdriveQuirks quirks_;
  std::uint8_t motor_error_ = 0;
  int times_enabled_ = 0;
  double q_ = 0, q_dot_ = 0;
  std::uint32_t axis_state_ = odrive::axis_idle;
  std::uint32_t error_ = 0;
  bool torque_mode_ = false;  // factory setting: position control
  float torque_Nm_ = 0;
  double clock_rate_ = 1;
  Nanoseconds t_heartbeat_ns_ = 0, t_torques_ns_ = 0, t_fed_ns_ = 0;
};

}  // namespace godobject
