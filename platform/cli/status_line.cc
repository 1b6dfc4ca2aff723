#include "platform/cli/status_line.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>

namespace godobject {

StatusLine::StatusLine(BackgroundFile& console) noexcept
    : console_(console),
      terminal_(isatty(STDERR_FILENO) == 1),
      interval_s_(terminal_ ? 0.2 : 1.0),
      due_s_(interval_s_) {}

void StatusLine::update(const CycleRecord& record, Nanoseconds wake_ns) {
  worst_wake_us_ = std::max(worst_wake_us_, 1e-3 * static_cast<double>(wake_ns));
  constexpr double rounding = 1e-9;
  if (record.t < due_s_ - rounding) return;
  show(record);
  worst_wake_us_ = 0;
  due_s_ += interval_s_;
}

void StatusLine::show(const CycleRecord& record) {
  const bool fault = any(record.fault) || any(record.rig_faults);
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(),
                "%st %7.2f s   wake-up <= %6.0f us   following %7.3f mm %7.4f rad   energy %8.2e J   %s%s",
                terminal_ ? "\r" : "", record.t, worst_wake_us_, 1e3 * record.following.m,
                record.following.rad, record.energy, fault ? "FAULT" : "ok", terminal_ ? "\033[K" : "\n");
  static_cast<void>(console_.write(line.data()));
}

void StatusLine::end() {
  if (terminal_) static_cast<void>(console_.write("\n"));
}

}  // namespace godobject
