// A bounded queue from one thread to one other thread, without locks: how records leave the real-time thread.
#pragma once

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace godobject {

/// One thread pushes, one other thread pops. A record that finds the ring full is lost and counted. Taking a
/// record over from another must not allocate: it owns nothing, or storage that all records of the ring have
/// alike.
template <class T>
class Ring {
  static_assert(std::atomic<std::size_t>::is_always_lock_free);

 public:
  /// Room for at least this many records, all like `like`. Allocates, and touches all of it; nothing later
  /// does.
  explicit Ring(std::size_t capacity, const T& like = {})
      : slots_(std::bit_ceil(capacity), like), mask_(slots_.size() - 1) {}

  std::size_t capacity() const noexcept { return slots_.size(); }

  /// Producer. False, and counted, when the ring is full.
  bool try_push(const T& record) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == slots_.size()) {
      lost_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[head & mask_] = record;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Consumer. False when the ring is empty.
  bool try_pop(T& record) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) == tail) return false;
    record = slots_[tail & mask_];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Records lost because the ring was full. Any thread.
  std::uint64_t lost() const noexcept { return lost_.load(std::memory_order_relaxed); }

 private:
  // The two ends count up and wrap at the size of their type; each on its own cache line.
  static constexpr std::size_t cache_line = 64;
  std::vector<T> slots_;
  std::size_t mask_;
  alignas(cache_line) std::atomic<std::size_t> head_{0};
  alignas(cache_line) std::atomic<std::size_t> tail_{0};
  alignas(cache_line) std::atomic<std::uint64_t> lost_{0};
};

}  // namespace godobject
