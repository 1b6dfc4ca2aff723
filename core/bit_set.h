// A set of small numbers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace godobject {

/// Of numbers below n.
template <std::size_t n>
struct BitSet {
  static constexpr std::size_t num_words = (n + 63) / 64;
  std::array<std::uint64_t, num_words> words;

  void insert(std::uint32_t i) noexcept { words[i / 64] |= std::uint64_t(1) << (i % 64); }
  void erase(std::uint32_t i) noexcept { words[i / 64] &= ~(std::uint64_t(1) << (i % 64)); }
  void insert(const BitSet& other) noexcept {
    for (std::size_t k = 0; k < num_words; ++k) words[k] |= other.words[k];
  }
  std::uint32_t size() const noexcept {
    std::uint32_t size = 0;
    for (const std::uint64_t word : words) size += static_cast<std::uint32_t>(std::popcount(word));
    return size;
  }
  template <class F>
  void each(F f) const noexcept {
    for (std::uint32_t k = 0; k < num_words; ++k)
      for (std::uint64_t left = words[k]; left != 0; left &= left - 1)
        f(64 * k + static_cast<std::uint32_t>(std::countr_zero(left)));
  }
};

}  // namespace godobject
