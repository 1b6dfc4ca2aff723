// Small random generator with equal numbers on every machine and library.
#pragma once

#include <cstdint>

namespace godobject {

/// Generator of Steele, Lea and Flood (2014). Any seed is valid.
class SplitMix64 {
 public:
  explicit constexpr SplitMix64(std::uint64_t seed) noexcept : state_(seed) {}

  constexpr std::uint64_t next() noexcept {
    state_ += 0x9E3779B97F4A7C15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
  }

  /// Returns a uniform number in [0, 1).
  constexpr double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }

  /// Returns true with this probability. Draws no number for 0, so that a disabled fault does not shift the
  /// others.
  constexpr bool chance(double probability) noexcept { return probability > 0 && uniform() < probability; }

 private:
  std::uint64_t state_;
};

}  // namespace godobject
