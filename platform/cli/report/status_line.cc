#include "platform/cli/report/status_line.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "platform/cli/report/statistics.h"

namespace godobject {

StatusLine::StatusLine(BackgroundFile& console, bool quiet) noexcept
    : console_(console),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      interval_s_(terminal_ ? 0.2 : 1.0),
      due_s_(interval_s_) {}

void StatusLine::update(const CycleRecord& record, Nanoseconds wake_ns) {
  worst_wake_us_ = std::max(worst_wake_us_, 1e-3 * static_cast<double>(wake_ns));
  ++cycles_;
  if (record.on_hold) ++held_;
  if (record.on_hold != on_hold_) print_hold(record);
  constexpr double rounding = 1e-9;
  if (quiet_ || record.t < due_s_ - rounding) return;
  show(record);
  worst_wake_us_ = 0;
  due_s_ += interval_s_;
}

void StatusLine::show(const CycleRecord& record) {
  const bool fault = any(record.fault) || any(record.rig_faults);
  const double held_percent = 100 * static_cast<double>(held_) / static_cast<double>(cycles_);
  std::array<char, 24> state{};
  if (held_percent > 100 * RunStatistics::max_held)
    std::snprintf(state.data(), state.size(), "%sHELD %.0f %%", fault ? "FAULT, " : "", held_percent);
  else std::snprintf(state.data(), state.size(), "%s", fault ? "FAULT" : "ok");
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(),
                "%st %7.2f s   wake-up <= %6.0f us   following %7.3f mm %7.4f rad   energy %8.2e J   %s%s",
                terminal_ ? "\r" : "", record.t, worst_wake_us_, 1e3 * record.following.m,
                record.following.rad, record.energy.total, state.data(), terminal_ ? "\033[K" : "\n");
  static_cast<void>(console_.write(line.data()));
}

/// Prints the begin or end of a hold at once.
void StatusLine::print_hold(const CycleRecord& record) {
  on_hold_ = record.on_hold;
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), "%st %7.3f s   deadlines: %s%s\n", terminal_ ? "\r" : "", record.t,
                on_hold_ ? "5 or more missed within 100 ms: the pose is held, the force fades"
                         : "kept for 100 ms: the force returns by the ramp",
                terminal_ ? "\033[K" : "");
  static_cast<void>(console_.write(line.data()));
}

void StatusLine::end() {
  if (terminal_ && !quiet_) static_cast<void>(console_.write("\n"));
}

FastProgress::FastProgress(BackgroundFile& console, double duration_s, bool quiet) noexcept
    : console_(console), wanted_(!quiet && isatty(STDERR_FILENO) == 1), duration_s_(duration_s) {}

void FastProgress::update(double t_s, Nanoseconds now) {
  constexpr Nanoseconds first_after = 1'000'000'000, interval = 200'000'000;
  if (!wanted_) return;
  if (start_ns_ == 0) {
    start_ns_ = now;
    due_ns_ = now + first_after;
  }
  if (now < due_ns_) return;
  due_ns_ = now + interval;
  shown_ = true;
  const double taken_s = 1e-9 * static_cast<double>(now - start_ns_);
  const double left_s = t_s > 0 ? taken_s * (duration_s_ - t_s) / t_s : 0;
  std::array<char, 120> line{};
  std::snprintf(line.data(), line.size(), "\rt %.2f of %.2f s (%.0f %%), about %.0f s left\033[K", t_s,
                duration_s_, 100 * t_s / duration_s_, left_s);
  static_cast<void>(console_.write(line.data()));
}

void FastProgress::end() {
  if (shown_) static_cast<void>(console_.write("\r\033[K"));
}

}  // namespace godobject
