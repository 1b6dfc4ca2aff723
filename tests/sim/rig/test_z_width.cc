// The Z-width map at the places that docs/theory/passivity.md publishes.
#include <gtest/gtest.h>

#include "tests/support/z_width.h"

namespace godobject::test_z_width {
namespace {

TEST(ZWidth, WallsOfThePublishedPlaces) {
  for (const ZWidthPlace& place : z_width_places()) {
    const ZWidthRow row = z_width_row(place);
    const auto at = testing::Message() << place.damping << " N s/m, delay " << place.delay << ", count "
                                       << place.count << " m, " << place.period_s << " s";
    EXPECT_LE(row.spring, 2 * place.colgate()) << at;
    EXPECT_GE(row.controlled, 20e3) << at;
    EXPECT_EQ(row.laws.front(), row.spring) << at;  // the proxy is the sampled spring
    EXPECT_GE(row.laws.back(), 1.5 * row.spring) << at;
  }
}

}  // namespace
}  // namespace godobject::test_z_width
