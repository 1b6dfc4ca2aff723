// What is left to do when the program dies: frames that switch the motors off, encoded beforehand and written by the
// handler of the deadly signal. Process-wide, for one rig at a time.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace godobject {

/// The rest of a line that a short write has cut off: on a bus of lines the last frames come after it. Stored
/// by the thread that writes, within a BusWrite; read by the last resort.
class LineRest {
 public:
  void store(std::string_view rest) noexcept {
    size_ = 0;
    const std::size_t size = std::min(rest.size(), text_.size());
    std::copy_n(rest.begin(), size, text_.begin());
    size_ = size;
  }
  std::string_view text() const noexcept { return {text_.data(), size_.load()}; }

 private:
  std::array<char, 64> text_{};
  std::atomic<std::size_t> size_{0};
  static_assert(std::atomic<std::size_t>::is_always_lock_free, "read in a signal handler");
};

/// The last frames on one bus: where to write, and what, in this order. One write each: a frame is one message on a CAN
/// socket.
struct LastWords {
  int descriptor = -1;  // non-blocking; -1: the bus is closed, nothing is written
  std::vector<std::string> writes;
  const LineRest* rest = nullptr;  // written first; null: the bus has no lines
};

/// While it lives, its words are written when the process dies by a signal that announces a defect (SIGABRT,
/// SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGSYS, SIGTRAP) or by std::terminate. One at a time.
class LastResort {
 public:
  explicit LastResort(std::vector<LastWords> buses);
  ~LastResort();
  LastResort(const LastResort&) = delete;
  LastResort& operator=(const LastResort&) = delete;

  /// Installs the handlers, for the rest of the process. Without words they only say which signal it was.
  static void install();

 private:
  std::vector<LastWords> buses_;
};

/// A stack for handlers of signals, for the thread that makes it: one whose own stack has overflowed has no other. Out of
/// memory there is none, and the handlers run on the thread's own.
class SignalStack {
 public:
  SignalStack() noexcept;
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<char[]> memory_;
};

/// Around every write to a bus: once the last words are being written, nothing else is.
class BusWrite {
 public:
  BusWrite() noexcept { writing_.fetch_add(1); }
  ~BusWrite() { writing_.fetch_sub(1); }
  BusWrite(const BusWrite&) = delete;
  BusWrite& operator=(const BusWrite&) = delete;

  bool allowed() const noexcept { return !ended_.load(); }

  /// For the last resort: no write begins any more. False: that was so already.
  static bool end() noexcept { return !ended_.exchange(true); }
  static bool none_is_going_on() noexcept { return writing_.load() == 0; }

 private:
  static inline std::atomic<int> writing_{0};
  static inline std::atomic<bool> ended_{false};
  static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
                "read in a signal handler");
};

}  // namespace godobject
