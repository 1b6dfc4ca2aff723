// Groups of nodes and slots of springs: completeness, and rejected parameters.
#include <gtest/gtest.h>

#include <set>

#include "tests/core/net/net_scene.h"

namespace godobject::test_net_grouping {
namespace {

using Par = NetParams<64, 400>;

/// Nodes of up to three carriers, joined by so many springs drawn at random.
Par drawn_graph(unsigned seed) {
  Random random(seed);
  Par par;
  par.num_nodes = static_cast<std::size_t>(random.integer(1, 64));
  for (std::size_t n = 0; n < par.num_nodes; ++n) par.nodes[n] = {.m = 1, .body = 3 * n / par.num_nodes};
  std::set<std::pair<std::uint32_t, std::uint32_t>> joined;
  const auto last = static_cast<int>(par.num_nodes) - 1;
  for (int k = random.integer(0, 400); k > 0; --k) {
    const auto a = static_cast<std::uint32_t>(random.integer(0, last)),
               b = static_cast<std::uint32_t>(random.integer(0, last));
    if (a != b && joined.insert({std::min(a, b), std::max(a, b)}).second)
      par.springs[par.num_springs++] = {.i = a, .j = b, .k = 1};
  }
  put_in_order(par);
  return par;
}

TEST(NetGrouping, EveryNodeAndSpringIsInOne) {
  for (unsigned seed = 0; seed < 500; ++seed) {
    const Par par = drawn_graph(seed);
    ASSERT_TRUE(is_valid_net(par, 3)) << seed;
  }
}

TEST(NetGrouping, OfAChainAStarAndOfAllWithAllAreThere) {
  const auto is_valid = [](auto joins) {
    Par par;
    par.num_nodes = 28;
    for (std::size_t n = 0; n < par.num_nodes; ++n) par.nodes[n] = {.m = 1};
    for (std::uint32_t i = 0; i < par.num_nodes; ++i)
      for (std::uint32_t j = i + 1; j < par.num_nodes; ++j)
        if (joins(i, j)) par.springs[par.num_springs++] = {.i = i, .j = j, .k = 1};
    put_in_order(par);
    return is_valid_net(par, 0);
  };
  EXPECT_TRUE(is_valid([](std::uint32_t i, std::uint32_t j) { return j == i + 1; }));
  EXPECT_TRUE(is_valid([](std::uint32_t i, std::uint32_t) { return i == 0; }));
  EXPECT_TRUE(is_valid([](std::uint32_t, std::uint32_t) { return true; }));
}

TEST(NetGrouping, OfATubeAreFull) {
  auto run = std::make_unique<Running<NetScene<ImplicitEuler, 4, 1024, 3072>>>();
  add_tube(run->par, {.m = 1e-4, .k = 100}, 32, 32, 3e-3);
  const auto& par = run->par.net;
  ASSERT_EQ(par.num_nodes, 1024u);
  EXPECT_EQ(par.num_groups, 256u);
  EXPECT_LE(par.groups[par.num_groups - 1].end * 10, par.num_springs / 4 * 11);
}

TEST(NetGrouping, BadOnesAreRefused) {
  // one whose first group has two nodes or more, the first of them a spring
  const auto serves = [](const Par& par) {
    const NodeGroup& group = par.groups[0];
    return par.num_groups >= 4 && group.size >= 2 && group.first < group.end &&
           par.slots[group.first].springs[0] != par.no_spring;
  };
  unsigned seed = 0;
  while (!serves(drawn_graph(seed))) ++seed;
  const Par good = drawn_graph(seed);
  ASSERT_TRUE(is_valid_net(good, 3));
  const auto refused = [&](const char* what, auto change) {
    Par par = good;
    change(par);
    EXPECT_FALSE(is_valid_net(par, 3)) << what;
  };
  refused("two groups in the other order", [](Par& par) { std::swap(par.groups[0], par.groups[3]); });
  refused("a node twice", [](Par& par) { par.groups[0].nodes[1] = par.groups[0].nodes[0]; });
  refused("a node that is not there", [](Par& par) { par.groups[0].nodes[1] = 64; });
  refused("a group too few", [](Par& par) { --par.num_groups; });
  refused("a slot too many", [](Par& par) { ++par.groups[0].end; });
  refused("more than four nodes", [](Par& par) { par.groups[0].size = 5; });
  refused("a node in another place", [](Par& par) { par.places[par.groups[0].nodes[0]].lane = 1; });
  const std::uint32_t slot = good.groups[0].first;
  refused("no spring", [&](Par& par) { par.slots[slot].springs.fill(par.no_spring); });
  refused("a spring that is not there", [&](Par& par) { par.slots[slot].springs[0] = par.no_spring + 1; });
  refused("a spring to another node", [&](Par& par) { par.slots[slot].others[0] ^= 1; });
  refused("no_spring pulls", [](Par& par) { par.springs[par.no_spring].k = 1; });
}

}  // namespace
}  // namespace godobject::test_net_grouping
