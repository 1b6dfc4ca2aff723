// Maps the clock of a device at the far end of a line to host time. Messages arrive late, never early, by a
// delay that varies. The least delayed messages therefore determine the map.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "hal/base/nanoseconds.h"

namespace godobject {

/// A 32-bit counter that wraps, extended to 64 bits.
class UnwrappedCount {
 public:
  /// Returns the extended count. count: next value of the counter, less than 2^31 away from the previous one.
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

/// host = device + offset + drift (device - origin), fitted by least squares to the least delayed message of
/// each of the last windows. A window whose messages were all late is rejected as an outlier. A delay common
/// to all messages (wire, adapter) is not observable and stays in the offset.
class ClockMap {
 public:
  static constexpr std::size_t num_windows = 16;
  // Crystals are within 1e-4, ceramic resonators within 5e-3: see docs.
  static constexpr double max_drift = 1e-3;

  /// window: duration in device time over which the least delayed message is selected, ns, > 0.
  explicit ClockMap(Nanoseconds window = 250'000'000) noexcept : window_(window) {}

  /// Adds a message. device: device time at which it was sent, ns. host: host time at which it arrived, ns.
  void add(Nanoseconds device, Nanoseconds host) noexcept;
  /// Returns the host time of a device time. Before the first message both are equal.
  Nanoseconds to_host(Nanoseconds device) const noexcept {
    return device + offset_ + std::llround(drift_ * static_cast<double>(device - origin_));
  }
  /// Returns the rate error of the device clock, ppm; positive if it runs slower than the host clock.
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
  std::array<Point, num_windows> points_{};  // ring buffer: least delayed message of each closed window
  std::size_t num_points_ = 0, next_ = 0;
  Point least_delayed_{};  // least delayed message of the open window
  Nanoseconds window_begin_ = 0;
  bool started_ = false;
  Nanoseconds origin_ = 0, offset_ = 0;
  double drift_ = 0;
};

}  // namespace godobject
