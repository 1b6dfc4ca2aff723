// Set of small numbers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace godobject {

/// Set of numbers below n. below: a bound of the numbers in the set, so that members of a large set with few
/// small numbers are visited fast.
template <std::size_t n>
struct BitSet {
  std::array<std::uint64_t, (n + 63) / 64> words;

  void insert(std::uint32_t i) noexcept { words[i / 64] |= std::uint64_t(1) << (i % 64); }
  bool contains(std::uint32_t i) const noexcept { return (words[i / 64] >> (i % 64) & 1) != 0; }
  void erase(std::uint32_t i) noexcept { words[i / 64] &= ~(std::uint64_t(1) << (i % 64)); }
  void insert(const BitSet& other, std::uint32_t below) noexcept {
    for (std::uint32_t k = 0; 64 * k < below; ++k) words[k] |= other.words[k];
  }
  std::uint32_t size(std::uint32_t below) const noexcept {
    std::uint32_t size = 0;
    for (std::uint32_t k = 0; 64 * k < below; ++k) size += num_bits(words[k]);
    return size;
  }
  /// Counts bits by sums over growing parts of the word. std::popcount() needs a library on processors
  /// without the instruction.
  static std::uint32_t num_bits(std::uint64_t word) noexcept {
    word -= word >> 1 & 0x5555555555555555;
    word = (word & 0x3333333333333333) + (word >> 2 & 0x3333333333333333);
    word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0f;
    return static_cast<std::uint32_t>(word * 0x0101010101010101 >> 56);
  }
  template <class F>
  void each(std::uint32_t below, F f) const noexcept {
    for (std::uint32_t k = 0; 64 * k < below; ++k)
      for (std::uint64_t left = words[k]; left != 0; left &= left - 1)
        f(64 * k + static_cast<std::uint32_t>(std::countr_zero(left)));
  }
};

}  // namespace godobject
