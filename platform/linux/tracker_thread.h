// A tracker's serial line and the thread that serves it. The loop reads the newest report without locks; nothing the
// line does, not even being unplugged, is waited for by anyone but this thread.
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
  /// Starts at once: opens the port, and again once a second while it is not there. Until boot_timeout_s that is
  /// `opening`, from then on `failed`. A port that was there and went is `opening` again.
  explicit TrackerThread(std::unique_ptr<Tracker> tracker);
  /// Ends the thread: within half a second, when it is sending a break.
  ~TrackerThread() override = default;

  /// One other thread. `now` is not used: reports carry the time of MonotonicClock.
  [[nodiscard]] bool try_read(TrackerReport& out, Nanoseconds now) noexcept override;
  const TrackerParams& params() const noexcept override { return tracker_->params(); }

 private:
  void run(const std::stop_token& stop);
  /// False: the line is not there.
  bool open();
  void serve();
  void carry_out(const LineRequest& request);
  void hand_over();

  std::unique_ptr<Tracker> tracker_;
  SerialPort port_;
  MonotonicClock clock_;
  Ring<TrackerReport> reports_{64};
  bool changed_ = true;  // since the last report that was handed over
  Nanoseconds last_expiry_ = 0;
  Nanoseconds opening_since_ = 0;
  std::jthread thread_;  // last: ends before the rest goes
};

}  // namespace godobject
