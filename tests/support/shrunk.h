// Counter-examples without needless events.
#pragma once

#include <cstddef>
#include <vector>

namespace godobject::test {

/// Returns the shortest path found by leaving out events, one at a time, that still breaks a promise.
template <class Event, class Breaks>
std::vector<Event> shrunk(std::vector<Event> path, Breaks&& breaks) {
  for (std::size_t i = 0; i < path.size();) {
    std::vector<Event> shorter;
    for (std::size_t k = 0; k < path.size(); ++k)
      if (k != i) shorter.push_back(path[k]);
    if (!breaks(shorter)) ++i;
    else {
      path = shorter;
      i = 0;
    }
  }
  return path;
}

}  // namespace godobject::test
