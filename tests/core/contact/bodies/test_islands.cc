// Bodies that touch fall into islands.
#include <gtest/gtest.h>

#include "tests/core/contact/bodies/bricks.h"

namespace godobject::test_islands {
namespace {

constexpr std::size_t max_bodies = 24, max_pairs = 60;
using Graph = TouchingGraph<max_bodies, max_pairs>;

/// Any pairs between any bodies: each island contains all bodies joined by its pairs, and no others.
TEST(Islands, HoldWhatPairsJoin) {
  Random random(6);
  for (int n = 0; n < 200; ++n) {
    auto graph = std::make_unique<Graph>();
    std::array<bool, max_bodies> touches;
    std::array<std::size_t, max_bodies> label;  // of joined bodies, by a plain method
    for (std::size_t i = 0; i < max_bodies; ++i) {
      touches[i] = random.integer(0, 4) > 0;
      label[i] = i;
    }
    graph->num_pairs = 0;
    for (int k = random.integer(0, 30); k > 0; --k) {
      const auto a = static_cast<std::uint32_t>(random.integer(1, max_bodies - 1));
      const auto b = static_cast<std::uint32_t>(random.integer(0, static_cast<int>(a) - 1));
      TouchingPair& pair = graph->pairs[graph->num_pairs++];
      pair.child = a;
      pair.parent = b;
      touches[a] = touches[b] = true;
      std::replace(label.begin(), label.end(), std::size_t(label[a]), std::size_t(label[b]));
    }
    make_islands(touches, max_bodies, *graph, []() noexcept {});
    std::size_t bodies = 0, pairs = 0;
    std::vector<std::size_t> labels;
    for (std::size_t k = 0; k < graph->num_islands; ++k) {
      const Island& island = graph->islands[k];
      EXPECT_EQ(island.first_body, bodies);
      EXPECT_EQ(island.first_pair, pairs);
      ASSERT_LT(island.first_body, island.end_body);
      const std::size_t its_label = label[graph->order[island.first_body]];
      EXPECT_EQ(std::count(labels.begin(), labels.end(), its_label), 0);
      labels.push_back(its_label);
      graph->each_body(island, [&](std::uint32_t i, const TouchingContacts&) {
        EXPECT_TRUE(touches[i]);
        EXPECT_EQ(label[i], its_label);
      });
      graph->each_pair(island, [&](const TouchingPair& pair) { EXPECT_EQ(label[pair.child], its_label); });
      bodies = island.end_body;
      pairs = island.end_pair;
    }
    EXPECT_EQ(bodies, static_cast<std::size_t>(std::count(touches.begin(), touches.end(), true)));
    EXPECT_EQ(pairs, graph->num_pairs);
  }
}

}  // namespace
}  // namespace godobject::test_islands
