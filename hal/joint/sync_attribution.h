// Which SYNC a received frame answers, and when the nodes took the sample in it. One object per bus.
#pragma once

#include "hal/can/timing.h"
#include "hal/canopen/canopen.h"
#include "hal/rig/params.h"

namespace godobject {

/// Where there is no SYNC the first request of a cycle stands for it; its answers are taken for measured when it
/// ended, or when they began, should that be earlier.
///
/// From the times at which SYNCs were queued and the receive stamps alone: there is no transmit confirmation.
///
/// The nodes sample when SYNC ends on the wire. That is no earlier than its queue time plus its duration, so
/// a frame that began before then cannot answer it: it answers the SYNC before. Such a frame also held the
/// wire: SYNC came after it, by up to the longest frame, 135 us at 1 Mbit/s. Any other frame is taken for an
/// answer to the SYNC queued last.
///
/// Stamps that are late (taken by software) move both estimates later, never past the beginning of the
/// answer; a true answer is never booked to the SYNC before. What stamps cannot tell: that SYNC waited for a
/// frame of the host's own, or behind such frames in a controller that keeps the order of its queue. Answers
/// to the SYNC before that begin in that time are booked to the new one.
class SyncAttribution {
 public:
  struct Answer {
    std::uint64_t sync = 0;  // counted from 1; 0: none was queued before the frame began
    Nanoseconds t_ns = 0;    // end of that SYNC on the wire: when the sample was taken
  };

  explicit SyncAttribution(const BusParams& bus) noexcept;

  /// sync: the frame that asks; the first of its cycle.
  void sync_queued(Nanoseconds now, const CanFrame& sync = canopen::make_sync()) noexcept;
  /// To be called with every frame received, of whatever node, in the order of the stamps. FD frames answer
  /// nothing where the bus has no data rate; their stuffing is not known, so that they seem to begin up to a
  /// few us late.
  Answer on_frame(const ReceivedFrame& received) noexcept;

  std::uint64_t num_syncs() const noexcept { return num_syncs_; }

 private:
  Nanoseconds wire_time(const CanFrame& frame) const noexcept;

  BitRates rates_;
  bool has_data_rate_;
  Nanoseconds sync_wire_time_ns_ = 0;
  Nanoseconds intermission_ns_;
  std::uint64_t num_syncs_ = 0;
  Nanoseconds earliest_end_ns_ = 0;               // of the SYNC queued last, had the wire been free
  Nanoseconds end_ns_ = 0, previous_end_ns_ = 0;  // of the last two, best estimate
};

}  // namespace godobject
