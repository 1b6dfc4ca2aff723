// A simulated CiA 402 motor drive in cyclic synchronous torque mode.
#pragma once

#include "hal/cia402.h"
#include "hal/rig_params.h"
#include "sim/drive_objects.h"
#include "sim/sim_canopen_node.h"

namespace godobject {

struct SimDriveParams {
  DriveParams drive{};
  // After power-up, of SimDefaults::rig:
  Nanoseconds rpdo_timeout_ns = 20'000'000;  // deadline of RPDO1, 1400h:05; in whole ms, 0: none
  Nanoseconds event_period_ns = 20'000'000;  // event timer of TPDO2, 1801h:05; in whole ms, 0: never sent
  Nanoseconds heartbeat_period_ns = 0;       // 0: never sent
  SimDefaults defaults = SimDefaults::rig;
};

/// SYNC does what CiA 301 asks of synchronous PDOs: sample and send the status (every n-th SYNC), and put the
/// RPDO1 that arrived before it into effect. A command thus reaches the motor with the next SYNC, and the
/// status reports the torque of the cycle that ends there. Torque is applied in Operation Enabled only.
///
/// No RPDO1 for its deadline (1400h:05) while the power stage works: fault, no torque, EMCY 8250h; the watchdog
/// acts at its own time, not with a SYNC. When the heartbeat that 1016h names stops, 6007h says what happens.
/// Leaving the NMT state operational switches the power stage off. Quick stop removes the torque at once.
/// Of the modes (6060h) only CST makes torque.
class SimDrive final : public SimCanopenNode {
 public:
  SimDrive(CanBus& bus, const SimDriveParams& params);

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
  void trip(std::uint16_t error_code) noexcept;

 private:
  void sample() noexcept override;
  void on_rpdo_received(int number, Nanoseconds now) noexcept override;
  void on_rpdo(int number, Nanoseconds now) noexcept override;
  void on_heartbeat_lost(Nanoseconds now) noexcept override;
  sdo::AbortCode may_write_object(canopen::ObjectAddress address, std::int64_t value) noexcept override;
  void on_object_written(canopen::ObjectAddress address, std::int64_t value) noexcept override;
  void on_nmt_state(Nanoseconds now) noexcept override;
  void on_tick(Nanoseconds now) noexcept override;
  Nanoseconds device_timer() const noexcept override;

  void show(canopen::ObjectAddress address, std::int64_t value) noexcept;
  void take_command() noexcept;
  Nanoseconds command_deadline() const noexcept;
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
  cia402::Command active_;
  Nanoseconds t_received_ns_ = 0;
};

}  // namespace godobject
