#include "hal/joint/sync_attribution.h"

#include <algorithm>

namespace godobject {

SyncAttribution::SyncAttribution(const BusParams& bus, std::uint64_t reach)
    : rates_{.nominal = bus.bit_rate, .data = bus.data_bit_rate > 0 ? bus.data_bit_rate : bus.bit_rate},
      has_data_rate_(bus.data_bit_rate > 0),
      intermission_ns_(duration_ns(intermission_bits, rates_)),
      syncs_(reach + 1) {}

void SyncAttribution::sync_queued(Nanoseconds now, const CanFrame& sync) noexcept {
  ++num_syncs_;
  sync_wire_time_ns_ = wire_time(sync);
  const Nanoseconds end_ns = now + sync_wire_time_ns_;
  at(num_syncs_) = {.earliest_end_ns = end_ns, .end_ns = end_ns};
}

void SyncAttribution::sync_left_out(Nanoseconds now) noexcept {
  if (num_syncs_ == 0) return;
  const Nanoseconds end_ns = at(num_syncs_).end_ns;
  ++num_syncs_;
  at(num_syncs_) = {.earliest_end_ns = now + sync_wire_time_ns_, .end_ns = end_ns, .left_out = true};
}

SyncAttribution::Answer SyncAttribution::on_frame(const ReceivedFrame& received) noexcept {
  if ((received.frame.fd && !has_data_rate_) || num_syncs_ == 0) return {};
  const Nanoseconds start_ns = received.t_ns - wire_time(received.frame);
  std::uint64_t sync = num_syncs_;
  while (sync >= oldest() && start_ns < at(sync).earliest_end_ns) --sync;
  if (Sync& last = at(num_syncs_); sync < num_syncs_ && !last.left_out)
    last.end_ns = std::max(last.end_ns, received.t_ns + intermission_ns_ + sync_wire_time_ns_);
  return {.sync = sync, .t_ns = sync < oldest() ? start_ns : std::min(end_of(sync), start_ns)};
}

Nanoseconds SyncAttribution::end_of(std::uint64_t sync) const noexcept {
  return at(std::clamp(sync, oldest(), num_syncs_)).end_ns;
}

// Returns the time of a frame on the wire without intermission: receivers accept and stamp a frame at its
// end.
Nanoseconds SyncAttribution::wire_time(const CanFrame& frame) const noexcept {
  FrameBits bits = frame.fd ? nominal_bits(frame) : exact_bits(frame);
  bits.nominal_rate -= intermission_bits;
  return duration_ns(bits, rates_);
}

}  // namespace godobject
