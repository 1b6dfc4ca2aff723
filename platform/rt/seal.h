// Seal of the loop's thread: a seccomp filter that lets through the system calls of the loop alone. It traps
// and names every other.
#pragma once

#include <atomic>
#include <csignal>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "platform/rt/setup.h"

namespace godobject {

/// A system call that the seal lets through.
struct LoopCall {
  int number = 0;
  std::string_view name, purpose;
};

/// Lists the system calls of the loop's thread. The table of docs/threads.md is the same (tested).
std::span<const LoopCall> loop_calls() noexcept;

/// Name of a system call of this machine; "system call" if it is none that loops are known to make.
std::string_view name_of_call(int number) noexcept;

/// Refuses system calls that are not in loop_calls(). They fail with EPERM, and the first one is stored. One
/// at a time, because the handler of SIGSYS is one of the process.
class Seal {
 public:
  Seal() noexcept;
  ~Seal();
  Seal(const Seal&) = delete;
  Seal& operator=(const Seal&) = delete;

  /// Returns why no thread can be sealed on this machine, with the remedy; empty if one can. Starts a thread.
  static std::string why_not();
  /// Seals the calling thread for the rest of its life.
  RtStep close();
  /// Ends the count of refused calls, because the loop has ended. The thread can then only end.
  void loop_ended() noexcept { is_counting_ = false; }

  /// True once a call was refused. For any thread.
  bool is_broken() const noexcept { return num_refused_.load(std::memory_order_relaxed) > 0; }
  std::uint64_t num_refused() const noexcept { return num_refused_; }
  /// Returns "the loop called openat (257), which the seal refuses"; empty if no call was refused.
  std::string text() const;

 private:
  static void on_refused(int signal, siginfo_t* info, void* context);

  static inline std::atomic<bool> is_counting_{false};
  static inline std::atomic<int> first_{-1};
  static inline std::atomic<std::uint64_t> num_refused_{0};
  static inline struct sigaction former_ {};
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free, "set in a signal handler");
};

}  // namespace godobject
