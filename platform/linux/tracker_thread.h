// A tracker's serial line and the thread that serves it. The loop reads the newest report without locks. Only
// this thread waits for the line, even when that is unplugged.
#pragma once

#include <filesystem>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "hal/tracker/link.h"
#include "platform/linux/serial_port.h"
#include "platform/rt/clock.h"
#include "platform/rt/ring.h"

namespace godobject {

class TrackerThread final : public TrackerLink {
 public:
  /// Starts at once: opens the port, and retries once a second while it is missing. Until boot_timeout_s the
  /// state is `opening`, afterwards `failed`. A port that was open and is lost is `opening` again.
  explicit TrackerThread(std::unique_ptr<Tracker> tracker);
  /// Ends the thread, within half a second if it is sending a break.
  ~TrackerThread() override = default;

  /// For one other thread. now: unused, because reports carry the time of MonotonicClock.
  [[nodiscard]] bool try_read(TrackerReport& out, Nanoseconds now) noexcept override;
  const TrackerParams& params() const noexcept override { return tracker_->params(); }

 private:
  void run(const std::stop_token& stop);
  /// Returns false if the line is missing.
  bool open();
  void serve();
  void carry_out(const LineRequest& request);
  void hand_over();

  std::unique_ptr<Tracker> tracker_;
  SerialPort port_;
  MonotonicClock clock_;
  Ring<TrackerReport> reports_{64};
  bool changed_ = true;  // since the last report that was passed on
  Nanoseconds last_expiry_ = 0;
  Nanoseconds opening_since_ = 0;
  std::jthread thread_;  // last, so that it ends before the other members
};

}  // namespace godobject
