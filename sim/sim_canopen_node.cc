#include "sim/sim_canopen_node.h"

#include <algorithm>
#include <cmath>

namespace godobject {

using canopen::NmtCommand;
using canopen::NmtState;

void SimCanopenNode::poll(Nanoseconds now) noexcept {
  const Nanoseconds local_ns = local_time(now);
  for (ReceivedFrame received; bus_.try_receive(received);) on_frame(received.frame, local_ns);
  tick(local_ns);
}

void SimCanopenNode::set_clock_error(double ppm, Nanoseconds now) noexcept {
  local_origin_ns_ = local_time(now);
  origin_ns_ = now;
  clock_rate_ = 1 + 1e-6 * ppm;
}

Nanoseconds SimCanopenNode::local_time(Nanoseconds now) const noexcept {
  return local_origin_ns_ + std::llround(clock_rate_ * static_cast<double>(now - origin_ns_));
}

// Never too early: at this time local_time() has reached `local`.
Nanoseconds SimCanopenNode::bus_time(Nanoseconds local) const noexcept {
  if (local == never) return never;
  const double elapsed_ns = static_cast<double>(local - local_origin_ns_) / clock_rate_;
  return origin_ns_ + static_cast<Nanoseconds>(std::ceil(elapsed_ns)) + (clock_rate_ == 1 ? 0 : 1);
}

void SimCanopenNode::on_frame(const CanFrame& frame, Nanoseconds now) noexcept {
  if (nmt_state_ == NmtState::boot_up) return;
  canopen::Nmt nmt;
  if (canopen::parse_nmt(frame, nmt) == ParseResult::ok) {
    if (nmt.node == 0 || nmt.node == node_id_) on_nmt(nmt.command, now);
    return;
  }
  if (!is_operational()) return;
  std::uint8_t counter = 0;
  if (canopen::parse_sync(frame, counter) == ParseResult::ok) on_sync(now);
  else on_pdo(frame, now);
}

void SimCanopenNode::tick(Nanoseconds now) noexcept {
  if (nmt_state_ == NmtState::boot_up) boot(now);
  while (t_heartbeat_ns_ <= now) {
    send(canopen::make_heartbeat(node_id_, nmt_state_));
    t_heartbeat_ns_ += heartbeat_period_ns_;
  }
  on_tick(now);
}

Nanoseconds SimCanopenNode::next_timer() const noexcept {
  return bus_time(std::min(t_heartbeat_ns_, device_timer()));
}

void SimCanopenNode::on_nmt(NmtCommand command, Nanoseconds now) noexcept {
  switch (command) {
    case NmtCommand::start: enter(NmtState::operational, now); break;
    case NmtCommand::stop: enter(NmtState::stopped, now); break;
    case NmtCommand::enter_pre_operational: enter(NmtState::pre_operational, now); break;
    case NmtCommand::reset_node:
    case NmtCommand::reset_communication:
      t_heartbeat_ns_ = never;
      enter(NmtState::boot_up, now);
      break;
  }
}

void SimCanopenNode::enter(NmtState state, Nanoseconds now) noexcept {
  if (state == nmt_state_) return;
  nmt_state_ = state;
  on_nmt_state(now);
}

void SimCanopenNode::boot(Nanoseconds now) noexcept {
  if (bus_.try_send(canopen::make_heartbeat(node_id_, NmtState::boot_up)) != SendResult::queued) return;
  if (heartbeat_period_ns_ > 0) t_heartbeat_ns_ = now + heartbeat_period_ns_;
  enter(NmtState::pre_operational, now);
}

void advance(SimCanWire& wire, std::span<SimCanopenNode* const> nodes, Nanoseconds t_ns) noexcept {
  for (;;) {
    for (SimCanopenNode* node : nodes) node->poll(wire.now());
    Nanoseconds t_next_ns = wire.next_event().value_or(SimCanopenNode::never);
    for (const SimCanopenNode* node : nodes) t_next_ns = std::min(t_next_ns, node->next_timer());
    if (t_next_ns > t_ns) break;
    wire.advance_to(t_next_ns);
  }
  wire.advance_to(t_ns);
}

}  // namespace godobject
