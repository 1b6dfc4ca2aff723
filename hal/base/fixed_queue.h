// First-in first-out queue with storage in place.
#pragma once

#include <array>
#include <cstddef>

namespace godobject {

template <class T, std::size_t N>
class FixedQueue {
 public:
  /// Appends a value. Returns false and stores nothing if the queue is full.
  [[nodiscard]] bool push(const T& value) noexcept {
    if (size_ == N) return false;
    items_[(first_ + size_) % N] = value;
    ++size_;
    return true;
  }

  /// Returns the oldest value. The queue must not be empty, as for pop().
  const T& front() const noexcept { return items_[first_]; }
  void pop() noexcept {
    first_ = (first_ + 1) % N;
    --size_;
  }

  /// index: 0 is the oldest; below size().
  T& operator[](std::size_t index) noexcept { return items_[(first_ + index) % N]; }

  bool empty() const noexcept { return size_ == 0; }
  std::size_t size() const noexcept { return size_; }
  void clear() noexcept { size_ = 0; }

 private:
  std::array<T, N> items_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace godobject
