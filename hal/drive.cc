#include "hal/drive.h"

#include <algorithm>
#include <cmath>

namespace godobject {

namespace {

// A drive that answers every n-th SYNC is n - 1 cycles older than one that answers all.
Nanoseconds silent_after(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns) noexcept {
  return stale_after_ns + std::llround(1e9 * cycle_s * (params.status_every_nth_sync - 1));
}

}  // namespace

Drive::Drive(const DriveParams& params, double cycle_s, Nanoseconds stale_after_ns) noexcept
    : params_(params),
      max_change_Nm_(params.torque_rate_Nm_per_s * cycle_s),
      silent_after_ns_(silent_after(params, cycle_s, stale_after_ns)),
      position_(params.calibration, params.max_speed, silent_after_ns_) {}

ParseResult Drive::on_status(const CanFrame& frame, Nanoseconds t_ns) noexcept {
  const ParseResult result = cia402::parse_status(frame, params_.node_id, status_);
  if (result != ParseResult::ok) return result;
  state_ = cia402::decode_state(status_.statusword);
  status_t_ns_ = t_ns;
  has_status_ = true;
  position_.update(static_cast<std::uint32_t>(status_.position_counts), t_ns);
  return result;
}

DriveFeedback Drive::feedback(Nanoseconds now) const noexcept {
  DriveFeedback out;
  out.position = position_.sample(now);
  out.torque_Nm = cia402::torque_from_per_mille(status_.actual_torque_per_mille, params_.torque_rated_Nm);
  out.state = state_;
  out.internal_limit = (status_.statusword & cia402::status_internal_limit) != 0;
  return out;
}

bool Drive::silent(Nanoseconds now) const noexcept {
  return !has_status_ || now - status_t_ns_ > silent_after_ns_;
}

std::uint16_t Drive::holding_controlword() const noexcept {
  return state_ == cia402::DriveState::operation_enabled ? cia402::enable_operation : cia402::disable_voltage;
}

std::uint16_t Drive::enabling_controlword() const noexcept {
  return cia402::next_controlword(state_, controlword_, true);
}

DriveCommand Drive::plan(double tau_joint, std::uint16_t controlword) const noexcept {
  // power is kept: tau_motor w_motor = tau_joint q_dot
  const bool enabled = state_ == cia402::DriveState::operation_enabled;
  const double wanted = enabled ? params_.sign * params_.joint_per_motor_rad * tau_joint : 0;
  const double last_Nm = enabled ? torque_Nm_ : 0;
  const double saturated = std::clamp(wanted, -params_.torque_max_Nm, params_.torque_max_Nm);
  DriveCommand out;
  out.controlword = controlword;
  out.torque_Nm = std::clamp(saturated, last_Nm - max_change_Nm_, last_Nm + max_change_Nm_);
  out.torque_limited = saturated != wanted;
  out.rate_limited = out.torque_Nm != saturated;
  const std::int16_t per_mille =
      cia402::torque_to_per_mille(out.torque_Nm, params_.torque_rated_Nm, params_.torque_max_Nm);
  out.frame = cia402::make_command(params_.node_id, {controlword, per_mille});
  return out;
}

void Drive::sent(const DriveCommand& command) noexcept {
  controlword_ = command.controlword;
  torque_Nm_ = command.torque_Nm;
}

}  // namespace godobject
