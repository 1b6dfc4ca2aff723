// Connection to spacenavd and the thread that reads it. Only this thread waits for the daemon, even when that
// ends. The daemon's library (libspnav) is not used: it keeps one connection in global variables and waits
// for the rest of an event. It also cannot distinguish a daemon that ended from a silent one.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <thread>

#include "platform/device/spacemouse.h"
#include "platform/rt/clock.h"

namespace godobject {

struct SpaceMouseCounters {
  std::uint64_t events = 0, malformed = 0, connections = 0;
  bool connected = false;
};

/// Returns $SPNAV_SOCKET, or the default path of Debian's daemon.
std::string spacenav_socket();

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
