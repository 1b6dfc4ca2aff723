// One motor drive: position, torque and state in, limited torque commands out. DriveLink implements its
// protocol.
#pragma once

#include "hal/drive/link.h"
#include "hal/joint/encoder.h"

namespace godobject {

/// Last feedback of a drive.
struct DriveFeedback {
  JointSample position;  // joint coordinate
  double velocity = 0;   // velocity of the joint, rad/s or m/s, measured by the drive; 0 until received
  double torque_Nm = 0;  // torque at the motor shaft
  MotorState state = MotorState::unknown;
  bool internal_limit = false;   // the drive itself limits
  std::uint32_t error_code = 0;  // drive-specific; 0: none
};

/// A command ready to be sent, and the limits that changed it.
struct DriveCommand {
  // without a frame, the next request carries the command, or nothing needs to be sent
  DriveFrame out;
  DriveOrder order;             // torque before the rounding of the protocol
  bool torque_limited = false;  // limited to torque_max_Nm
  bool rate_limited = false;    // limited by torque_rate_Nm_per_s
};

class Drive {
 public:
  /// params: constant and outliving the drive. Allocates; no other function does.
  Drive(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns);
  Drive(const DriveParams&&, double, Nanoseconds) = delete;  // a temporary would not outlive it

  /// Processes a frame of its node. t_ns: sampling time of its position, if any, ns. answered: the request of
  /// this answer was answered before; the state is used, the position is no second measurement.
  DriveMessage on_frame(const CanFrame& frame, Nanoseconds t_ns, bool answered = false) noexcept;

  DriveFeedback feedback(Nanoseconds now) const noexcept;
  /// True if the last position is older than the stale limit plus the SYNCs that the drive may skip.
  bool silent(Nanoseconds now) const noexcept;
  const Encoder& position() const noexcept { return position_; }
  Encoder& position() noexcept { return position_; }
  MotorState state() const noexcept { return telemetry_.state; }
  std::uint32_t error_code() const noexcept { return telemetry_.error_code; }
  const DriveTelemetry& telemetry() const noexcept { return telemetry_; }

  /// Returns the frame to send at the beginning of a cycle, if any. It carries the last order planned. Call
  /// request_sent() when it has been sent.
  std::optional<CanFrame> request() const noexcept { return link_->request(order_); }
  void request_sent() noexcept {
    if (!has_frame_) torque_Nm_ = order_.torque_Nm;
  }

  /// Plans a command: maps tau_joint through the transmission to the motor and saturates it at torque_max_Nm.
  /// Limits its change from the last sent command to the slew of one cycle. Returns zero torque for a drive
  /// that is not enabled or is to stop. tau_joint: at the joint, N m or N, finite.
  DriveCommand plan(double tau_joint, DriveGoal goal, Nanoseconds now) noexcept;
  /// Records that a planned command was sent or needs no frame; the slew limit of the next one starts from
  /// it.
  void sent(const DriveCommand& command, Nanoseconds now) noexcept;
  /// Returns the torque last sent, at the motor shaft, N m.
  double commanded_torque_Nm() const noexcept { return torque_Nm_; }

 private:
  const DriveParams& params_;
  double max_change_Nm_;  // per cycle
  Nanoseconds silent_after_ns_;
  std::unique_ptr<DriveLink> link_;
  Encoder position_;
  DriveTelemetry telemetry_;
  Nanoseconds position_t_ns_ = 0;
  bool has_position_ = false;
  DriveOrder order_{.goal = DriveGoal::hold};  // last one planned
  bool has_frame_ = false;                     // its torque has a frame of its own
  double torque_Nm_ = 0;
};

}  // namespace godobject
