// Detects that a joint is at rest.
#pragma once

#include <cmath>

#include "hal/base/nanoseconds.h"

namespace godobject {

/// Duration without motion after which a joint is at rest, ns.
inline constexpr Nanoseconds rest_ns = 100'000'000;

// Largest motion of a joint at rest, besides its counts: a resting hand trembles.
inline constexpr double rest_travel_rad = 2e-3;
inline constexpr double rest_travel_m = 2e-4;
inline constexpr double rest_travel_counts = 2;

class RestWatch {
 public:
  /// max_travel: largest motion at rest, rad or m.
  explicit RestWatch(double max_travel) noexcept : max_travel_(max_travel) {}

  /// Restarts the time of rest, at q.
  void restart(double q, Nanoseconds now) noexcept {
    q_ = q;
    t_ns_ = now;
  }
  /// Adds a sample. q: rad or m. good: false if the sample is missing or implausible.
  void update(double q, bool good, Nanoseconds now) noexcept {
    if (!good || !(std::abs(q - q_) <= max_travel_)) restart(q, now);
  }
  bool at_rest(Nanoseconds now) const noexcept { return now - t_ns_ >= rest_ns; }

 private:
  double max_travel_;
  double q_ = 0;          // coordinate at t_ns_, rad or m
  Nanoseconds t_ns_ = 0;  // since then every sample was within max_travel_ of q_
};

}  // namespace godobject
