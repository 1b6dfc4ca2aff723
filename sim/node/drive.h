// Simulated CiA 402 motor drive in the cyclic synchronous modes.
#pragma once

#include "hal/drive/cia402_homing.h"
#include "hal/rig/params.h"
#include "sim/node/canopen/node.h"
#include "sim/node/drive_objects.h"

namespace godobject {

/// Deviations of real drives from the standard; none by default.
struct SimDriveQuirks {
  // 603Fh of a fault raised in Operation Enabled, without EMCY; 0: none.
  std::uint16_t error_when_enabled = 0;
  Nanoseconds error_after_ns = 4'000'000;          // delay of that fault
  bool loses_power_only = false;                   // enters Switch On Disabled instead of Fault
  int controlword_every_nth_sync = 1;              // interval at which it reads the controlword, SYNCs
  Nanoseconds controlword_period_ns = 0;           // interval by its own timer instead; 0: with SYNC
  std::int16_t max_torque_per_mille = 0;           // 6072h; 0: as torque_max_Nm
  bool limit_clears_follow_bit = false;            // bit 12 is 0 while the torque is limited
  std::uint16_t status_clear = 0, status_set = 0;  // bits of the statusword that are always 0, or always 1
};

struct SimDriveParams {
  DriveParams drive{};
  SimDriveQuirks quirks{};
  // After power-up, with SimDefaults::rig:
  Nanoseconds rpdo_timeout_ns = 0;           // deadline of RPDO1, 1400h:05; whole ms; 0: none, as in CiA 301
  Nanoseconds event_period_ns = 20'000'000;  // event timer of TPDO2, 1801h:05; whole ms; 0: never sent
  Nanoseconds heartbeat_period_ns = 0;       // 0: never sent
  SimDefaults defaults = SimDefaults::rig;
  double torque_rated_unit_Nm = godobject::torque_rated_unit_Nm;  // unit of 6076h
};

/// At SYNC it handles synchronous PDOs as in CiA 301: samples and sends the status (every n-th SYNC) and
/// activates the RPDO1 received before. A command thus reaches the motor at the next SYNC, and the status
/// reports the torque of the cycle that ends there. Torque is applied in Operation Enabled only.
///
/// Without a configured watchdog the drive keeps its torque after the host is lost. Watchdogs: The drive
/// enters Fault with zero torque and sends EMCY 8250h if no RPDO1 arrives within its deadline (1400h:05,
/// unless 0) while the power stage is on. The deadline is checked at any time, not only at SYNC, and in NMT
/// operational only. If the heartbeat named in 1016h stops, 6007h selects the reaction. Leaving NMT
/// operational switches the power stage off. Quick stop removes the torque at once and ends in Switch On
/// Disabled, or in Quick Stop Active if 605Ah is 5 to 7.
///
/// CSV and CSP (6060h; RPDO3, RPDO2) control the motor by a soft spring and damper within torque_max_Nm.
/// Homing supports method 37 or 35 only: the present position becomes 607Ch. Any other method fails.
class SimDrive final : public SimCanopenNode, public SimMotor {
 public:
  SimDrive(CanBus& bus, const SimDriveParams& params);
  void set_quirks(const SimDriveQuirks& quirks) noexcept { params_.quirks = quirks; }

  void set_joint(double q, double q_dot) noexcept override {
    q_ = q;
    q_dot_ = q_dot;
  }
  double applied_torque_Nm() const noexcept override;

  cia402::DriveState drive_state() const noexcept { return state_; }
  std::uint16_t error_code() const noexcept { return error_code_; }
  /// Enters Fault without torque and sends an EMCY with this code (603Fh).
  void trip(std::uint16_t error_code) noexcept override;

 private:
  void sample() noexcept override;
  void on_rpdo_received(int number, Nanoseconds now) noexcept override;
  void on_rpdo(int number, Nanoseconds now) noexcept override;
  void on_reset() noexcept override;
  void on_heartbeat_lost(Nanoseconds now) noexcept override;
  sdo::AbortCode may_write_object(canopen::ObjectAddress address, std::int64_t value) noexcept override;
  void on_object_written(canopen::ObjectAddress address, std::int64_t value) noexcept override;
  void on_nmt_state(Nanoseconds now) noexcept override;
  void on_tick(Nanoseconds now) noexcept override;
  Nanoseconds device_timer() const noexcept override;

  void show(canopen::ObjectAddress address, std::int64_t value) noexcept;
  void take_command() noexcept;
  void note_enabling(Nanoseconds now) noexcept;
  void quick_stop() noexcept;
  void start_homing() noexcept;
  void begin_manoeuvre() noexcept;
  void finish_manoeuvre() noexcept;
  void finish_homing() noexcept;
  cia402::OperationMode mode() const noexcept;
  double servo_torque_Nm() const noexcept;
  std::int64_t position_counts() const noexcept;
  double velocity_counts_per_s() const noexcept;
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
  cia402::HomingState homing_ = cia402::HomingState::not_running;
  std::int64_t zero_counts_ = 0;   // offset added by homing
  bool manoeuvre_begins_ = false;  // a homing or a quick stop begins, timed from the next tick
  Nanoseconds t_manoeuvre_ends_ns_ = never;
  Nanoseconds t_received_ns_ = 0;
  int syncs_not_looked_ = 0;
  Nanoseconds t_look_ns_ = 0;       // next reading of the controlword by its own timer
  Nanoseconds t_error_ns_ = never;  // time at which error_when_enabled is raised
};

}  // namespace godobject
