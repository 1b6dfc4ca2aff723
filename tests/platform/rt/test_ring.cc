// The ring: order, fullness, and two threads. Run with ThreadSanitizer by the tsan preset.
#include "platform/rt/ring.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "tests/support/allocation_guard.h"

namespace godobject::test_ring {
namespace {

struct Record {
  std::uint64_t number = 0;
  std::uint64_t complement = 0;  // ~number: detects a torn record
};

TEST(Ring, KeepsOrderAndCountsWhatItCannotTake) {
  Ring<Record> ring(3);
  ASSERT_EQ(ring.capacity(), 4u);
  for (std::uint64_t i = 0; i < 6; ++i) EXPECT_EQ(ring.try_push({i, ~i}), i < 4);
  EXPECT_EQ(ring.lost(), 2u);
  Record record;
  for (std::uint64_t i = 0; i < 4; ++i) {
    ASSERT_TRUE(ring.try_pop(record));
    EXPECT_EQ(record.number, i);
  }
  EXPECT_FALSE(ring.try_pop(record));
  EXPECT_TRUE(ring.try_push({7, ~std::uint64_t{7}}));
  ASSERT_TRUE(ring.try_pop(record));
  EXPECT_EQ(record.number, 7u);
}

TEST(Ring, PopsIntoARecordOfItsOwnWithoutAllocating) {
  if (!AllocationGuard::works()) GTEST_SKIP() << "the sanitizer owns the allocator";
  Ring<std::vector<int>> ring(2, std::vector<int>(100, 0));
  ASSERT_TRUE(ring.try_push(std::vector<int>(100, 7)) && ring.try_push(std::vector<int>(100, 8)));
  std::vector<int> record = ring.record(), small;
  AllocationGuard guard;
  ASSERT_TRUE(ring.try_pop(record));
  EXPECT_EQ(guard.heap_calls(), 0);
  ASSERT_TRUE(ring.try_pop(small));
  EXPECT_GT(guard.heap_calls(), 0) << "a record of another size does";
  guard.disarm();
  EXPECT_EQ(record[99], 7);
  EXPECT_EQ(small[99], 8);
}

TEST(Ring, BetweenTwoThreadsNothingIsTornReorderedOrLostUncounted) {
  constexpr std::uint64_t num_records = 200'000;
  Ring<Record> ring(64);
  std::atomic<bool> ended{false};
  std::thread producer([&] {
    for (std::uint64_t i = 1; i <= num_records; ++i) ring.try_push({i, ~i});
    ended.store(true, std::memory_order_release);
  });
  std::uint64_t received = 0, last = 0, wrong = 0;
  Record record;
  for (bool more = true; more;) {
    more = !ended.load(std::memory_order_acquire);
    while (ring.try_pop(record)) {
      ++received;
      if (record.complement != ~record.number || record.number <= last) ++wrong;
      last = record.number;
    }
  }
  producer.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(received, 0u);
  EXPECT_EQ(received + ring.lost(), num_records);
}

}  // namespace
}  // namespace godobject::test_ring
