// The two ways to run a session: as fast as the machine allows, or one cycle per period on a real-time
// thread.
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
  bool ready = false;                   // true if the device came up; otherwise no cycle was run
  std::vector<std::string> not_set_up;  // reasons why nodes could not be set up; if any, no cycle was run
  std::string_view stopped_by;          // "SIGINT", ...; empty: all cycles were run
  RunStatistics statistics;
  CyclicStatistics timing;    // wake-up, late, skipped: --realtime only
  std::vector<RtStep> setup;  // --realtime only
  std::vector<Recovery> recoveries;
  std::vector<RunEvent> events;  // in the order in which they were printed
  std::uint64_t lost_events = 0, lost_console_lines = 0;
  std::uint64_t lost_cycles = 0, lost_frames = 0;  // lost for the files, whose writer was too slow
};

/// Runs on the simulated clock, in this thread. Equal sessions give bit-identical results.
RunResult run_fast(Session& session, const RunPlan& plan, RunFiles& files);

/// Runs from the first boot cycle to the last of shut-down on a thread of its own. Returns nothing if no
/// thread can be started.
/// real: the session's open buses if they are real; else null.
std::optional<RunResult> run_realtime(Session& session, const RunPlan& plan, RunFiles& files,
                                      const RigOnBuses* real);

}  // namespace godobject
