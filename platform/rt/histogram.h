// Histogram of durations with bins of fixed relative width: an hour of a loop in 9 kB.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace godobject {

/// Counts values in log-linear bins: exact up to 2 * steps_per_octave, then steps_per_octave equal bins per
/// octave. A bin's edge is at most 1/32 above any value in it.
/// Values below 0 count as 0; values of 2^40 and above (18 min in ns) count in the last bin. Adding is
/// real-time.
class Histogram {
 public:
  static constexpr unsigned steps_log2 = 5;
  static constexpr std::uint64_t steps_per_octave = 1u << steps_log2;
  static constexpr unsigned max_bits = 40;
  static constexpr std::size_t num_bins = (max_bits - steps_log2 + 1) * steps_per_octave;

  void add(std::int64_t value) noexcept {
    value = std::max<std::int64_t>(value, 0);
    ++bins_[bin_of(static_cast<std::uint64_t>(value))];
    ++count_;
    max_ = std::max(max_, value);
  }

  std::uint64_t count() const noexcept { return count_; }
  std::int64_t max() const noexcept { return max_; }
  std::uint64_t in_bin(std::size_t bin) const noexcept { return bins_[bin]; }

  /// Returns the largest value of the bin.
  static constexpr std::int64_t upper_edge(std::size_t bin) noexcept {
    if (bin < 2 * steps_per_octave) return static_cast<std::int64_t>(bin);
    const std::size_t shift = bin / steps_per_octave - 1;
    const std::uint64_t step = steps_per_octave + bin % steps_per_octave;
    return static_cast<std::int64_t>(((step + 1) << shift) - 1);
  }

  /// Returns a bound that at least this share of the values does not exceed, within a bin's width; 0 if
  /// empty. share: 0 to 1.
  std::int64_t percentile(double share) const noexcept {
    const double rank = std::ceil(std::clamp(share, 0.0, 1.0) * static_cast<double>(count_));
    std::uint64_t seen = 0;
    for (std::size_t bin = 0; bin < num_bins; ++bin) {
      seen += bins_[bin];
      if (seen > 0 && static_cast<double>(seen) >= rank) return std::min(upper_edge(bin), max_);
    }
    return max_;
  }

 private:
  static constexpr std::size_t bin_of(std::uint64_t value) noexcept {
    if (value < 2 * steps_per_octave) return static_cast<std::size_t>(value);
    if (value >> max_bits != 0) return num_bins - 1;
    const auto shift = static_cast<unsigned>(std::bit_width(value)) - (steps_log2 + 1);
    return static_cast<std::size_t>(shift * steps_per_octave + (value >> shift));
  }

  std::array<std::uint64_t, num_bins> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t max_ = 0;
};

}  // namespace godobject
