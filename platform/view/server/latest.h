// Latest value from one thread to another, on request: without a request the writer copies nothing.
#pragma once

#include <atomic>
#include <cstdint>

namespace godobject {

/// Both ends are wait-free. The one slot belongs to the reader until its request, then to the writer until
/// give().
template <class T>
class Latest {
  static_assert(std::atomic<bool>::is_always_lock_free);

 public:
  /// like: any value; later ones have storage of the same size, so that assigning does not allocate.
  explicit Latest(const T& like) : value_(like) {}

  /// For the writer: true if the slot is the writer's and must be filled.
  bool wanted() const noexcept { return requested_.load(std::memory_order_acquire); }
  /// For the writer, until give().
  T& slot() noexcept { return value_; }
  void give() noexcept { requested_.store(false, std::memory_order_release); }

  /// For the reader: requests the next value. The result of get() belongs to the writer from here on.
  void ask() noexcept {
    any_ = true;
    requested_.store(true, std::memory_order_release);
  }
  /// For the reader: returns the requested value; null while there is none.
  const T* get() const noexcept {
    return any_ && !requested_.load(std::memory_order_acquire) ? &value_ : nullptr;
  }

 private:
  T value_;
  bool any_ = false;  // the reader's
  std::atomic<bool> requested_{false};
};

}  // namespace godobject
