// Detects wrong or missing samples: intervals of a recorded motion much faster than those before and after.
#pragma once

#include <algorithm>
#include <optional>

#include "platform/motion/curve.h"

namespace godobject {

/// Interval from sample `from` to the next.
struct SuddenMove {
  std::size_t from = 0;
  double distance = 0;  // m or rad
  double time = 0;      // s
};

/// Returns the fastest interval above least_speed that is more than 10 times as fast as the slower of two
/// intervals on either side. A single wrong sample makes two fast intervals, there and back.
/// distance(i): distance from sample i to the next.
template <class Distance>
std::optional<SuddenMove> sudden_move(const TimeGrid& grid, double least_speed, Distance distance) {
  constexpr double much_faster = 10;
  const std::size_t n = grid.size() - 1;
  const auto speed = [&](std::size_t i) { return distance(i) / grid.interval(i); };
  const auto slower_of = [&](std::size_t near, std::size_t far) {
    return far < n ? std::min(speed(near), speed(far)) : near < n ? speed(near) : 0;
  };
  std::optional<SuddenMove> found;
  double fastest = least_speed;
  for (std::size_t i = 0; i < n && n > 1; ++i) {
    // i - 1 and i - 2 wrap around before the first sample, and are out of range then
    if (speed(i) <= fastest ||
        speed(i) <= much_faster * std::max(slower_of(i - 1, i - 2), slower_of(i + 1, i + 2)))
      continue;
    fastest = speed(i);
    found = {.from = i, .distance = distance(i), .time = grid.interval(i)};
  }
  return found;
}

}  // namespace godobject
