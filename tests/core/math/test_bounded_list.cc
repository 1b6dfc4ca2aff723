// A list that keeps the deepest when not all can be kept.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/math/bounded_list.h"
#include "tests/core/one_body.h"

namespace godobject::test_bounded_list {
namespace {

struct Item {
  int key = 0, depth = 0;
  static bool comes_before(const Item& a, const Item& b) noexcept { return a.key < b.key; }
  static bool is_deeper(const Item& a, const Item& b) noexcept {
    return a.depth != b.depth ? a.depth > b.depth : comes_before(a, b);
  }
};
constexpr std::size_t max_items = 20;
using List = BoundedList<Item, max_items, Item::is_deeper, Item::comes_before>;

/// Keeps the first of equal depths, all in order.
TEST(BoundedList, KeepsTheDeepestInOrder) {
  Random random(1);
  for (int n = 0; n < 500; ++n) {
    const int size = random.integer(0, 60);
    List list;
    std::vector<Item> all;
    for (int key = 0; key < size; ++key) {
      all.push_back({.key = key, .depth = random.integer(0, 9)});
      list.add(all.back());
    }
    list.put_in_order();
    EXPECT_EQ(list.full(), all.size() > max_items);
    EXPECT_EQ(list.num_found, all.size());
    std::sort(all.begin(), all.end(), Item::is_deeper);
    all.resize(std::min(all.size(), max_items));
    std::sort(all.begin(), all.end(), Item::comes_before);
    ASSERT_EQ(list.size, all.size());
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(list.list[i].key, all[i].key);
  }
}

TEST(BoundedList, ForgetsWhatWasAddedSince) {
  List list;
  for (int key = 0; key < 9; ++key) list.add({.key = key, .depth = 1});
  list.forget_from(4);
  EXPECT_EQ(list.size, 4u);
  EXPECT_EQ(list.num_found, 4u);
  for (int key = 9; key < 40; ++key) list.add({.key = key, .depth = 2});
  const std::size_t found = list.num_found;
  list.forget_from(4);  // a full list has lost some already
  EXPECT_EQ(list.size, max_items);
  EXPECT_EQ(list.num_found, found);
}

/// An item that a full list could not remove may be added once more.
TEST(BoundedList, HoldsNoneTwice) {
  Random random(2);
  for (int n = 0; n < 200; ++n) {
    List list;
    for (int key = 0; key < 30; ++key) list.add({.key = key, .depth = random.integer(0, 9)});
    list.forget_from(0);
    for (int key = 20; key < 30; ++key) list.add({.key = key, .depth = random.integer(0, 9)});
    list.put_in_order();
    EXPECT_TRUE(list.full());
    for (std::size_t i = 1; i < list.size; ++i) EXPECT_LT(list.list[i - 1].key, list.list[i].key);
  }
}

}  // namespace
}  // namespace godobject::test_bounded_list
