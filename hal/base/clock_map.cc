#include "hal/base/clock_map.h"

#include <limits>

namespace godobject {
namespace {

constexpr Nanoseconds no_tolerance = std::numeric_limits<Nanoseconds>::max();
/// Residual tolerance of a window: this multiple of the median residual, at least min_tolerance (ns).
constexpr Nanoseconds outlier_ratio = 4;
constexpr Nanoseconds min_tolerance = 20'000;

}  // namespace

void ClockMap::add(Nanoseconds device, Nanoseconds host) noexcept {
  const Point point{.device = device, .offset = host - device};
  if (!started_) {
    started_ = true;
    window_begin_ = device;
    least_delayed_ = point;
    origin_ = device;
    offset_ = point.offset;
    return;
  }
  if (device - window_begin_ >= window_) {
    close_window();
    window_begin_ = device;
    least_delayed_ = point;
  } else if (point.offset < least_delayed_.offset) {
    least_delayed_ = point;
  }
  // Fewer than three windows do not determine a line: the smallest offset so far is used.
  if (num_points_ < 3) offset_ = std::min(offset_, point.offset);
}

void ClockMap::close_window() noexcept {
  points_[next_] = least_delayed_;
  next_ = (next_ + 1) % num_windows;
  num_points_ = std::min(num_points_ + 1, num_windows);
  if (num_points_ < 3) return;
  fit(no_tolerance);
  std::array<Nanoseconds, num_windows> residuals{};
  for (std::size_t i = 0; i < num_points_; ++i) residuals[i] = std::abs(residual(points_[i]));
  const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(num_points_ / 2);
  std::nth_element(residuals.begin(), middle, residuals.begin() + static_cast<std::ptrdiff_t>(num_points_));
  fit(std::max(outlier_ratio * *middle, min_tolerance));
}

/// Fits the line by least squares to the points whose residual from the present line is at most `tolerance`
/// (ns).
void ClockMap::fit(Nanoseconds tolerance) noexcept {
  const Point& newest = points_[(next_ + num_windows - 1) % num_windows];
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < num_points_; ++i) {
    const Point& p = points_[i];
    if (tolerance != no_tolerance && std::abs(residual(p)) > tolerance) continue;
    // Times are relative to the newest point, because differences of absolute times in double are too coarse.
    const auto x = static_cast<double>(p.device - newest.device);
    const auto y = static_cast<double>(p.offset - newest.offset);
    n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
  }
  const double det = n * sxx - sx * sx;
  if (n < 2 || !(det > 0)) return;
  drift_ = std::clamp((n * sxy - sx * sy) / det, -max_drift, max_drift);
  origin_ = newest.device;
  offset_ = newest.offset + std::llround((sy - drift_ * sx) / n);
}

}  // namespace godobject
