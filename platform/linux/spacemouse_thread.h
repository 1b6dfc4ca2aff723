// The connection to spacenavd and the thread that reads it. Nothing the daemon does, not even its end, is waited for by anyone
// but this thread. The library of the daemon (libspnav) is not used: it has one connection in global variables, waits for the
// rest of an event that has begun, and does not tell a daemon that has gone from one that is silent.
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

/// $SPNAV_SOCKET, or where Debian's daemon listens.
std::string spacenav_socket();

class SpaceMouseThread {
 public:
  /// Takes a line about a daemon that has gone or is back. In this thread.
  using Log = std::function<void(const std::string&)>;

  /// Connects, and reads from then on into the device, which outlives it. Null: why not, and what to do.
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
  /// What has begun of an event stays for later. False: it is no event.
  bool take(std::size_t size) noexcept;
  void lose(const std::string& why);
  void reconnect();

  std::string socket_;
  SpaceMouse& device_;
  Log log_;
  MonotonicClock clock_;
  int descriptor_ = -1;  // -1: the daemon is not there
  Nanoseconds next_try_ = 0;
  std::array<std::uint8_t, 64 * spacenav_event_bytes> bytes_{};
  std::size_t begun_ = 0;  // bytes of an event that has not come whole
  std::atomic<std::uint64_t> events_{0}, malformed_{0}, connections_{1};
  std::atomic<bool> connected_{true};
  std::jthread thread_;  // last: ends before the rest goes
};

}  // namespace godobject
