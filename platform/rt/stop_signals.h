// Effect of every signal: ends the run, is ignored, or ends the process after the last frames.
#pragma once

#include <atomic>
#include <csignal>
#include <span>
#include <string_view>

#include "platform/rt/last_resort.h"

namespace godobject {

enum class SignalFate : std::uint8_t {
  stop,         // a request: torque runs down, drives off, files complete, summary
  ignored,      // reported instead as the error of the write that caused it
  last_resort,  // a defect: platform/rt/last_resort.h
};

struct SignalRow {
  int signal = 0;
  std::string_view name;  // "SIGINT"
  SignalFate fate = SignalFate::stop;
};

/// Lists every signal that can be caught and that ends or suspends a process by default. Real-time signals
/// have no names and are not listed; they have the fate `stop`.
std::span<const SignalRow> signal_rows() noexcept;

/// Protects the process to its end, for the verbs that command or simulate motors. A dead terminal, a pipe
/// without a reader and a limit on file sizes no longer end it, and a defect switches the motors off.
void guard_process();

/// Blocks the stop signals in the calling thread, so that other threads receive them. Deadly signals still
/// reach the last resort.
void block_stop_signals() noexcept;

/// Setup of every thread but the main one, from its start to its end.
/// It sets the name, the signals as by block_stop_signals(), and a stack for the last resort.
class ThreadSetup {
 public:
  /// name: at most 15 characters, as in `ps -T` and the table of threads in docs/running.md.
  explicit ThreadSetup(const char* name) noexcept;

 private:
  SignalStack stack_;
};

/// Policy for Ctrl-Z: a process that commands motors must not be suspended, because its drives would lose
/// their host.
enum class Suspension : std::uint8_t { allowed, stops };

/// Catches signals with the fate `stop` as long as this object exists. The first sets requested(), further
/// ones insisted(). The destructor restores the former handlers. A hang-up that was ignored already (nohup)
/// stays ignored. One at a time.
class StopSignals {
 public:
  explicit StopSignals(Suspension suspension = Suspension::allowed) noexcept;
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  const std::atomic<bool>& requested() const noexcept { return requested_; }
  const std::atomic<bool>& insisted() const noexcept { return insisted_; }
  /// Requests a stop from inside the program, as a signal would.
  void request() const noexcept { requested_ = true; }
  /// Name of the first signal, "SIGINT"; empty if none came.
  std::string_view name() const noexcept;

  static constexpr std::size_t max_signals = 64;

 private:
  static void on_signal(int signal);

  static inline std::atomic<bool> requested_{false}, insisted_{false};
  static inline std::atomic<int> signal_{0};
  static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
                "set in a signal handler");
  struct sigaction former_[max_signals] {};  // former actions of the signals of signal_rows()
  bool caught_[max_signals]{};
};

}  // namespace godobject
