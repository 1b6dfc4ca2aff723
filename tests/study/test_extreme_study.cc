// Maps of extremes and random scenes: contents of a cell, and one scene per seed.
#include <gtest/gtest.h>

#include <limits>

#include "tests/study/extreme/study.h"
#include "tests/study/random_study.h"

namespace godobject::study::test_extreme_study {
namespace {

ExtremeMap small_map() {
  return {.name = "small",
          .about = "a map of this test",
          .measure = "nothing",
          .limit = 10,
          .panels = {"panel", {1, 2}},
          .rows = {"row", {1, 10}},
          .columns = {"column", {1, 2, 3}},
          .draws = 4};
}

TEST(ExtremeStudy, ACellIsTheWorstOfItsDraws) {
  ExtremeMap map = small_map();
  fill(
      map, "an integrator",
      [](double panel, double row, double column, unsigned seed) {
        return seed == 2 ? panel * row * column : 0;
      },
      [](const std::string&) {});
  ASSERT_EQ(map.cells.size(), 12u);
  std::size_t red = 0;
  for (const ExtremeCell& c : map.cells) {
    EXPECT_EQ(c.integrator, "an integrator");
    EXPECT_EQ(c.worst, c.panel * c.row * c.column);
    EXPECT_EQ(c.worst_draw, 2u);
    red += map.is_red(c);
  }
  EXPECT_EQ(red, 5u);  // 20, 30, 20, 40, 60
  EXPECT_EQ(map.cells[1].column, 2) << "the last is the quickest";
  EXPECT_EQ(map.cells[3].row, 10);
  EXPECT_EQ(map.cells[6].panel, 2);
}

TEST(ExtremeStudy, WhatFailsIsRed) {
  ExtremeMap map = small_map();
  for (const double bad :
       {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()}) {
    map.cells.clear();
    fill(
        map, "an integrator", [bad](double, double, double, unsigned) { return bad; },
        [](const std::string&) {});
    for (const ExtremeCell& c : map.cells) EXPECT_TRUE(map.is_red(c)) << bad;
  }
}

TEST(RandomStudy, ASeedIsOneScene) {
  for (const std::string& kind : random_kinds()) {
    const ReferenceScene a = random_scene(kind, 1), again = random_scene(kind, 1), b = random_scene(kind, 2);
    EXPECT_EQ(a.problem.bodies.back().I_B, again.problem.bodies.back().I_B) << kind;
    EXPECT_NE(a.problem.bodies.back().I_B, b.problem.bodies.back().I_B) << kind;
    EXPECT_EQ(a.is_articulated(), kind == "chain" || kind == "top");
  }
}

}  // namespace
}  // namespace godobject::study::test_extreme_study
