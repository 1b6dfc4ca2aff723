// Attributes a received frame to a SYNC and determines its sampling time. One object per bus.
#pragma once

#include <vector>

#include "hal/can/params.h"
#include "hal/can/timing.h"
#include "hal/canopen/canopen.h"

namespace godobject {

/// Without SYNC, the first request of a cycle takes its place. Its answers count as sampled at its end, or at
/// their own beginning if that is earlier.
///
/// Input are only the queue times of SYNCs and the receive stamps, because there is no transmit confirmation.
///
/// Nodes sample at the end of SYNC on the wire. That is at least its queue time plus its duration. A frame
/// that began earlier therefore answers an earlier SYNC. Such a frame also occupied the wire: SYNC followed
/// it, delayed by at most the longest frame, 135 us at 1 Mbit/s. Any other frame counts as an answer to the
/// last queued SYNC.
///
/// Late (software) stamps move both estimates later, never past the beginning of the answer; a true answer is
/// never attributed to the previous SYNC. Answers stamped when they are read may be late by periods, see
/// answer_delay.h. Stamps cannot show that SYNC waited for a frame of the host itself, or behind such frames
/// in a controller with a FIFO queue. Answers to the previous SYNC that begin in this time are attributed to
/// the new one.
class SyncAttribution {
 public:
  struct Answer {
    std::uint64_t sync = 0;  // counted from 1; 0: none was queued before the frame began
    Nanoseconds t_ns = 0;    // end of that SYNC on the wire, which is the sampling time
  };

  /// reach: greatest delay of answers, in periods. Allocates; nothing later does.
  explicit SyncAttribution(const BusParams& bus, std::uint64_t reach = 1);

  /// Records a queued SYNC. sync: the requesting frame, first of its cycle.
  void sync_queued(Nanoseconds now, const CanFrame& sync = canopen::make_sync()) noexcept;
  /// Records a cycle without SYNC. Frames received from now on answer an earlier SYNC.
  void sync_left_out(Nanoseconds now) noexcept;
  /// Attributes a frame. Call it with every received frame, of any node, in the order of the stamps. FD
  /// frames answer no SYNC if the bus has no data rate. Their stuffing is unknown; their computed beginning
  /// is up to a few us late.
  Answer on_frame(const ReceivedFrame& received) noexcept;

  /// Returns the end on the wire of SYNC number `sync`, ns. If it was left out, that of the one before; if it
  /// is longer ago than `reach`, that of the first one kept.
  Nanoseconds end_of(std::uint64_t sync) const noexcept;

  /// Number of SYNCs so far, queued and left out.
  std::uint64_t num_syncs() const noexcept { return num_syncs_; }

 private:
  struct Sync {
    Nanoseconds earliest_end_ns = 0;  // earliest end: if the wire was free
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
  std::vector<Sync> syncs_;  // the last SYNCs; SYNC number i is at index i modulo the size
};

}  // namespace godobject
