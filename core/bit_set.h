// A set of small numbers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace godobject {

/// Of numbers below n. What goes through all of them is told below which number they are: little, of a large set.
template <std::size_t n>
struct BitSet {
  std::array<std::uint64_t, (n + 63) / 64> words;

  void insert(std::uint32_t i) noexcept { words[i / 64] |= std::uint64_t(1) << (i % 64); }
  void erase(std::uint32_t i) noexcept { words[i / 64] &= ~(std::uint64_t(1) << (i % 64)); }
  void insert(const BitSet& other, std::uint32_t below) noexcept {
    for (std::uint32_t k = 0; 64 * k < below; ++k) words[k] |= other.words[k];
  }
  std::uint32_t size(std::uint32_t below) const noexcept {
    std::uint32_t size = 0;
    each(below, [&](std::uint32_t) noexcept { ++size; });
    return size;
  }
  template <class F>
  void each(std::uint32_t below, F f) const noexcept {
    for (std::uint32_t k = 0; 64 * k < below; ++k)
      for (std::uint64_t left = words[k]; left != 0; left &= left - 1)
        f(64 * k + static_cast<std::uint32_t>(std::countr_zero(left)));
  }
};

}  // namespace godobject
