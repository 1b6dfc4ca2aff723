#include "platform/scene/text/key.h"

#include <cmath>

#include "hal/base/format.h"

namespace godobject {

std::string to_string(const Range& range) {
  const bool has_min = std::isfinite(range.min), has_max = std::isfinite(range.max);
  if (has_min && has_max) {
    return range.min_open ? "> " + shortest_plain(range.min) + " and <= " + shortest_plain(range.max)
                          : shortest_plain(range.min) + " to " + shortest_plain(range.max);
  }
  if (has_min) return (range.min_open ? "> " : ">= ") + shortest_plain(range.min);
  return has_max ? "<= " + shortest_plain(range.max) : "";
}

}  // namespace godobject
