// SIGINT and SIGTERM end a run cleanly: the summary is printed and the files are complete.
#pragma once

#include <atomic>
#include <csignal>

namespace godobject {

/// While it lives, the signals set requested(); at its end the former handlers are back. One at a time.
class StopSignals {
 public:
  StopSignals() noexcept {
    requested_ = false;
    struct sigaction action {};
    action.sa_handler = [](int) { requested_ = true; };
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

 private:
  static inline std::atomic<bool> requested_{false};
  static_assert(std::atomic<bool>::is_always_lock_free, "set in a signal handler");
  struct sigaction former_int_ {
  }, former_term_{};
};

}  // namespace godobject
