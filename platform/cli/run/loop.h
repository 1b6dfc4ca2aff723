// The two ways to run a session: as fast as the machine allows, or one cycle a period on a real-time thread.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "platform/cli/report/files.h"
#include "platform/cli/run/recovery.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/setup.h"

namespace godobject {

struct RunResult {
  bool ready = false;                   // the device came up; otherwise no cycle was run
  std::vector<std::string> not_set_up;  // why nodes could not be set up: no cycle was run either
  std::string_view stopped_by;          // "SIGINT", ...; empty: all cycles were run
  RunStatistics statistics;
  CyclicStatistics timing;    // wake-up, late, skipped: --realtime only
  std::vector<RtStep> setup;  // --realtime only
  std::vector<Recovery> recoveries;
  std::vector<RunEvent> events;  // in the order in which they were told
  std::uint64_t lost_events = 0, lost_console_lines = 0;
  std::uint64_t lost_cycles = 0, lost_frames = 0;  // of the files: their writer was too slow
};

/// On the simulated clock, in this thread. Equal sessions give equal results, bit for bit.
RunResult run_fast(Session& session, const RunPlan& plan, RunFiles& files);

/// From the first boot cycle to the last of shut-down on a thread of its own. real: the session's buses where
/// they are real, open; else null. Nothing where no thread can be started.
std::optional<RunResult> run_realtime(Session& session, const RunPlan& plan, RunFiles& files,
                                      const RigOnBuses* real);

}  // namespace godobject
