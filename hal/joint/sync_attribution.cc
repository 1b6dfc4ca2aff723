#include "hal/joint/sync_attribution.h"

#include <algorithm>

namespace godobject {

SyncAttribution::SyncAttribution(const BusParams& bus) noexcept
    : rates_{.nominal = bus.bit_rate, .data = bus.data_bit_rate > 0 ? bus.data_bit_rate : bus.bit_rate},
      has_data_rate_(bus.data_bit_rate > 0),
      intermission_ns_(duration_ns(intermission_bits, rates_)) {}

void SyncAttribution::sync_queued(Nanoseconds now, const CanFrame& sync) noexcept {
  ++num_syncs_;
  sync_wire_time_ns_ = wire_time(sync);
  previous_end_ns_ = end_ns_;
  earliest_end_ns_ = now + sync_wire_time_ns_;
  end_ns_ = earliest_end_ns_;
}

SyncAttribution::Answer SyncAttribution::on_frame(const ReceivedFrame& received) noexcept {
  if ((received.frame.fd && !has_data_rate_) || num_syncs_ == 0) return {};
  const Nanoseconds start_ns = received.t_ns - wire_time(received.frame);
  if (start_ns >= earliest_end_ns_) return {.sync = num_syncs_, .t_ns = std::min(end_ns_, start_ns)};
  end_ns_ = std::max(end_ns_, received.t_ns + intermission_ns_ + sync_wire_time_ns_);
  return {.sync = num_syncs_ - 1, .t_ns = std::min(previous_end_ns_, start_ns)};
}

// Returns the time of a frame on the wire without intermission: receivers accept and stamp a frame at its
// end.
Nanoseconds SyncAttribution::wire_time(const CanFrame& frame) const noexcept {
  FrameBits bits = frame.fd ? nominal_bits(frame) : exact_bits(frame);
  bits.nominal_rate -= intermission_bits;
  return duration_ns(bits, rates_);
}

}  // namespace godobject
