// The fate of every signal: which of them end a run, which are ignored, and which leave time for last words only.
#pragma once

#include <atomic>
#include <csignal>
#include <span>
#include <string_view>

#include "platform/rt/last_resort.h"

namespace godobject {

enum class SignalFate : std::uint8_t {
  stop,         // a request: torque runs down, drives off, files complete, summary
  ignored,      // what it announces becomes the error of a write, and that of a file is reported
  last_resort,  // a defect: platform/rt/last_resort.h
};

struct SignalRow {
  int signal = 0;
  std::string_view name;  // "SIGINT"
  SignalFate fate = SignalFate::stop;
};

/// Every signal that can be caught and whose default action would end or suspend the process; real-time signals, which
/// have no names, have the fate `stop` too.
std::span<const SignalRow> signal_rows() noexcept;

/// For the verbs that command motors or play them: from now on a dead terminal, a pipe without a reader and a limit on
/// the size of files end nothing, and a defect of the program switches the motors off. To the end of the process.
void guard_process();

/// In the thread that calls it: the stop signals are taken by the others, and the deadly ones reach the last resort.
void block_stop_signals() noexcept;

/// Set-up of every thread beside the main one, at its begin and as long as it runs: its name, signals as block_stop_signals(), and
/// a stack on which the last resort runs.
class ThreadSetup {
 public:
  /// name: at most 15 characters, as `ps -T` and a table in docs/running.md have it.
  explicit ThreadSetup(const char* name) noexcept;

 private:
  SignalStack stack_;
};

/// Whether a process that commands motors may be suspended (Ctrl-Z): its drives would be without their host.
enum class Suspension : std::uint8_t { allowed, stops };

/// While it lives, signals whose fate is `stop` set requested(), and from the second on insisted(); at its end the
/// former handlers are back. A hang-up that was ignored already (nohup) stays so. One at a time.
class StopSignals {
 public:
  explicit StopSignals(Suspension suspension = Suspension::allowed) noexcept;
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  const std::atomic<bool>& requested() const noexcept { return requested_; }
  const std::atomic<bool>& insisted() const noexcept { return insisted_; }
  /// As a signal would: for what ends a run from inside.
  void request() const noexcept { requested_ = true; }
  /// "SIGINT", the one that came first; empty where none has come.
  std::string_view name() const noexcept;

  static constexpr std::size_t max_signals = 64;

 private:
  static void on_signal(int signal);

  static inline std::atomic<bool> requested_{false}, insisted_{false};
  static inline std::atomic<int> signal_{0};
  static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
                "set in a signal handler");
  struct sigaction former_[max_signals] {};  // of signal_rows()
  bool caught_[max_signals]{};
};

}  // namespace godobject
