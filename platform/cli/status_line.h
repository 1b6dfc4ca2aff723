// The line a real-time run shows while it goes.
#pragma once

#include "hal/can_frame.h"
#include "platform/background_file.h"
#include "sim/session.h"

namespace godobject {

/// On a terminal one line, redrawn five times a second; otherwise one line a second. To standard error; where that
/// takes nothing the lines are lost.
class StatusLine {
 public:
  explicit StatusLine(BackgroundFile& console) noexcept;

  /// Takes note of a cycle, and shows it when it is time to.
  void update(const CycleRecord& record, Nanoseconds wake_ns);
  /// Leaves the terminal's cursor on a fresh line.
  void end();

 private:
  void show(const CycleRecord& record);

  BackgroundFile& console_;
  bool terminal_;
  double interval_s_;
  double due_s_ = 0;          // in the run's time
  double worst_wake_us_ = 0;  // since the line was last shown
};

}  // namespace godobject
