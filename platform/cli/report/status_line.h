// The line a real-time run shows while it goes.
#pragma once

#include "hal/can/frame.h"
#include "platform/rt/background_file.h"
#include "platform/session/session.h"

namespace godobject {

/// On a terminal one line, redrawn five times a second; otherwise one line a second. To standard error; where that
/// takes nothing the lines are lost.
class StatusLine {
 public:
  StatusLine(BackgroundFile& console, bool quiet) noexcept;

  /// Takes note of a cycle, and shows it when it is time to.
  void update(const CycleRecord& record, Nanoseconds wake_ns);
  /// Leaves the terminal's cursor on a fresh line.
  void end();

 private:
  void show(const CycleRecord& record);
  void say(const CycleRecord& record);

  BackgroundFile& console_;
  bool quiet_;
  bool terminal_;
  double interval_s_;
  double due_s_ = 0;          // in the run's time
  bool on_hold_ = false;      // said
  double worst_wake_us_ = 0;  // since the line was last shown
  std::uint64_t cycles_ = 0, held_ = 0;
};

/// How far a run on a simulated clock has got: on a terminal alone, and only of a run that takes longer than a second.
class FastProgress {
 public:
  FastProgress(BackgroundFile& console, double duration_s, bool quiet) noexcept;

  /// now: of any monotonic clock, the same in every call.
  void update(double t_s, Nanoseconds now);
  /// Wipes the line away.
  void end();

 private:
  BackgroundFile& console_;
  bool wanted_;
  bool shown_ = false;
  double duration_s_;
  Nanoseconds start_ns_ = 0, due_ns_ = 0;
};

}  // namespace godobject
