// Where a recorded motion is much faster than just before and just after: a sample is wrong there, or one is missing.
#pragma once

#include <algorithm>
#include <optional>

#include "platform/motion/curve.h"

namespace godobject {

/// From sample `from` to the one after it.
struct SuddenMove {
  std::size_t from = 0;
  double distance = 0;  // m or rad
  double time = 0;      // s
};

/// The fastest of the intervals that are more than 10 times as fast as the slower of two on either side, and faster than
/// least_speed. A single wrong sample is two fast intervals, there and back. distance(i): from sample i to the one after it.
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
    // before the first sample i - 1 and i - 2 are beyond all others
    if (speed(i) <= fastest ||
        speed(i) <= much_faster * std::max(slower_of(i - 1, i - 2), slower_of(i + 1, i + 2)))
      continue;
    fastest = speed(i);
    found = {.from = i, .distance = distance(i), .time = grid.interval(i)};
  }
  return found;
}

}  // namespace godobject
