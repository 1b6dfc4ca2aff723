// Grid values of a map.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace godobject::study {

/// Returns `count` >= 2 values with a constant ratio between neighbours, both ends included.
inline std::vector<double> log_spaced(double first, double last, std::size_t count) {
  std::vector<double> values(count);
  for (std::size_t i = 0; i < count; ++i)
    values[i] = first * std::pow(last / first, static_cast<double>(i) / static_cast<double>(count - 1));
  return values;
}

}  // namespace godobject::study
