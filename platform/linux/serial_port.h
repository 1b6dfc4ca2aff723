// A serial line of this machine: a UART, a USB adapter or a pseudo-terminal, raw and without waiting.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "hal/can/frame.h"

namespace godobject {

enum class SerialState : std::uint8_t {
  closed,
  open,
  hung_up,  // unplugged, or the other end of a pseudo-terminal is closed: close(), open() when it is back
  failed,   // the system refused: trouble() has its words and the remedy
};

/// What became of the request for low latency. Without it a USB adapter keeps received bytes back: an FTDI
/// for 16 ms.
enum class LowLatency : std::uint8_t {
  not_asked,
  in_effect,   // ASYNC_LOW_LATENCY was read back; the latency timer, where there is one, is at most 1 ms
  not_a_uart,  // a pseudo-terminal, or a driver without the setting
  refused,     // latency_report() has the reason and the udev rule
};

/// Reads and writes that did not return at once, although the port never waits for bytes: the kernel kept
/// them, because its worker that hands bytes on (kworker, flush_to_ldisc) held the terminal and was not
/// running.
struct SlowCalls {
  static constexpr Nanoseconds at_least = 1'000'000;
  std::uint64_t count = 0;
  Nanoseconds longest = 0;

  void add(Nanoseconds took) noexcept {
    if (took < at_least) return;
    ++count;
    longest = std::max(longest, took);
  }
};

struct SerialSettings {
  std::uint32_t baud =
      115'200;  // bit/s, any: not only the standard rates. 8 data bits, no parity, 1 stop bit
  bool low_latency = true;
};

/// Reading and writing return at once, do not allocate and do not throw; the rest is for set-up.
/// One thread at a time.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort() { close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Raw mode, exclusively, with empty buffers. False: state() is failed and trouble() says why.
  [[nodiscard]] bool open(const std::string& path, const SerialSettings& settings);
  /// Takes over a terminal that is open already, as it is set: the master of a pseudo-terminal. Non-blocking.
  void adopt(int descriptor, std::string name);
  void close() noexcept;

  /// Bytes that have arrived, as many as fit; 0: none now, or state() is not open any more.
  [[nodiscard]] std::size_t read(std::span<std::uint8_t> out) noexcept;
  /// How many of the first bytes were taken; fewer than all: the buffer is full, or state() has changed.
  [[nodiscard]] std::size_t write(std::span<const std::uint8_t> bytes) noexcept;
  /// Waits, at most so long, until read() has something to say. False: it has not. Not for the loop.
  [[nodiscard]] bool wait_readable(Nanoseconds timeout) noexcept;

  /// After what was written has left. False: state() and trouble() as with open(). Waits: not for the loop.
  [[nodiscard]] bool set_baud(std::uint32_t baud);
  /// Holds the line at 0 for a quarter to half a second, which resets e.g. NDI trackers. Nothing on a
  /// pseudo-terminal. Not for the loop.
  void send_break() noexcept;
  /// Forgets what was received and not read.
  void discard_input() noexcept;

  /// Readable when there are bytes or the state has changed; -1 while closed. For ppoll.
  int descriptor() const noexcept { return fd_; }
  SerialState state() const noexcept { return state_; }
  LowLatency low_latency() const noexcept { return low_latency_; }
  /// Since the port was made.
  const SlowCalls& slow_calls() const noexcept { return slow_calls_; }
  /// One line: how long reads and writes were kept, and what to do; empty: none was. Allocates.
  std::string slowness() const;
  const std::string& path() const noexcept { return path_; }
  /// What is wrong and what to do; empty while nothing is. Allocates.
  std::string trouble() const;
  /// One line: what low_latency() means on this port and, where refused, the udev rule. Allocates.
  std::string latency_report() const;

 private:
  bool fail(std::string why);
  bool configure(std::uint32_t baud);
  void request_low_latency();
  void lost(int error) noexcept;

  int fd_ = -1;
  SerialState state_ = SerialState::closed;
  LowLatency low_latency_ = LowLatency::not_asked;
  int latency_error_ = 0;                  // errno of the request
  std::optional<int> latency_timer_ms_{};  // of the USB adapter, as read back
  int error_ = 0;                          // errno that ended the connection
  SlowCalls slow_calls_{};
  std::string path_{};
  std::string why_{};
};

/// "PATH" or "PATH,BAUD", as in the addresses of buses. baud: of a path without one the default, 0 where what stands
/// after the comma is not a number.
struct SerialAddress {
  std::string path;
  std::uint32_t baud = 0;
};
SerialAddress parse_serial_address(const std::string& where, std::uint32_t default_baud);

/// Time of one byte on a line of 8 data bits, no parity, 1 stop bit: 10 bits.
constexpr double seconds_per_byte(std::uint32_t baud) noexcept { return 10.0 / baud; }

/// The latency timer of the USB adapter behind terminal `path`, ms, as the kernel shows it below `sysfs`;
/// none: the driver has no such timer (only FTDI's has).
std::optional<int> read_latency_timer_ms(const std::string& path, std::string_view sysfs = "/sys");

}  // namespace godobject
