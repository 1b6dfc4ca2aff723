// A simulated CiA 402 motor drive in cyclic synchronous torque mode.
#pragma once

#include "hal/cia402.h"
#include "hal/rig_params.h"
#include "sim/sim_canopen_node.h"

namespace godobject {

struct SimDriveParams {
  DriveParams drive{};
  Nanoseconds rpdo_timeout_ns = 20'000'000;  // consumer watchdog, > 0
  Nanoseconds event_period_ns = 20'000'000;  // event timer of TPDO2; 0: never sent
  Nanoseconds heartbeat_period_ns = 0;       // 0: never sent
};

/// SYNC does what CiA 301 asks of synchronous PDOs: sample and send the status (every n-th SYNC), and put the
/// RPDO1 that arrived before it into effect. A command thus reaches the motor with the next SYNC, and the
/// status reports the torque of the cycle that ends there. Torque is applied in Operation Enabled only.
///
/// No RPDO1 for rpdo_timeout while the power stage works: fault, no torque, EMCY 8250h; the watchdog acts at
/// its own time, not with a SYNC. Leaving the NMT state operational switches the power stage off. Quick stop
/// removes the torque at once. Modes other than CST, and SDO, are not simulated.
class SimDrive final : public SimCanopenNode {
 public:
  SimDrive(CanBus& bus, const SimDriveParams& params) noexcept;

  /// True joint coordinate (rad or m) and its rate, from the plant.
  void set_joint(double q, double q_dot) noexcept {
    q_ = q;
    q_dot_ = q_dot;
  }
  /// Torque at the motor shaft in the motor's own sense; sign and transmission are the plant's business.
  double applied_torque_Nm() const noexcept;

  cia402::DriveState drive_state() const noexcept { return state_; }
  std::uint16_t error_code() const noexcept { return error_code_; }
  /// Fault, no torque, and an EMCY with this code (603Fh).
  void trip(std::uint16_t error_code) noexcept override;

 private:
  void on_sync(Nanoseconds now) noexcept override;
  void on_pdo(const CanFrame& frame, Nanoseconds now) noexcept override;
  void on_nmt_state(Nanoseconds now) noexcept override;
  void on_tick(Nanoseconds now) noexcept override;
  Nanoseconds device_timer() const noexcept override;

  void send_status() noexcept;
  void send_event() noexcept;
  void obey(std::uint16_t controlword) noexcept;
  void reset_fault() noexcept;
  void send_emergency() noexcept;
  std::uint16_t statusword() const noexcept;
  bool power_stage_works() const noexcept;
  double max_per_mille() const noexcept;

  SimDriveParams params_;
  double q_ = 0;
  double q_dot_ = 0;

  cia402::DriveState state_ = cia402::DriveState::not_ready_to_switch_on;
  std::uint16_t error_code_ = canopen::emcy_no_error;
  cia402::Command received_;  // waits for the next SYNC
  bool has_received_ = false;
  cia402::Command active_;
  Nanoseconds t_received_ns_ = 0;
  Nanoseconds t_event_ns_ = never;
  int syncs_since_status_ = 0;
};

}  // namespace godobject
