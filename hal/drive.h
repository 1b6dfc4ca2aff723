// One motor drive as the rig sees it: position, torque and state in, limited torque commands out.
#pragma once

#include "hal/cia402.h"
#include "hal/encoder.h"
#include "hal/rig_params.h"

namespace godobject {

/// What a drive last said.
struct DriveFeedback {
  JointSample position;  // 6064h as joint coordinate
  double torque_Nm = 0;  // 6077h, at the motor shaft
  cia402::DriveState state = cia402::DriveState::unknown;
  bool internal_limit = false;  // the drive itself limits (statusword bit 11)
};

/// A command ready to be sent, and which limit shaped it.
struct DriveCommand {
  CanFrame frame;  // RPDO1
  std::uint16_t controlword = 0;
  double torque_Nm = 0;         // at the motor shaft, before the rounding to per mille
  bool torque_limited = false;  // by torque_max_Nm
  bool rate_limited = false;    // by torque_rate_Nm_per_s
};

class Drive {
 public:
  Drive(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns) noexcept;

  /// Its TPDO1, answering the SYNC at t_ns.
  [[nodiscard]] ParseResult on_status(const CanFrame& frame, Nanoseconds t_ns) noexcept;

  DriveFeedback feedback(Nanoseconds now) const noexcept;
  /// No status for longer than the stale limit plus the SYNCs it may leave out.
  bool silent(Nanoseconds now) const noexcept;
  const Encoder& position() const noexcept { return position_; }
  cia402::DriveState state() const noexcept { return state_; }

  /// The controlword that keeps an enabled drive enabled and leaves any other one off.
  std::uint16_t holding_controlword() const noexcept;
  /// The controlword that leads towards Operation Enabled, faults reset on the way.
  std::uint16_t enabling_controlword() const noexcept;

  /// tau_joint (finite, N m or N, at the joint): through the transmission to the motor, saturated at
  /// torque_max_Nm, at most one cycle's slew away from the last command that was sent. A drive that is
  /// not in Operation Enabled is sent zero torque.
  DriveCommand plan(double tau_joint, std::uint16_t controlword) const noexcept;
  /// Tells that a planned command has left: the next one slews from it.
  void sent(const DriveCommand& command) noexcept;
  /// At the motor shaft, as last sent.
  double commanded_torque_Nm() const noexcept { return torque_Nm_; }

 private:
  DriveParams params_;
  double max_change_Nm_;  // per cycle
  Nanoseconds silent_after_ns_;
  Encoder position_;
  cia402::Status status_;
  cia402::DriveState state_ = cia402::DriveState::unknown;
  Nanoseconds status_t_ns_ = 0;
  bool has_status_ = false;
  std::uint16_t controlword_ = cia402::disable_voltage;
  double torque_Nm_ = 0;
};

}  // namespace godobject
