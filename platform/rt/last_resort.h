// Last frames of a dying program: they switch the motors off, are encoded beforehand and written by the
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

/// Rest of a line that a short write cut off, for buses of text lines: the last frames follow it. The writing
/// thread stores it within a BusWrite; the last resort reads it.
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

/// Last frames on one bus, in the order of writing. Each is one write, because a write to a CAN socket is one
/// frame.
struct LastWords {
  int descriptor = -1;  // non-blocking; -1: the bus is closed, nothing is written
  std::vector<std::string> writes;
  const LineRest* rest = nullptr;  // written first; null: the bus has no lines
};

/// Writes its frames if the process dies by a defect, as long as this object exists. A defect is SIGABRT,
/// SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGSYS, SIGTRAP or std::terminate. One at a time.
class LastResort {
 public:
  explicit LastResort(std::vector<LastWords> buses);
  ~LastResort();
  LastResort(const LastResort&) = delete;
  LastResort& operator=(const LastResort&) = delete;

  /// Installs the handlers, for the rest of the process. Without frames they only report the signal.
  static void install();

 private:
  std::vector<LastWords> buses_;
};

/// A stack for signal handlers of the constructing thread, needed if the thread's own stack overflows. Out of
/// memory, handlers run on the thread's own stack.
class SignalStack {
 public:
  SignalStack() noexcept;
  ~SignalStack();
  SignalStack(const SignalStack&) = delete;
  SignalStack& operator=(const SignalStack&) = delete;

 private:
  std::unique_ptr<char[]> memory_;
};

/// Guards every write to a bus: once the last frames are being written, no other write begins.
class BusWrite {
 public:
  BusWrite() noexcept { writing_.fetch_add(1); }
  ~BusWrite() { writing_.fetch_sub(1); }
  BusWrite(const BusWrite&) = delete;
  BusWrite& operator=(const BusWrite&) = delete;

  bool allowed() const noexcept { return !ended_.load(); }

  /// For the last resort: forbids further writes. Returns false if they were forbidden already.
  static bool end() noexcept { return !ended_.exchange(true); }
  static bool none_is_going_on() noexcept { return writing_.load() == 0; }

 private:
  static inline std::atomic<int> writing_{0};
  static inline std::atomic<bool> ended_{false};
  static_assert(std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
                "read in a signal handler");
};

}  // namespace godobject
