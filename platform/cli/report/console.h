// Lines that a run prints while it lasts: the status line of a real-time run, and events. Events are
// beginnings and ends of faults, and every re-arming.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "hal/can/frame.h"
#include "platform/cli/fault_texts.h"
#include "platform/rt/background_file.h"
#include "platform/rt/ring.h"
#include "platform/session/session.h"

namespace godobject {

enum class RunEventKind : std::uint8_t {
  rig_fault,   // a fault at a place of the rig
  core_fault,  // a bit of Fault
  run_fault,   // a RunFault seen in the loop
  core_over,   // absent for half a second
  cleared,     // the rig's faults were cleared
  lost,        // --rearm auto: the run continues when the device is back
  trying,      // --rearm auto: the device is not back yet
  armed,       // --rearm auto: the motors have torque again
  homing,      // booting waits until the user confirms the home pose
  refused,     // the home button was pressed while a joint moved
  homed,       // the home pose was confirmed
  stop,        // a signal: torque runs down
  quick_stop,  // a second signal or the space bar: torque is cut at once
  world_lost,  // --world: no packet in time
  world_back,  // --world: packets are used, for the first time or again
  kept,        // the seconds before a fault are in a file
};

constexpr bool is_fault(RunEventKind kind) noexcept {
  return kind == RunEventKind::rig_fault || kind == RunEventKind::core_fault ||
         kind == RunEventKind::run_fault;
}

/// Event as recorded by the real-time thread.
struct RunEventMark {
  RunEventKind kind = RunEventKind::rig_fault;
  RigFaultRecord rig_fault{};
  std::size_t core_fault = 0;  // index of core_fault_texts
  std::size_t joint = 0;       // of the device, that moved
  RunFault run_fault{};
  double t_s = 0;  // s, time of the motion
};

/// Event as printed and reported.
struct RunEvent {
  RunEventKind kind = RunEventKind::rig_fault;
  double t_s = 0;       // s, time of the motion
  std::string name{};   // name of a fault
  std::string bus{};    // empty: the host, or none
  int node = 0;         // 0: no single node
  std::string place{};  // "can0 node 4, drive of elbow"; empty: none
  std::string cause{}, remedy{};
};

std::string_view name_of(RunEventKind kind) noexcept;
/// Formats an event as one line without its end.
std::string line_of(const RunEvent& event);

/// Detects events of the session after each period. Real-time.
class EventWatch {
 public:
  explicit EventWatch(Ring<RunEventMark>& out) : out_(out) {}

  /// stepped: true if the period was a step, which `record` describes.
  void look(const Session& session, const CycleRecord& record, bool stepped) noexcept;
  /// Resets the watch after a restart of the session, whose rig has no faults; arming it is an event. Not
  /// while the session runs.
  void restart() noexcept {
    num_seen_ = 0;
    num_refused_ = 0;
    was_homing_ = false;
    was_lost_ = true;
  }

 private:
  void look_at_rig(const Session& session, const Rig& rig) noexcept;
  void look_at_homing(const Rig& rig, double now_s) noexcept;
  void look_at_core(const CycleRecord& record) noexcept;
  void look_at_run(const Session& session, const CycleRecord& record) noexcept;
  void look_at_world(const WorldPlanes& world, double t_s) noexcept;
  void push(const RunEventMark& mark) noexcept { static_cast<void>(out_.try_push(mark)); }

  Ring<RunEventMark>& out_;
  std::size_t num_seen_ = 0;       // number of places of the rig reported so far
  std::uint64_t num_refused_ = 0;  // presses of the home button, likewise
  bool was_homing_ = false;
  bool was_lost_ = false;
  bool was_world_live_ = false;
  bool had_missed_deadlines_ = false, had_oscillation_ = false;
  std::array<bool, core_fault_texts.size()> active_{};
  std::array<double, core_fault_texts.size()> t_last_{};
};

/// Receives the events, prints each at once and keeps them for the report. Not for the real-time thread.
class RunEvents {
 public:
  static constexpr std::size_t max_kept = 1000;

  RunEvents(const Session& session, BackgroundFile& console) : session_(session), console_(console) {}

  /// Ring filled by EventWatch.
  Ring<RunEventMark>& ring() noexcept { return ring_; }
  /// Prints all events in the ring.
  void drain();
  /// Prints an event of the run itself.
  /// t_s: time of the motion, s.
  /// cause: text of the event.
  /// remedy: text of the remedy, or of the next event.
  /// name: of a fault; empty for other events.
  void tell(RunEventKind kind, double t_s, std::string cause, std::string remedy, std::string name = "");
  /// Calls `keep` after each event that is a fault.
  void at_faults(std::function<void(const RunEvent&)> keep) { keep_ = std::move(keep); }

  const std::vector<RunEvent>& list() const noexcept { return list_; }
  /// Returns the number of events beyond max_kept or lost in the ring.
  std::uint64_t left_out() const noexcept { return left_out_ + ring_.lost(); }

 private:
  RunEvent event_of(const RunEventMark& mark) const;
  void tell(RunEvent event);

  const Session& session_;
  BackgroundFile& console_;
  Ring<RunEventMark> ring_{1024};
  std::function<void(const RunEvent&)> keep_;
  std::vector<RunEvent> list_;
  std::uint64_t left_out_ = 0;
};

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
