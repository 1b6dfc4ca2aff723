// Picture of motions and forces: speed and force over time with intervals in colour, and the path from above.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/trace/metrics.h"

namespace godobject {

/// Interval of time, s.
struct TimeSpan {
  double begin = 0, end = 0;
};

/// Returns the intervals in which a condition holds. t: s, ascending.
std::vector<TimeSpan> spans_of(std::span<const double> t, const std::vector<bool>& holds);

/// Motion and forces of a body or device, and its intervals.
struct PlottedMotion {
  std::string name;
  const MotionSamples& motion;
  std::span<const double> displayed_N, contact_N;  // as many as samples of the motion; empty: none
  std::vector<TimeSpan> held, released, idle;  // a body in its grip; disengaged, or its clutch open; at rest
};

/// Draws one row for each motion. path: see draw_plot(). Returns the error with its remedy; empty on success.
std::string draw_motions(const std::string& path, std::span<const PlottedMotion> motions);

}  // namespace godobject
