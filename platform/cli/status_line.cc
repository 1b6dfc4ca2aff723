#include "platform/cli/status_line.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace godobject {

StatusLine::StatusLine() noexcept
    : terminal_(isatty(STDERR_FILENO) == 1), interval_s_(terminal_ ? 0.2 : 1.0), due_s_(interval_s_) {}

void StatusLine::update(const CycleRecord& record, Nanoseconds wake_ns) {
  worst_wake_us_ = std::max(worst_wake_us_, 1e-3 * static_cast<double>(wake_ns));
  if (record.on_hold != on_hold_) say(record);
  constexpr double rounding = 1e-9;
  if (record.t < due_s_ - rounding) return;
  show(record);
  worst_wake_us_ = 0;
  due_s_ += interval_s_;
}

void StatusLine::show(const CycleRecord& record) {
  const bool fault = any(record.fault) || any(record.rig_faults);
  std::fprintf(stderr,
               "%st %7.2f s   wake-up <= %6.0f us   following %7.3f mm %7.4f rad   energy %8.2e J   %s%s",
               terminal_ ? "\r" : "", record.t, worst_wake_us_, 1e3 * record.following.m,
               record.following.rad, record.energy, fault ? "FAULT" : "ok", terminal_ ? "\033[K" : "\n");
  std::fflush(stderr);
}

/// What is said at once.
void StatusLine::say(const CycleRecord& record) {
  on_hold_ = record.on_hold;
  std::fprintf(stderr, "%st %7.3f s   deadlines: %s%s\n", terminal_ ? "\r" : "", record.t,
               on_hold_ ? "5 or more were missed within 100 ms: the pose is held, the force fades"
                        : "kept again for 100 ms: the force comes back by the ramp",
               terminal_ ? "\033[K" : "");
  std::fflush(stderr);
}

void StatusLine::end() {
  if (terminal_) std::fputc('\n', stderr);
}

}  // namespace godobject
