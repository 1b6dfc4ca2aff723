// One motor drive as the rig sees it: position, torque and state in, limited torque commands out. What it
// speaks is DriveLink's.
#pragma once

#include "hal/drive/link.h"
#include "hal/joint/encoder.h"

namespace godobject {

/// What a drive last said.
struct DriveFeedback {
  JointSample position;  // as joint coordinate
  double velocity = 0;   // of the joint, rad/s or m/s, as the drive measures it; 0 until it says
  double torque_Nm = 0;  // at the motor shaft
  MotorState state = MotorState::unknown;
  bool internal_limit = false;   // the drive itself limits
  std::uint32_t error_code = 0;  // in the drive's own numbers; 0: none
};

/// A command ready to be sent, and which limit shaped it.
struct DriveCommand {
  DriveFrame out;               // no frame: the next request says it, or nothing is to be said
  DriveOrder order;             // the torque before the rounding of the protocol
  bool torque_limited = false;  // by torque_max_Nm
  bool rate_limited = false;    // by torque_rate_Nm_per_s
};

class Drive {
 public:
  /// Allocates; nothing later does.
  Drive(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns);

  /// A frame of its node. t_ns: when the position in it was measured, should it hold one. answered: the request that it
  /// answers has been answered before; its state counts, its position is no second measurement.
  DriveMessage on_frame(const CanFrame& frame, Nanoseconds t_ns, bool answered = false) noexcept;

  DriveFeedback feedback(Nanoseconds now) const noexcept;
  /// No position for longer than the stale limit plus the SYNCs it may leave out.
  bool silent(Nanoseconds now) const noexcept;
  const Encoder& position() const noexcept { return position_; }
  MotorState state() const noexcept { return telemetry_.state; }
  std::uint32_t error_code() const noexcept { return telemetry_.error_code; }
  const DriveTelemetry& telemetry() const noexcept { return telemetry_; }

  /// What to send at the beginning of a cycle, if anything; request_sent() when it has left.
  std::optional<CanFrame> request() const noexcept { return link_->request(order_); }
  void request_sent() noexcept { torque_Nm_ = order_.torque_Nm; }

  /// tau_joint (finite, N m or N, at the joint): through the transmission to the motor, saturated at
  /// torque_max_Nm, at most one cycle's slew away from the last command that was sent. A drive that is
  /// not enabled, or is to stop, is sent zero torque.
  DriveCommand plan(double tau_joint, DriveGoal goal, Nanoseconds now) const noexcept;
  /// Tells that a planned command has left, or has no frame of its own: the next one slews from it.
  void sent(const DriveCommand& command, Nanoseconds now) noexcept;
  /// At the motor shaft, as last sent.
  double commanded_torque_Nm() const noexcept { return torque_Nm_; }

 private:
  DriveParams params_;
  double max_change_Nm_;  // per cycle
  Nanoseconds silent_after_ns_;
  std::unique_ptr<DriveLink> link_;
  Encoder position_;
  DriveTelemetry telemetry_;
  Nanoseconds position_t_ns_ = 0;
  bool has_position_ = false;
  DriveOrder order_{.goal = DriveGoal::hold};  // the last one given
  double torque_Nm_ = 0;
};

}  // namespace godobject
