#include "sim/node/moteus.h"

#include <span>

namespace godobject {

namespace {

constexpr double default_watchdog_s = 0.1;

}  // namespace

SimMoteus::SimMoteus(CanBus& bus, const DriveParams& params, int fault_when_commanded) noexcept
    : bus_(bus), params_(params), fault_when_commanded_(fault_when_commanded) {
  power_cycle(0);
}

void SimMoteus::power_cycle(Nanoseconds) noexcept {
  values_.fill(0);
  values_[moteus::kp_scale] = values_[moteus::kd_scale] = 1;
  values_[moteus::watchdog_timeout] = default_watchdog_s;
}

void SimMoteus::poll(Nanoseconds now) noexcept {
  for (ReceivedFrame received; bus_.try_receive(received);) on_frame(received.frame, now);
  if (mode() == moteus::mode_position && now >= t_command_ns_ + watchdog_ns())
    values_[moteus::mode] = moteus::mode_timeout;
}

Nanoseconds SimMoteus::next_timer() const noexcept {
  return mode() == moteus::mode_position ? t_command_ns_ + watchdog_ns() : never;
}

Nanoseconds SimMoteus::watchdog_ns() const noexcept {
  return std::llround(1e9 * values_[moteus::watchdog_timeout] / clock_rate_);
}

void SimMoteus::trip(std::uint16_t error_code) noexcept {
  values_[moteus::mode] = moteus::mode_fault;
  values_[moteus::fault] = error_code;
}

double SimMoteus::applied_torque_Nm() const noexcept {
  const bool torque_only = values_[moteus::kp_scale] == 0 && values_[moteus::kd_scale] == 0;
  if (mode() != moteus::mode_position || !torque_only) return 0;
  return std::clamp(values_[moteus::feedforward_torque], -params_.torque_max_Nm, params_.torque_max_Nm);
}

void SimMoteus::on_frame(const CanFrame& frame, Nanoseconds now) noexcept {
  const bool wants_reply = (frame.id & 0x8000u) != 0;
  if (!frame.fd || (frame.id & 0xFFu) != node_id()) return;
  measure();
  moteus::SubframeWriter reply;
  moteus::SubframeReader reader(frame.bytes());
  for (moteus::Subframe s; reader.next(s);) {
    if (s.kind == moteus::SubframeKind::reply || s.first + s.count > num_registers) return;
    if (s.kind == moteus::SubframeKind::read) {
      reply.reply(s.type, static_cast<moteus::Register>(s.first),
                  std::span(values_).subspan(s.first, s.count));
    } else {
      for (std::uint32_t i = 0; i < s.count; ++i) write(s.first + i, s.value(i), now);
    }
  }
  if (wants_reply && !reply.full())
    static_cast<void>(bus_.try_send(reply.frame(moteus::reply_id(node_id()))));
}

void SimMoteus::write(std::uint32_t reg, double value, Nanoseconds now) noexcept {
  if (reg != moteus::mode) {
    const bool command = reg >= moteus::command_position && std::isfinite(value);
    if (command) values_[reg] = value;
    return;
  }
  const bool latched = mode() == moteus::mode_fault || mode() == moteus::mode_timeout;
  if (latched && value != moteus::mode_stopped) return;
  if (value == moteus::mode_stopped) values_[moteus::fault] = 0;
  if (value == moteus::mode_position) {
    t_command_ns_ = now;
    if (mode() != moteus::mode_position) ++times_enabled_;
    if (fault_when_commanded_ != 0) return trip(static_cast<std::uint16_t>(fault_when_commanded_));
  }
  values_[moteus::mode] = value;
}

void SimMoteus::measure() noexcept {
  const Calibration& c = params_.calibration;
  const double counts = c.sign * (q_ - c.home) * c.counts_per_unit + static_cast<double>(c.offset_counts);
  values_[moteus::position] = counts / counts_per_motor_turn;
  values_[moteus::velocity] = c.sign * q_dot_ * c.counts_per_unit / counts_per_motor_turn;
  values_[moteus::torque] = applied_torque_Nm();
}

}  // namespace godobject
