#include "hal/board/nodes.h"

#include <cmath>

#include "hal/can/timing.h"
#include "hal/canopen/cia406.h"

namespace godobject {
namespace {

std::uint8_t node_of(std::size_t channel) noexcept { return static_cast<std::uint8_t>(channel + 1); }

}  // namespace

// A rig attributes an answer that begins before its SYNC ends to the previous SYNC
// (hal/joint/sync_attribution.h). Answers are therefore delayed by the longest duration of a position frame.
BoardNodes::BoardNodes(double bit_rate) noexcept
    : sync_ns_(duration_ns(exact_bits(canopen::make_sync()), {.nominal = bit_rate, .data = bit_rate})),
      answer_ns_(
          duration_ns(worst_bits(cia406::make_position(1, 0)), {.nominal = bit_rate, .data = bit_rate})) {}

// Decodes byte by byte, because the last two frames are needed even if several arrive at once.
void BoardNodes::receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept {
  for (const std::uint8_t& byte : bytes) {
    const EncoderFrame before = board_.frame();
    const BoardCounters counters = board_.counters();
    if (board_.receive({&byte, 1}, now))
      take(before, counters.frames == 0 || board_.counters().reboots > counters.reboots, now);
  }
}

void BoardNodes::take(const EncoderFrame& before, bool restarted, Nanoseconds now) noexcept {
  const EncoderFrame& frame = board_.frame();
  t_arrival_ = now;
  counts_per_ns_.fill(0);
  if (restarted || frame.num_counts != num_nodes_) {
    num_nodes_ = frame.num_counts;
    return boot(now);
  }
  const auto elapsed_us = static_cast<std::int32_t>(frame.t_us - before.t_us);
  if (elapsed_us <= 0) return;
  for (std::size_t i = 0; i < num_nodes_; ++i) {
    const std::uint32_t travel =
        static_cast<std::uint32_t>(frame.counts[i]) - static_cast<std::uint32_t>(before.counts[i]);
    counts_per_ns_[i] = static_cast<std::int32_t>(travel) / (1e3 * elapsed_us);
  }
}

void BoardNodes::boot(Nanoseconds now) noexcept {
  for (std::size_t i = 0; i < num_nodes_; ++i) {
    put(canopen::make_heartbeat(node_of(i), canopen::NmtState::boot_up), now);
    states_[i] = canopen::NmtState::pre_operational;
  }
}

void BoardNodes::send(const CanFrame& frame, Nanoseconds now) noexcept {
  if (silent(now)) return;
  canopen::Nmt nmt;
  std::uint8_t counter = 0;
  if (canopen::parse_sync(frame, counter) == ParseResult::ok) answer_sync(now);
  else if (canopen::parse_nmt(frame, nmt) == ParseResult::ok) obey(nmt, now);
}

void BoardNodes::obey(const canopen::Nmt& nmt, Nanoseconds now) noexcept {
  for (std::size_t i = 0; i < num_nodes_; ++i) {
    if (nmt.node != 0 && nmt.node != node_of(i)) continue;
    switch (nmt.command) {
      case canopen::NmtCommand::start: states_[i] = canopen::NmtState::operational; break;
      case canopen::NmtCommand::stop: states_[i] = canopen::NmtState::stopped; break;
      case canopen::NmtCommand::reset_node:
      case canopen::NmtCommand::reset_communication:
        put(canopen::make_heartbeat(node_of(i), canopen::NmtState::boot_up), now);
        [[fallthrough]];
      case canopen::NmtCommand::enter_pre_operational: states_[i] = canopen::NmtState::pre_operational; break;
    }
    t_heartbeat_ = 0;  // sends the new state at once
  }
}

void BoardNodes::answer_sync(Nanoseconds now) noexcept {
  const Nanoseconds t_sample = now + sync_ns_;
  for (std::size_t i = 0; i < num_nodes_; ++i)
    if (states_[i] == canopen::NmtState::operational)
      put(cia406::make_position(node_of(i), counts_at(i, t_sample)), t_sample + answer_ns_);
}

std::uint32_t BoardNodes::counts_at(std::size_t channel, Nanoseconds t) const noexcept {
  const Nanoseconds age = std::clamp<Nanoseconds>(t - board_.t_ns(), 0, silent_after);
  const double travel = counts_per_ns_[channel] * static_cast<double>(age);
  return static_cast<std::uint32_t>(board_.frame().counts[channel]) +
         static_cast<std::uint32_t>(std::llround(travel));
}

void BoardNodes::put(const CanFrame& frame, Nanoseconds t) noexcept {
  t_last_ = std::max(t_last_, t);
  if (!to_host_.push({.frame = frame, .t_ns = t_last_})) ++num_lost_;
}

bool BoardNodes::try_receive(ReceivedFrame& out, Nanoseconds now) noexcept {
  if (!silent(now) && now - t_heartbeat_ >= heartbeat_period) {
    t_heartbeat_ = now;
    for (std::size_t i = 0; i < num_nodes_; ++i) put(canopen::make_heartbeat(node_of(i), states_[i]), now);
  }
  if (to_host_.empty() || to_host_.front().t_ns > now) return false;
  out = to_host_.front();
  to_host_.pop();
  return true;
}

std::optional<Nanoseconds> BoardNodes::next_due() const noexcept {
  if (to_host_.empty()) return std::nullopt;
  return to_host_.front().t_ns;
}

}  // namespace godobject
