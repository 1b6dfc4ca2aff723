// Recovery between two loops: with --rearm auto, after a fault, buses are reopened and nodes set up again.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "platform/cli/run/cycle.h"
#include "platform/rig/bring_up.h"

namespace godobject {

/// A fault of the rig and its recovery.
struct Recovery {
  double seen_s = 0;                  // bus time since the start of the motion
  std::string named;                  // the rig's faults, one line each
  std::vector<std::string> troubles;  // troubles of the buses at that time
  int boots = 0;                      // number of attempts to boot the nodes
  // from seen_s to the first step with the device armed; none: never
  std::optional<double> recovered_after_s;
};

/// Restarts a session after a fault, with Rearm::automatic. Reopens lost buses until all are back, with
/// pauses that double from attempt to attempt. Then sets up the nodes and restarts the session. A device that
/// never came up is not awaited.
class Recoveries {
 public:
  /// real: null for simulated buses, whose time stands still meanwhile.
  Recoveries(Session& session, RunCycle& cycle, const RunPlan& plan, const RigOnBuses* real,
             const std::atomic<bool>& stop, RunEvents& events)
      : session_(session), cycle_(cycle), plan_(plan), real_(real), stop_(stop), events_(events) {}

  /// Called after the end of the session. Returns true if it was restarted and must be run again.
  bool again();
  const std::vector<Recovery>& list() const noexcept { return list_; }

 private:
  void note();
  bool reopen();
  void tell(RunEventKind kind, std::string cause, std::string remedy);

  Session& session_;
  RunCycle& cycle_;
  RunPlan plan_;
  const RigOnBuses* real_;
  const std::atomic<bool>& stop_;
  RunEvents& events_;
  std::vector<Recovery> list_;
};

}  // namespace godobject
