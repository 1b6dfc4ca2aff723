// What happens to a run, told when it happens: faults as they come up and are over, and every re-arming.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "platform/cli/fault_texts.h"
#include "platform/rt/background_file.h"
#include "platform/rt/ring.h"
#include "platform/session/session.h"

namespace godobject {

enum class RunEventKind : std::uint8_t {
  rig_fault,   // at a place
  core_fault,  // a bit of Fault
  core_over,   // it has stayed away for half a second
  cleared,     // the rig's faults were cleared
  lost,        // --rearm auto: the run goes on once the device is back
  trying,      // --rearm auto: it is not back yet
  armed,       // --rearm auto: the motors have torque again
  stop,        // a signal: torque runs down
  quick_stop,  // a second one: torque is gone at once
};

/// As it leaves the real-time thread.
struct RunEventMark {
  RunEventKind kind = RunEventKind::rig_fault;
  RigFaultRecord rig_fault{};
  std::size_t core_fault = 0;  // index of core_fault_texts
  double t_s = 0;              // of the motion
};

/// As it is told.
struct RunEvent {
  RunEventKind kind = RunEventKind::rig_fault;
  double t_s = 0;       // of the motion
  std::string name{};   // of a fault
  std::string bus{};    // empty: the host, or none
  int node = 0;         // 0: no single node
  std::string place{};  // "can0 node 4, drive of elbow"; empty: none
  std::string cause{}, remedy{};
};

std::string_view name_of(RunEventKind kind) noexcept;
/// One line, without its end.
std::string line_of(const RunEvent& event);

/// Looks at the session after each period. Real-time.
class EventWatch {
 public:
  explicit EventWatch(Ring<RunEventMark>& out) : out_(out) {}

  /// stepped: the period was a step, and the record is of it.
  void look(const Session& session, const CycleRecord& record, bool stepped) noexcept;
  /// The session was restarted: its rig knows of no fault, and to arm it is an event. Not while it runs.
  void restart() noexcept {
    num_seen_ = 0;
    was_lost_ = true;
  }

 private:
  void look_at_rig(const Session& session, const Rig& rig) noexcept;
  void look_at_core(const CycleRecord& record) noexcept;
  void push(const RunEventMark& mark) noexcept { static_cast<void>(out_.try_push(mark)); }

  Ring<RunEventMark>& out_;
  std::size_t num_seen_ = 0;  // of the rig's places
  bool was_lost_ = false;
  std::array<bool, core_fault_texts.size()> active_{};
  std::array<double, core_fault_texts.size()> t_last_{};
};

/// The other end: prints each at once, and keeps them for the report. Not for the real-time thread.
class RunEvents {
 public:
  static constexpr std::size_t max_kept = 1000;

  RunEvents(const Session& session, BackgroundFile& console) : session_(session), console_(console) {}

  /// For EventWatch.
  Ring<RunEventMark>& ring() noexcept { return ring_; }
  /// Tells what has come out of the ring.
  void drain();
  /// Tells an event of the run itself. t_s: of the motion; cause: what happened; remedy: what to do or what comes next.
  void tell(RunEventKind kind, double t_s, std::string cause, std::string remedy);

  const std::vector<RunEvent>& list() const noexcept { return list_; }
  /// Beyond max_kept, or lost on their way.
  std::uint64_t left_out() const noexcept { return left_out_ + ring_.lost(); }

 private:
  RunEvent event_of(const RunEventMark& mark) const;
  void tell(RunEvent event);

  const Session& session_;
  BackgroundFile& console_;
  Ring<RunEventMark> ring_{1024};
  std::vector<RunEvent> list_;
  std::uint64_t left_out_ = 0;
};

}  // namespace godobject
