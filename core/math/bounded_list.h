// List of fixed capacity. When full, it keeps the deepest items and reports the loss.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace godobject {

/// is_deeper(a, b): a is kept rather than b. comes_before(a, b): order of the list, in which nearly all items
/// are added. Both are total orders.
template <class Item, std::size_t max_items, bool (*is_deeper)(const Item&, const Item&) noexcept,
          bool (*comes_before)(const Item&, const Item&) noexcept>
struct BoundedList {
  std::array<Item, max_items> list;
  std::size_t size = 0;
  std::size_t num_found = 0;  // more than size: the list was full, and the deepest were kept

  bool in_order = true;   // true while items were added in order
  bool is_short = false;  // true if items were left out before they were added

  bool full() const noexcept { return is_short || has_overflowed(); }
  void clear() noexcept {
    size = num_found = 0;
    in_order = true;
    is_short = false;
  }
  void add(const Item& item) noexcept {
    ++num_found;
    if (size > 0) in_order = in_order && !comes_before(item, list[size - 1]);
    if (size < max_items) list[size++] = item;
    else put_in_place_of_shallowest(item);
  }
  /// Removes the items added since the size was `mark`. A full list keeps them.
  void forget_from(std::size_t mark) noexcept {
    if (!has_overflowed()) size = num_found = mark;
  }
  /// Replaces the shallowest item of a full list; the list is a heap until put_in_order(). Not inlined and by
  /// value: otherwise items of a list with room would also pass through memory.
  // NOLINTNEXTLINE(performance-unnecessary-value-param)
  [[gnu::noinline]] void put_in_place_of_shallowest(Item item) noexcept {
    if (num_found == max_items + 1) std::make_heap(list.begin(), list.end(), by_depth);
    if (!is_deeper(item, list.front())) return;
    std::pop_heap(list.begin(), list.end(), by_depth);
    list.back() = item;
    std::push_heap(list.begin(), list.end(), by_depth);
  }
  void put_in_order() noexcept {
    if (has_overflowed()) put_full_in_order();
    else if (!in_order) put_few_in_order();
  }

 private:
  // A function object, because the library would call is_deeper through a pointer (core/nonblocking.h).
  static constexpr auto by_depth = [](const Item& a, const Item& b) noexcept { return is_deeper(a, b); };

  bool has_overflowed() const noexcept { return num_found > size; }
  /// Sorts a full list. An item that could not be removed may have been added twice; the deeper of both is
  /// kept.
  [[gnu::noinline]] void put_full_in_order() noexcept {
    std::sort(list.begin(), list.end(), [](const Item& a, const Item& b) noexcept {
      return comes_before(a, b) || (!comes_before(b, a) && is_deeper(a, b));
    });
    const auto is_again = [](const Item& a, const Item& b) noexcept { return !comes_before(a, b); };
    size = static_cast<std::size_t>(std::unique(list.begin(), list.end(), is_again) - list.begin());
  }
  /// Sorts by insertion.
  void put_few_in_order() noexcept {
    for (std::size_t i = 1; i < size; ++i) {
      if (!comes_before(list[i], list[i - 1])) continue;
      const Item item = list[i];
      std::size_t to = i;
      for (; to > 0 && comes_before(item, list[to - 1]); --to) list[to] = list[to - 1];
      list[to] = item;
    }
  }
};

}  // namespace godobject
