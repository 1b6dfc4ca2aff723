// Joint velocity from quantised positions: first-order adaptive windowing, best-fit variant.
//
// Janabi-Sharifi, Hayward, Chen, "Discrete-time adaptive windowing for velocity estimation", IEEE
// Trans. Control Systems Technology 8(6), 2000. The window is the longest one whose least-squares line stays
// within the noise band at every sample. It is long (precise) in slow motion, short (prompt) when the motion
// bends. A plain difference errs by one quantum per period; a full window of n periods by about one quantum
// per n periods.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "hal/base/nanoseconds.h"

namespace godobject {

class VelocityEstimator {
 public:
  static constexpr std::size_t capacity = 16;  // samples; the window has at most 15 periods

  /// noise_band: half width of the band around the line (unit of q), one quantum of the encoder.
  explicit VelocityEstimator(double noise_band) noexcept : noise_band_(noise_band * (1 + 1e-9)) {}

  void reset() noexcept { size_ = 0; }

  /// Adds a sample and returns dq/dt; 0 for the first. q: rad or m. t_ns: sampling time, ns, later than all
  /// before, any spacing. Work is bounded by capacity^2 / 2 multiplications.
  double update(double q, Nanoseconds t_ns) noexcept {
    newest_ = (newest_ + 1) % capacity;
    history_[newest_] = {q, t_ns};
    if (size_ < capacity) ++size_;
    return slope_of_longest_line();
  }

 private:
  struct Point {
    double q = 0;
    Nanoseconds t_ns = 0;
  };
  struct Line {
    double intercept = 0;  // at the newest sample, relative to its q
    double slope = 0;
  };
  using Window = std::array<Point, capacity>;

  // Sample `back` periods ago, relative to the newest: x (unit of q), t (s, <= 0).
  struct Relative {
    double x, t;
  };
  Relative relative(std::size_t back) const noexcept {
    const Point& now = history_[newest_];
    const Point& then = history_[(newest_ + capacity - back) % capacity];
    return {then.q - now.q, 1e-9 * static_cast<double>(then.t_ns - now.t_ns)};
  }

  double slope_of_longest_line() const noexcept {
    double slope = 0;
    double n = 1, sum_t = 0, sum_x = 0, sum_tt = 0, sum_tx = 0;
    for (std::size_t back = 1; back < size_; ++back) {
      const auto [x, t] = relative(back);
      n += 1;
      sum_t += t;
      sum_x += x;
      sum_tt += t * t;
      sum_tx += t * x;
      // least squares x = a + b t:  b = (n Stx - St Sx) / (n Stt - St^2),  a = (Sx - b St) / n
      Line line;
      line.slope = (n * sum_tx - sum_t * sum_x) / (n * sum_tt - sum_t * sum_t);
      line.intercept = (sum_x - line.slope * sum_t) / n;
      if (!fits(line, back)) break;
      slope = line.slope;
    }
    return slope;
  }

  bool fits(const Line& line, std::size_t window) const noexcept {
    for (std::size_t back = 0; back <= window; ++back) {
      const auto [x, t] = relative(back);
      if (!(std::abs(x - line.intercept - line.slope * t) <= noise_band_)) return false;
    }
    return true;
  }

  double noise_band_;
  Window history_{};
  std::size_t newest_ = 0;
  std::size_t size_ = 0;
};

}  // namespace godobject
