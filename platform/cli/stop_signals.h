// SIGINT and SIGTERM end a run cleanly: the summary is printed and the files are complete.
#pragma once

#include <atomic>
#include <csignal>
#include <string_view>

namespace godobject {

/// While it lives, the signals set requested(); at its end the former handlers are back. One at a time.
class StopSignals {
 public:
  StopSignals() noexcept {
    requested_ = false;
    signal_ = 0;
    struct sigaction action {};
    action.sa_handler = [](int signal) {
      signal_ = signal;
      requested_ = true;
    };
    sigaction(SIGINT, &action, &former_int_);
    sigaction(SIGTERM, &action, &former_term_);
  }
  ~StopSignals() {
    sigaction(SIGINT, &former_int_, nullptr);
    sigaction(SIGTERM, &former_term_, nullptr);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  const std::atomic<bool>& requested() const noexcept { return requested_; }
  /// "SIGINT" or "SIGTERM", whichever came last; empty where none has come.
  std::string_view name() const noexcept {
    if (!requested_) return "";
    return signal_ == SIGINT ? "SIGINT" : "SIGTERM";
  }

 private:
  static inline std::atomic<bool> requested_{false};
  static inline std::atomic<int> signal_{0};
  static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
                "set in a signal handler");
  struct sigaction former_int_ {
  }, former_term_{};
};

}  // namespace godobject
