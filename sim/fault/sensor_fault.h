// Replaces the true coordinate of a joint by that of a faulty sensor.
#pragma once

#include <cmath>
#include <limits>
#include <optional>

#include "hal/rig/params.h"

namespace godobject {

struct SensorFault {
  std::optional<double> held{};  // rad or m: stuck coordinate
  double offset = 0;             // rad or m
  double wraps_at_counts = 0;    // 0: as in its calibration
  bool no_value = false;

  /// Returns the coordinate (rad or m) shown by a sensor with this calibration at q; NaN: no value.
  double shown(double q, const Calibration& calibration) const noexcept {
    if (no_value) return std::numeric_limits<double>::quiet_NaN();
    const double seen = held.value_or(q) + offset;
    if (wraps_at_counts == 0) return seen;
    const double counts = calibration.sign * (seen - calibration.home) * calibration.counts_per_unit;
    const double from_zero = counts + static_cast<double>(calibration.offset_counts);
    const double lost = wraps_at_counts * std::floor(from_zero / wraps_at_counts);
    return seen - calibration.sign * lost / calibration.counts_per_unit;
  }
};

}  // namespace godobject
