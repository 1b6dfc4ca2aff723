// The two ways to run a session: as fast as the machine allows, or one cycle a period on a real-time thread.
#pragma once

#include <atomic>
#include <optional>
#include <string_view>
#include <vector>

#include "platform/cli/run_files.h"
#include "platform/cli/run_statistics.h"
#include "platform/cyclic.h"
#include "platform/ring.h"
#include "platform/rt_setup.h"
#include "sim/session.h"

namespace godobject {

struct RunResult {
  bool ready = false;           // the device came up; otherwise no cycle was run
  std::string_view stopped_by;  // "SIGINT" or "SIGTERM"; empty: all cycles were run
  RunStatistics statistics;
  CyclicStatistics timing;                         // wake-up, late, skipped: --realtime only
  std::vector<RtStep> setup;                       // --realtime only
  std::uint64_t lost_cycles = 0, lost_frames = 0;  // of the files: their writer was too slow
};

/// On the simulated clock, in this thread. Equal sessions give equal results, bit for bit.
RunResult run_fast(Session& session, std::uint64_t num_cycles, RunFiles& files);

/// Nothing where no thread can be started.
std::optional<RunResult> run_realtime(Session& session, std::uint64_t num_cycles, RunFiles& files);

/// A cycle on its way from the real-time thread to the files.
struct CycleEntry {
  CycleRecord record;
  Nanoseconds wake_ns = 0;
};

/// As all entries of this session: the ring and what fills it are made of it.
inline CycleEntry entry_of(const Session& session) { return {.record = session.at_start(), .wake_ns = 0}; }

/// What the real-time thread does once a period: no allocation, no lock, no system call.
class RealtimeCycle {
 public:
  RealtimeCycle(Session& session, std::uint64_t num_cycles, const std::atomic<bool>& stop,
                Ring<CycleEntry>& out)
      : session_(session), left_(num_cycles), stop_(stop), out_(out), entry_(entry_of(session)) {}

  /// False after the last cycle.
  bool operator()(Nanoseconds wake_ns) noexcept {
    session_.cycle(entry_.record);
    statistics_.add(entry_.record);
    entry_.wake_ns = wake_ns;
    static_cast<void>(out_.try_push(entry_));  // counted there when full
    return --left_ > 0 && !stop_.load(std::memory_order_relaxed);
  }

  const RunStatistics& statistics() const noexcept { return statistics_; }

 private:
  Session& session_;
  std::uint64_t left_;
  const std::atomic<bool>& stop_;
  Ring<CycleEntry>& out_;
  CycleEntry entry_;
  RunStatistics statistics_;
};

}  // namespace godobject
