// A server of OpenIGTLink as a tracker, from the open connection to poses. A tool is named by the device of
// its TRANSFORM, or by its name in TDATA. t_ns of a sample: the time of the message, mapped to the host's
// clock by the least delayed message; without one, its arrival.
#pragma once

#include "hal/base/stamp_clock.h"
#include "hal/tracker/openigtlink.h"
#include "hal/tracker/tracker.h"

namespace godobject {

std::unique_ptr<Tracker> make_openigtlink_tracker(const TrackerParams& params,
                                                  std::vector<std::string>& errors);

class OpenIgtLinkTracker final : public Tracker {
 public:
  explicit OpenIgtLinkTracker(const TrackerParams& params) : Tracker(params) {}

  std::uint32_t first_baud() const noexcept override { return params_.baud; }
  void opened(Nanoseconds now) noexcept override;
  void receive(std::span<const std::uint8_t> bytes, Nanoseconds now) noexcept override;
  LineRequest next(Nanoseconds now) noexcept override;

 private:
  void take_message(Nanoseconds now) noexcept;
  void lose_track(const char* why) noexcept;
  void take_pose(std::size_t tool, const Pose& X_TH, Nanoseconds t, Nanoseconds now) noexcept;

  openigtlink::Receiver receiver_;
  openigtlink::Message request_{"STT_TDATA", "", 0};
  StampClock clock_;
  std::array<Nanoseconds, max_tracked_tools> newest_{};   // time of each tool's newest message, as sent
  std::array<std::uint32_t, max_tracked_tools> count_{};  // measurements of each tool
  bool is_requested_ = false;                             // true once TDATA was requested
  bool is_unreadable_ = false;                            // true after bytes that are no header
  Nanoseconds boot_deadline_ = 0;
  Nanoseconds message_since_ = 0;  // when the present message began to arrive
};

}  // namespace godobject
