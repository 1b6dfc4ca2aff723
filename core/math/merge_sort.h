// Sorting of unpredictable data without branches on the comparisons.
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>

namespace godobject {

/// Sorts stably, from runs of one up. before(a, b): a comes before b. spare: storage for n items.
template <class Item, class Before>
void merge_sort(Item* items, Item* spare, std::size_t n, Before before) noexcept {
  Item *from = items, *to = spare;
  for (std::size_t run = 1; run < n; run *= 2) {
    for (std::size_t begin = 0; begin < n; begin += 2 * run) {
      const std::size_t middle = std::min(begin + run, n), end = std::min(begin + 2 * run, n);
      std::size_t i = begin, j = middle, k = begin;
      while (i < middle && j < end) {
        const bool second = before(from[j], from[i]);
        to[k++] = from[second ? j : i];
        j += second ? 1 : 0;
        i += second ? 0 : 1;
      }
      std::copy(from + i, from + middle, to + k);
      std::copy(from + j, from + end, to + k + (middle - i));
    }
    std::swap(from, to);
  }
  if (from != items) std::copy_n(from, n, items);
}

}  // namespace godobject
