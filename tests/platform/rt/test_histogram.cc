// The histogram's bins and percentiles.
#include "platform/rt/cyclic.h"

#include <gtest/gtest.h>

#include <vector>

namespace godobject::test_histogram {
namespace {

std::size_t bin_of(std::int64_t value) {
  Histogram h;
  h.add(value);
  std::size_t bin = 0;
  while (h.in_bin(bin) == 0) ++bin;
  return bin;
}

TEST(Histogram, EveryValueIsInTheBinWhoseEdgesEncloseIt) {
  std::vector<std::int64_t> values{0, 1, 63, 64, 65, 127, 128, 1000, 999'999, 1'000'000};
  for (int bit = 1; bit < 40; ++bit)
    for (const std::int64_t offset : {-1, 0, 1}) values.push_back((std::int64_t{1} << bit) + offset);
  for (const std::int64_t value : values) {
    const std::size_t bin = bin_of(value);
    EXPECT_LE(value, Histogram::upper_edge(bin)) << value;
    if (bin > 0) {
      EXPECT_GT(value, Histogram::upper_edge(bin - 1)) << value;
    }
    EXPECT_LE(static_cast<double>(Histogram::upper_edge(bin)), static_cast<double>(value) * (1 + 1.0 / 32))
        << value;
  }
}

TEST(Histogram, PercentilesOfOneToThousandAreWithinABin) {
  Histogram h;
  for (int i = 1; i <= 1000; ++i) h.add(std::int64_t{1000} * i);
  EXPECT_EQ(h.count(), 1000u);
  EXPECT_EQ(h.max(), 1'000'000);
  for (const auto& [share, exact] : {std::pair{0.5, 500e3}, {0.99, 990e3}, {0.999, 999e3}}) {
    EXPECT_GE(static_cast<double>(h.percentile(share)), exact);
    EXPECT_LE(static_cast<double>(h.percentile(share)), exact * (1 + 1.0 / 32));
  }
  EXPECT_EQ(h.percentile(1), 1'000'000);
}

TEST(Histogram, OneOutlierShowsInTheMaximumOnly) {
  Histogram h;
  for (int i = 0; i < 9999; ++i) h.add(10);
  h.add(5'000'000);
  EXPECT_EQ(h.percentile(0.5), 10);
  EXPECT_EQ(h.percentile(0.999), 10);
  EXPECT_EQ(h.max(), 5'000'000);
}

TEST(Histogram, ValuesOutOfRangeAreCountedAtTheEnds) {
  Histogram h;
  h.add(-5);
  h.add(std::int64_t{1} << 50);
  EXPECT_EQ(h.in_bin(0), 1u);
  EXPECT_EQ(h.in_bin(Histogram::num_bins - 1), 1u);
  EXPECT_EQ(h.max(), std::int64_t{1} << 50);
}

TEST(Histogram, EmptyIsZero) {
  const Histogram h;
  EXPECT_EQ(h.count(), 0u);
  EXPECT_EQ(h.percentile(0.99), 0);
}

}  // namespace
}  // namespace godobject::test_histogram
