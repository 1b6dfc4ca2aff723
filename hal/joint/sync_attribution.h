// Which SYNC a received frame answers, and when the nodes took the sample in it. One object per bus.
#pragma once

#include <vector>

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
/// a frame that began before then cannot answer it: it answers an earlier one. Such a frame also held the
/// wire: SYNC came after it, by up to the longest frame, 135 us at 1 Mbit/s. Any other frame is taken for an
/// answer to the SYNC queued last.
///
/// Stamps that are late (taken by software) move both estimates later, never past the beginning of the
/// answer; a true answer is never booked to the SYNC before. Answers that are stamped when they are read may be
/// late by periods: answer_delay.h. Stamps also hide that SYNC waited for a frame of the host's own, or behind such frames in a controller that keeps the order of its queue. Answers
/// to the SYNC before that begin in that time are booked to the new one.
class SyncAttribution {
 public:
  struct Answer {
    std::uint64_t sync = 0;  // counted from 1; 0: none was queued before the frame began
    Nanoseconds t_ns = 0;    // end of that SYNC on the wire: when the sample was taken
  };

  /// reach: greatest delay of answers, in periods. Allocates; nothing later does.
  explicit SyncAttribution(const BusParams& bus, std::uint64_t reach = 1);

  /// sync: the frame that asks; the first of its cycle.
  void sync_queued(Nanoseconds now, const CanFrame& sync = canopen::make_sync()) noexcept;
  /// Counts a cycle without SYNC: frames from now on came in it, and answer an earlier one.
  void sync_left_out(Nanoseconds now) noexcept;
  /// To be called with every frame received, of whatever node, in the order of the stamps. FD frames answer
  /// nothing where the bus has no data rate; their stuffing is not known, so that they seem to begin up to a
  /// few us late.
  Answer on_frame(const ReceivedFrame& received) noexcept;

  /// End on the wire of SYNC number `sync`, or of the last one before that was not left out. Of one longer ago than
  /// `reach`, that of the first one that is known.
  Nanoseconds end_of(std::uint64_t sync) const noexcept;

  /// Number of SYNCs so far, queued and left out.
  std::uint64_t num_syncs() const noexcept { return num_syncs_; }

 private:
  struct Sync {
    Nanoseconds earliest_end_ns = 0;  // had the wire been free
    Nanoseconds end_ns = 0;           // best estimate; of one left out, that of the one before
    bool left_out = false;
  };

  Sync& at(std::uint64_t sync) noexcept { return syncs_[sync % syncs_.size()]; }
  const Sync& at(std::uint64_t sync) const noexcept { return syncs_[sync % syncs_.size()]; }
  std::uint64_t oldest() const noexcept {
    return num_syncs_ < syncs_.size() ? 1 : num_syncs_ + 1 - syncs_.size();
  }
  Nanoseconds wire_time(const CanFrame& frame) const noexcept;

  BitRates rates_;
  bool has_data_rate_;
  Nanoseconds sync_wire_time_ns_ = 0;
  Nanoseconds intermission_ns_;
  std::uint64_t num_syncs_ = 0;
  std::vector<Sync> syncs_;  // the last ones; number i is at i modulo its size
};

}  // namespace godobject
