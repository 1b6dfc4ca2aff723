// The loop of a run. Its period goes from the first boot cycle to the last of shut-down. It runs as fast as
// the machine allows, or one cycle per period on a real-time thread. With --rearm auto, buses are reopened
// and nodes set up again between two loops.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "platform/cli/report/console.h"
#include "platform/cli/report/files.h"
#include "platform/cli/report/statistics.h"
#include "platform/rig/buses.h"
#include "platform/rig/log_link.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/ring.h"
#include "platform/rt/seal.h"
#include "platform/rt/setup.h"
#include "platform/session/session.h"
#include "platform/view/frame.h"

namespace godobject {

/// Policy for re-arming after a loss of the device.
enum class Rearm : std::uint8_t { never, automatic };

struct RunPlan {
  std::uint64_t num_cycles = 0;  // number of steps
  Rearm rearm = Rearm::never;
  bool quiet = false;            // true: no status line
  const LogLink* log = nullptr;  // log that replaces the session's buses, and whose end ends the run; or null
  bool seal = false;             // true: refuses undocumented system calls of the loop
  RtThreadPlan thread{};         // core and scheduling of the loop
  ViewTap* tap = nullptr;        // tap of a view, which outlives the run; or null
  ViewTap* poses_tap = nullptr;  // tap of a server of poses, likewise
};

/// Counts the steps, and ends the session after the last, on request, or, with automatic re-arming, at a
/// fault.
class RunCycle {
 public:
  RunCycle(Session& session, const RunPlan& plan, const std::atomic<bool>& stop)
      : session_(session),
        left_(plan.num_cycles),
        rearm_(plan.rearm),
        log_(plan.log),
        stop_(stop),
        deadlines_(session.scene().step),
        tap_(plan.tap),
        poses_tap_(plan.poses_tap) {
    statistics_.prepare(session.scene(), session.at_start());
  }

  /// Runs one period. Real-time if `record` comes from Session::at_start(). Returns true if the period was a
  /// step, described by `record`.
  bool run(CycleRecord& record) noexcept GODOBJECT_NONBLOCKING {
    if (stop_.load(std::memory_order_relaxed)) session_.stop();
    const bool is_broken = seal_ && seal_->is_broken();
    if (is_broken || (insisted_ && insisted_->load(std::memory_order_relaxed))) session_.quick_stop();
    const bool stepped = session_.advance(record);
    if (events_) events_->look(session_, record, stepped);
    if (tap_) tap_->offer(session_, record);
    if (poses_tap_) poses_tap_->offer(session_, record);
    if (!stepped) return false;
    statistics_.add(record);
    if (!any(record.rig_faults)) {
      if (!t_first_step_ns_) t_first_step_ns_ = session_.bus_time_ns();
    } else if (!t_fault_ns_) {
      t_fault_ns_ = session_.bus_time_ns();
    }
    if (--left_ == 0 || (t_fault_ns_ && rearm_ == Rearm::automatic)) session_.stop();
    return true;
  }
  /// Adds the times of a step's stages, to be called at the end of its period.
  void end_stages() noexcept { statistics_.add(session_.end_stages()); }
  /// Returns true if the next period may run. Otherwise a page holds the run back, and the view receives
  /// `record` again.
  bool may_run(const CycleRecord& record) noexcept GODOBJECT_NONBLOCKING {
    if (!tap_ || session_.phase() != RunPhase::running || stop_.load(std::memory_order_relaxed) ||
        tap_->may_run(MonotonicClock{}, to_ns(session_.scene().step)))
      return true;
    tap_->offer(session_, record);
    return false;
  }
  /// Counts missed deadlines; called before each period with a deadline. Periods before the first step do not
  /// count, because booting has no deadline.
  void watch(const Wake& wake) noexcept GODOBJECT_NONBLOCKING {
    if (tap_) tap_->woke(wake.latency);
    if (session_.phase() != RunPhase::running) return deadlines_.reset();
    deadlines_.add(wake.late_before, wake.skipped);
    session_.hold(deadlines_.holds());
    if (deadlines_.lost()) session_.deadlines_missed();
  }
  bool ended() const noexcept { return session_.phase() == RunPhase::ended || log_ended() || is_reset(); }
  /// True if a page has reset the run, and no signal stops it.
  bool is_reset() const noexcept {
    return tap_ && tap_->is_reset() && !stop_.load(std::memory_order_relaxed);
  }
  /// Sets the flag that stops the motors at once, without running down. Not while the loop runs.
  void quick_stop_on(const std::atomic<bool>& insisted) noexcept { insisted_ = &insisted; }
  /// Sets the seal of the loop, which stops the motors at once when it is broken. Not while the loop runs.
  void quick_stop_on(const Seal& seal) noexcept { seal_ = &seal; }
  /// Sets the watch that records events. Not while the loop runs.
  void tell(EventWatch& events) noexcept { events_ = &events; }

  std::uint64_t left() const noexcept { return log_ended() ? 0 : left_; }
  const RunStatistics& statistics() const noexcept { return statistics_; }
  /// Bus time of the first step without a rig fault, and of the first with one, since the latest start of the
  /// session.
  std::optional<Nanoseconds> t_first_step_ns() const noexcept { return t_first_step_ns_; }
  std::optional<Nanoseconds> t_fault_ns() const noexcept { return t_fault_ns_; }
  /// Prepares the next start of the session. Not while the loop runs.
  void restart() noexcept {
    t_first_step_ns_ = t_fault_ns_ = std::nullopt;
    if (events_) events_->restart();
  }

 private:
  bool log_ended() const noexcept { return log_ != nullptr && log_->ended(); }

  Session& session_;
  std::uint64_t left_;
  Rearm rearm_;
  const LogLink* log_;
  const std::atomic<bool>& stop_;
  DeadlineWatch deadlines_;
  ViewTap* tap_;
  ViewTap* poses_tap_;
  const std::atomic<bool>* insisted_ = nullptr;
  const Seal* seal_ = nullptr;
  EventWatch* events_ = nullptr;
  RunStatistics statistics_;
  std::optional<Nanoseconds> t_first_step_ns_, t_fault_ns_;
};

/// Cycle in the ring from the real-time thread to the files.
struct CycleEntry {
  CycleRecord record;
  Nanoseconds wake_ns = 0;
};

/// Returns an entry with the sizes of this session, from which the ring is made.
inline CycleEntry entry_of(const Session& session) { return {.record = session.at_start(), .wake_ns = 0}; }

/// Period of the real-time thread: no allocation, no lock, no system call except those of real buses.
class RealtimeCycle {
 public:
  /// states: ring for the states of an input log; null without one.
  RealtimeCycle(Session& session, const RunPlan& plan, const std::atomic<bool>& stop, Ring<CycleEntry>& out,
                Ring<EngineState>* states = nullptr)
      : session_(session),
        state_every_(cycles_between_states(session.scene().step)),
        cycle_(session, plan, stop),
        counts_each_(plan.seal),
        out_(out),
        states_(states),
        entry_(entry_of(session)) {
    if (states_) state_ = state_of(session);
  }

  /// Runs a period. Returns false after the last.
  bool operator()(const Wake& wake) noexcept GODOBJECT_NONBLOCKING {
    entry_.wake_ns = wake.latency;
    cycle_.watch(wake);
    if (!cycle_.may_run(entry_.record)) return !cycle_.ended();
    if (cycle_.run(entry_.record)) {
      static_cast<void>(out_.try_push(entry_));  // the ring counts losses
      if (++steps_ == warm_up_steps) faults_before_ = loop::page_faults();
      if (counts_each_ && steps_ > warm_up_steps && !first_fault_) look_for_page_faults();
      if (states_ && entry_.record.cycle % state_every_ == 0) push_state();
      cycle_.end_stages();
    }
    return !cycle_.ended();
  }
  /// Called by the loop's thread at its end.
  void thread_ends() noexcept {
    if (steps_ >= warm_up_steps) page_faults_ += loop::page_faults() - faults_before_;
    was_warm_ = was_warm_ || steps_ >= warm_up_steps;
    steps_ = 0;
  }

  static constexpr std::uint64_t warm_up_steps = 100;
  /// Returns the page faults of the loop's threads after their first steps; none if there were no more steps.
  std::optional<PageFaults> page_faults() const noexcept {
    return was_warm_ ? std::optional(page_faults_) : std::nullopt;
  }
  /// Returns the first cycle after those with a page fault; none without one, or if the loop is not sealed.
  std::optional<std::uint64_t> first_page_fault() const noexcept { return first_fault_; }

  const RunStatistics& statistics() const noexcept { return cycle_.statistics(); }
  RunCycle& cycle() noexcept { return cycle_; }

 private:
  /// Reads the page faults after a step, by a system call: in a sealed loop only.
  void look_for_page_faults() noexcept GODOBJECT_NONBLOCKING {
    const PageFaults faults = loop::page_faults() - faults_before_;
    if (faults.minor + faults.major > 0) first_fault_ = entry_.record.cycle;
  }
  void push_state() noexcept GODOBJECT_NONBLOCKING {
    state_.cycle = entry_.record.cycle;
    take_state(session_, state_);
    static_cast<void>(states_->try_push(state_));
  }

  Session& session_;
  std::uint64_t state_every_;  // cycles
  RunCycle cycle_;
  bool counts_each_;  // true: looks for page faults after each step
  Ring<CycleEntry>& out_;
  Ring<EngineState>* states_;
  CycleEntry entry_;
  std::uint64_t steps_ = 0;  // of this thread
  bool was_warm_ = false;
  PageFaults faults_before_, page_faults_;
  std::optional<std::uint64_t> first_fault_;  // cycle
  EngineState state_;
};

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
  /// real: null for simulated buses, on which the pauses pass in simulated time, and for logs.
  Recoveries(Session& session, RunCycle& cycle, const RunPlan& plan, const RigOnBuses* real,
             const std::atomic<bool>& stop, RunEvents& events)
      : session_(session), cycle_(cycle), plan_(plan), real_(real), stop_(stop), events_(events) {}

  /// Called after the end of the session. Returns true if it was restarted and must be run again.
  bool again();
  const std::vector<Recovery>& list() const noexcept { return list_; }

 private:
  void note();
  bool wait(double time_s);
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

struct RunResult {
  bool ready = false;                   // true if the device came up; otherwise no cycle was run
  std::vector<std::string> not_set_up;  // reasons why nodes could not be set up; if any, no cycle was run
  std::string_view stopped_by;          // "SIGINT", ...; empty: all cycles were run
  bool is_reset = false;                // true if a page ended the run to start it again
  RunStatistics statistics;
  CyclicStatistics timing;                        // wake-up, late, skipped: --realtime only
  std::vector<RtStep> setup;                      // --realtime only
  std::optional<PageFaults> page_faults;          // of the loop after its first steps: --realtime only
  std::optional<std::uint64_t> first_page_fault;  // first cycle with one of these: --seal only
  std::string seal_broken;                        // refused system call; empty: none, or not sealed
  std::uint64_t refused_calls = 0;
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
