// What goes on while no loop runs: with --rearm auto, after a fault, the buses are opened and the nodes set up again.
#pragma once

#include <atomic>
#include <string>
#include <vector>

#include "platform/cli/run/cycle.h"
#include "platform/rig/bring_up.h"

namespace godobject {

/// A fault of the rig, and how the run went on.
struct Recovery {
  double seen_s = 0;                        // bus time since the motion began
  std::string named;                        // the rig's faults, one line each
  std::vector<std::string> troubles;        // of the buses at that time
  int boots = 0;                            // tries to bring the nodes up again
  std::optional<double> recovered_after_s;  // from seen to the first step with the device armed; none: never
};

/// Goes on after a session has ended. With Rearm::automatic, at a fault: what is cut off is closed and opened
/// until every bus is back, with a pause that doubles from try to try; the nodes are set up afresh; the session
/// is restarted. A device that has never come up is not waited for.
class Recoveries {
 public:
  /// real: null for simulated buses, whose time stands still meanwhile.
  Recoveries(Session& session, RunCycle& cycle, const RunPlan& plan, const RigOnBuses* real,
             const std::atomic<bool>& stop, RunEvents& events)
      : session_(session), cycle_(cycle), plan_(plan), real_(real), stop_(stop), events_(events) {}

  /// The session has ended. True: it has been restarted and is to be run again.
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
