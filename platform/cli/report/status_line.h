// Status line of a real-time run.
#pragma once

#include "hal/can/frame.h"
#include "platform/rt/background_file.h"
#include "platform/session/session.h"

namespace godobject {

/// Status line on standard error: on a terminal one line, redrawn five times a second; otherwise one line per
/// second. Lines are dropped if standard error is blocked.
class StatusLine {
 public:
  StatusLine(BackgroundFile& console, bool quiet) noexcept;

  /// Adds a cycle, and prints the line when it is due.
  void update(const CycleRecord& record, Nanoseconds wake_ns);
  /// Moves the terminal's cursor to a new line.
  void end();

 private:
  void show(const CycleRecord& record);
  void print_hold(const CycleRecord& record);

  BackgroundFile& console_;
  bool quiet_;
  bool terminal_;
  double interval_s_;
  double due_s_ = 0;          // time of the run, s
  bool on_hold_ = false;      // hold that was printed
  double worst_wake_us_ = 0;  // since the line was last printed
  std::uint64_t cycles_ = 0, held_ = 0;
};

/// Progress of a run on a simulated clock, shown on a terminal for runs longer than a second.
class FastProgress {
 public:
  FastProgress(BackgroundFile& console, double duration_s, bool quiet) noexcept;

  /// now: time of any monotonic clock, the same clock in every call.
  void update(double t_s, Nanoseconds now);
  /// Erases the line.
  void end();

 private:
  BackgroundFile& console_;
  bool wanted_;
  bool shown_ = false;
  double duration_s_;
  Nanoseconds start_ns_ = 0, due_ns_ = 0;
};

}  // namespace godobject
