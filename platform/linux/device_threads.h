// Threads that serve devices: a tracker on a serial line or a TCP connection, and the SpaceMouse of the
// daemon spacenavd. Only such a thread waits for its line, server or daemon, even when that is unplugged or
// ends.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "hal/tracker/link.h"
#include "platform/device/spacemouse.h"
#include "platform/linux/serial_port.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/ring.h"

namespace godobject {

/// A tracker's serial line or connection and the thread that serves it. The loop reads the newest report
/// without locks.
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
  /// Connects to the server of the port. Returns empty or the error.
  std::string connect();
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

struct SpaceMouseCounters {
  std::uint64_t events = 0, malformed = 0, connections = 0;
  bool connected = false;
};

/// Returns $SPNAV_SOCKET, or the default path of Debian's daemon.
std::string spacenav_socket();

/// Connection to spacenavd and the thread that reads it. The daemon's library (libspnav) is not used: it
/// keeps one connection in global variables and waits for the rest of an event. It also cannot distinguish a
/// daemon that ended from a silent one.
class SpaceMouseThread {
 public:
  /// Receives a line when the daemon ends or returns. Called in this thread.
  using Log = std::function<void(const std::string&)>;

  /// Connects, then reads events into the device, which must outlive this object. Returns null with the
  /// reason and remedy in why_not.
  static std::unique_ptr<SpaceMouseThread> start(const std::string& socket, SpaceMouse& device, Log log,
                                                 std::string& why_not);
  ~SpaceMouseThread();
  SpaceMouseThread(const SpaceMouseThread&) = delete;
  SpaceMouseThread& operator=(const SpaceMouseThread&) = delete;

  SpaceMouseCounters counters() const noexcept;
  const std::string& socket() const noexcept { return socket_; }

 private:
  SpaceMouseThread(std::string socket, int descriptor, SpaceMouse& device, Log log);
  void run(const std::stop_token& stop);
  void wait(Nanoseconds until) noexcept;
  void read();
  /// Decodes events; an incomplete one stays for later. Returns false if the bytes are no event.
  bool take(std::size_t size) noexcept;
  void lose(const std::string& why);
  void reconnect();

  std::string socket_;
  SpaceMouse& device_;
  Log log_;
  MonotonicClock clock_;
  int descriptor_ = -1;  // -1: not connected
  Nanoseconds next_try_ = 0;
  std::array<std::uint8_t, 64 * spacenav_event_bytes> bytes_{};
  std::size_t begun_ = 0;  // bytes of an incomplete event
  std::atomic<std::uint64_t> events_{0}, malformed_{0}, connections_{1};
  std::atomic<bool> connected_{true};
  std::jthread thread_;  // last, so that it ends before the other members
};

}  // namespace godobject
