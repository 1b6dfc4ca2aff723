// A serial line of this machine: a UART, a USB adapter or a pseudo-terminal, raw and without waiting.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/nonblocking.h"
#include "hal/can/frame.h"
#include "platform/rt/setup.h"

namespace godobject {

enum class SerialState : std::uint8_t {
  closed,
  open,
  hung_up,  // unplugged, or the other end of a pseudo-terminal is closed: close(), then open() when it is
            // back
  failed,   // refused by the system: trouble() has the error and the remedy
};

/// Outcome of the request for low latency. Without it a USB adapter delays received bytes: an FTDI by 16 ms.
enum class LowLatency : std::uint8_t {
  not_requested,
  in_effect,   // ASYNC_LOW_LATENCY was read back; the latency timer, if there is one, is at most 1 ms
  not_a_uart,  // a pseudo-terminal, or a driver without the setting
  refused,     // latency_report() has the reason and the udev rule
};

/// Reads and writes that did not return at once, although the port never waits for bytes. The kernel delayed
/// them, because its worker for terminals (kworker, flush_to_ldisc) held the terminal and was not running.
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
  std::uint32_t baud = 115'200;  // bit/s, also beyond the standard rates. 8 data bits, no parity, 1 stop bit
  bool low_latency = true;
};

/// Reading and writing return at once, do not allocate and do not throw; the rest is for setup. For one
/// thread at a time.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort() { close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  /// Opens the port exclusively in raw mode, with empty buffers. Returns false with state() failed and the
  /// reason in trouble().
  [[nodiscard]] bool open(const std::string& path, const SerialSettings& settings);
  /// Takes ownership of an open terminal without configuring it, such as the master of a pseudo-terminal. It
  /// must be non-blocking.
  void adopt(int descriptor, std::string name);
  void close() noexcept;

  /// Reads the bytes that have arrived, as many as fit. Returns 0 if there are none, or if state() is no
  /// longer open.
  [[nodiscard]] std::size_t read(std::span<std::uint8_t> out) noexcept GODOBJECT_NONBLOCKING;
  /// Returns the number of first bytes that were accepted; fewer than all if the buffer is full or state()
  /// has changed.
  [[nodiscard]] std::size_t write(std::span<const std::uint8_t> bytes) noexcept GODOBJECT_NONBLOCKING;
  /// Waits until read() has bytes or an error, at most `timeout`. Returns false after the timeout. Not for
  /// the loop.
  [[nodiscard]] bool wait_readable(Nanoseconds timeout) noexcept;

  /// Changes the rate after written bytes have left. Returns false as open(). Waits, so not for the loop.
  [[nodiscard]] bool set_baud(std::uint32_t baud);
  /// Holds the line at 0 for a quarter to half a second, which resets NDI trackers, for example. No effect on
  /// a pseudo-terminal. Not for the loop.
  void send_break() noexcept;
  /// Discards bytes received and not read.
  void discard_input() noexcept;

  /// Readable when there are bytes or the state has changed; -1 while closed. For ppoll.
  int descriptor() const noexcept { return fd_; }
  SerialState state() const noexcept { return state_; }
  LowLatency low_latency() const noexcept { return low_latency_; }
  /// Counted since the port was constructed.
  const SlowCalls& slow_calls() const noexcept { return slow_calls_; }
  /// Returns one line on delayed reads and writes, with the remedy; empty if there were none. Allocates.
  std::string slowness() const;
  const std::string& path() const noexcept { return path_; }
  /// Returns the trouble and its remedy; empty if there is none. Allocates.
  std::string trouble() const;
  /// Returns one line on low_latency() of this port, with the udev rule if it was refused. Allocates.
  std::string latency_report() const;

 private:
  bool fail(std::string why);
  bool configure(std::uint32_t baud);
  void request_low_latency();
  void lost(int error) noexcept;

  int fd_ = -1;
  SerialState state_ = SerialState::closed;
  LowLatency low_latency_ = LowLatency::not_requested;
  int latency_error_ = 0;                  // errno of the request
  std::optional<int> latency_timer_ms_{};  // latency timer of the USB adapter, as read back
  int error_ = 0;                          // errno that ended the connection
  SlowCalls slow_calls_{};
  std::string path_{};
  std::string why_{};
};

/// "PATH" or "PATH,BAUD", as in the addresses of buses. baud: the default for a path alone; 0 if the text
/// after the comma is not a number.
struct SerialAddress {
  std::string path;
  std::uint32_t baud = 0;
};
SerialAddress parse_serial_address(const std::string& where, std::uint32_t default_baud);

/// Returns the time of one byte, s: 10 bits with 8 data bits, no parity, 1 stop bit.
constexpr double seconds_per_byte(std::uint32_t baud) noexcept { return 10.0 / baud; }

/// Returns the latency timer of the USB adapter behind terminal `path`, ms, from the kernel's files below
/// `sysfs`. None if the driver has no such timer (only FTDI's has).
std::optional<int> read_latency_timer_ms(const std::string& path, std::string_view sysfs = "/sys");

/// Checks a port without opening it: existence, permission, latency timer.
/// name: name of the bus or tracker on it. root: folder of /dev and /sys.
RtStep check_serial_port(const std::string& name, const std::string& path,
                         const std::filesystem::path& root = "/");

/// A pseudo-terminal: a serial line with another program at its other end. The caller owns the descriptors.
/// `slave` must stay open, because reading the master without an open slave is an error.
struct Pty {
  int master = -1, slave = -1;
  std::string name{};  // path of the other end
  std::string why{};   // empty: it is open
};

/// Makes a pseudo-terminal: raw, non-blocking, not inherited.
Pty make_pty();

}  // namespace godobject
