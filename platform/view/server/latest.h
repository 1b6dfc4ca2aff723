// The latest value from one thread to one other, on request: the writer copies nothing that nobody has asked for.
#pragma once

#include <atomic>
#include <cstdint>

namespace godobject {

/// Both ends are wait-free. One slot, which belongs to the reader until it asks, then to the writer until it gives.
template <class T>
class Latest {
  static_assert(std::atomic<bool>::is_always_lock_free);

 public:
  /// like: any value; all later ones have storage like it, so that taking one over does not allocate.
  explicit Latest(const T& like) : value_(like) {}

  /// Writer: the slot is the writer's, to be filled.
  bool wanted() const noexcept { return asked_.load(std::memory_order_acquire); }
  /// Writer, while wanted().
  T& slot() noexcept { return value_; }
  void give() noexcept { asked_.store(false, std::memory_order_release); }

  /// Reader: the next value, please. What get() has returned is the writer's from here on.
  void ask() noexcept {
    any_ = true;
    asked_.store(true, std::memory_order_release);
  }
  /// Reader: the value that was asked for; null while there is none.
  const T* get() const noexcept {
    return any_ && !asked_.load(std::memory_order_acquire) ? &value_ : nullptr;
  }

 private:
  T value_;
  bool any_ = false;  // the reader's
  std::atomic<bool> asked_{false};
};

}  // namespace godobject
