// The clock of a device on the other end of a line, told in host time. What arrives is always late, never early, by a
// delay that changes from message to message: the least delayed ones carry the time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "hal/can/frame.h"

namespace godobject {

/// A count of 32 bits that wraps, as one that does not.
class UnwrappedCount {
 public:
  /// Takes steps of less than 2^31 either way.
  std::int64_t unwrap(std::uint32_t count) noexcept {
    if (!started_) total_ = count;
    started_ = true;
    total_ += static_cast<std::int32_t>(count - static_cast<std::uint32_t>(total_));
    return total_;
  }
  void reset() noexcept { started_ = false; }

 private:
  std::int64_t total_ = 0;
  bool started_ = false;
};

/// host = device + offset + drift (device - origin): the line fitted by least squares to the least delayed message of
/// each of the last windows. A window in which all messages were late is an outlier and is left out. Delay that all
/// messages have (the wire, the adapter) cannot be seen and stays in the offset.
class ClockMap {
 public:
  static constexpr std::size_t num_windows = 16;
  static constexpr double max_drift =
      1e-3;  // crystals are within 1e-4, ceramic resonators within 5e-3: see docs

  /// window: ns, of device time.
  explicit ClockMap(Nanoseconds window = 250'000'000) noexcept : window_(window) {}

  /// A message that left at `device` and arrived at `host`.
  void add(Nanoseconds device, Nanoseconds host) noexcept;
  /// Host time of an instant of the device's clock. Before the first message: the same number.
  Nanoseconds to_host(Nanoseconds device) const noexcept {
    return device + offset_ + std::llround(drift_ * static_cast<double>(device - origin_));
  }
  /// How much slower than the host's the device's clock runs, 1e-6.
  double drift_ppm() const noexcept { return 1e6 * drift_; }
  void reset() noexcept { *this = ClockMap(window_); }

 private:
  struct Point {
    Nanoseconds device = 0, offset = 0;
  };

  void close_window() noexcept;
  void fit(Nanoseconds tolerance) noexcept;
  Nanoseconds residual(const Point& p) const noexcept { return p.device + p.offset - to_host(p.device); }

  Nanoseconds window_;
  std::array<Point, num_windows> points_{};  // ring of the windows' least delayed messages
  std::size_t num_points_ = 0, next_ = 0;
  Point least_{};  // of the window that is open
  Nanoseconds window_begin_ = 0;
  bool started_ = false;
  Nanoseconds origin_ = 0, offset_ = 0;
  double drift_ = 0;
};

}  // namespace godobject
