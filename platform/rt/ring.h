// Bounded lock-free queue from one thread to another, for records of the real-time thread.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "platform/rt/loop_calls.h"

namespace godobject {

/// One thread pushes, one other thread pops. If the ring is full the record is lost and counted.
/// Assigning a record must not allocate: T owns no memory, or all records own the same amount.
template <class T>
class Ring {
  static_assert(std::atomic<std::size_t>::is_always_lock_free);

 public:
  /// capacity: minimum number of records. like: initial value of all slots. Allocates and touches all memory;
  /// the other functions do not allocate.
  explicit Ring(std::size_t capacity, const T& like = {})
      : slots_(std::bit_ceil(capacity), like), mask_(slots_.size() - 1) {}

  std::size_t capacity() const noexcept { return slots_.size(); }

  /// Returns a record like the slots, into which a record can be popped. Call before anything is pushed.
  T record() const { return slots_.front(); }

  /// For the producer. Returns false and counts a loss if the ring is full.
  bool try_push(const T& record) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == slots_.size()) {
      lost_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    loop::copy(slots_[head & mask_], record);
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// For the consumer. Returns false if the ring is empty.
  bool try_pop(T& record) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) == tail) return false;
    loop::copy(record, slots_[tail & mask_]);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Records lost because the ring was full. For any thread.
  std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  // Both ends count up and wrap at the size of their type; each is on its own cache line.
  static constexpr std::size_t cache_line = 64;
  std::vector<T> slots_;
  std::size_t mask_;
  alignas(cache_line) std::atomic<std::size_t> head_{0};
  alignas(cache_line) std::atomic<std::size_t> tail_{0};
  alignas(cache_line) std::atomic<std::uint64_t> lost_{0};
};

}  // namespace godobject
