#include "hal/drive/drive.h"

#include <algorithm>
#include <cmath>

namespace godobject {

namespace {

// Returns the age above which a drive is silent. A drive that answers every n-th SYNC may be n - 1 cycles
// older.
Nanoseconds silent_after(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns) noexcept {
  return stale_after_ns + std::llround(1e9 * cycle_s * (params.status_every_nth_sync - 1));
}

}  // namespace

Drive::Drive(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns)
    : params_(params),
      max_change_Nm_(params.torque_rate_Nm_per_s * cycle_s),
      silent_after_ns_(silent_after(params, cycle_s, stale_after_ns)),
      link_(make_drive_link(params, cycle_s)),
      position_(params.calibration, params.max_speed, silent_after_ns_) {}

DriveMessage Drive::on_frame(const CanFrame& frame, Nanoseconds t_ns, bool answered) noexcept {
  const DriveMessage message = link_->decode(frame, telemetry_);
  if (message.result != ParseResult::ok || !message.position || answered) return message;
  position_t_ns_ = t_ns;
  has_position_ = true;
  position_.update(telemetry_.position_counts, t_ns);
  return message;
}

DriveFeedback Drive::feedback(Nanoseconds now) const noexcept {
  const Calibration& calibration = params_.calibration;
  return {.position = position_.sample(now),
          .velocity = calibration.sign * telemetry_.velocity_counts_per_s / calibration.counts_per_unit,
          .torque_Nm = telemetry_.torque_Nm,
          .state = telemetry_.state,
          .internal_limit = telemetry_.internal_limit,
          .error_code = telemetry_.error_code};
}

bool Drive::silent(Nanoseconds now) const noexcept {
  return !has_position_ || now - position_t_ns_ > silent_after_ns_;
}

DriveCommand Drive::plan(double tau_joint, DriveGoal goal, Nanoseconds now) noexcept {
  // Conservation of power: tau_motor w_motor = tau_joint q_dot.
  const bool may_move = goal == DriveGoal::hold || goal == DriveGoal::enable;
  const bool enabled = may_move && telemetry_.state == MotorState::enabled;
  const double wanted = enabled ? params_.sign * params_.joint_per_motor_rad * tau_joint : 0;
  const double last_Nm = enabled ? torque_Nm_ : 0;
  const double saturated = std::clamp(wanted, -params_.torque_max_Nm, params_.torque_max_Nm);
  DriveCommand command;
  command.order = {.goal = goal,
                   .torque_Nm = std::clamp(saturated, last_Nm - max_change_Nm_, last_Nm + max_change_Nm_)};
  command.torque_limited = saturated != wanted;
  command.rate_limited = command.order.torque_Nm != saturated;
  command.out = link_->command(command.order, now);
  order_ = command.order;  // the next request carries it, also after a refused frame
  has_frame_ = command.out.frame.has_value();
  return command;
}

void Drive::sent(const DriveCommand& command, Nanoseconds now) noexcept {
  if (command.out.frame) torque_Nm_ = command.order.torque_Nm;  // otherwise request_sent() records it
  link_->sent(command.out, now);
}

}  // namespace godobject
