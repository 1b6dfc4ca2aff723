// One period of the loop, from the first boot cycle to the last of shut-down.
#pragma once

#include <atomic>
#include <cstdint>

#include "platform/cli/report/events.h"
#include "platform/cli/report/statistics.h"
#include "platform/rig/log_link.h"
#include "platform/rt/cyclic.h"
#include "platform/rt/deadline_watch.h"
#include "platform/rt/ring.h"
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
  ViewTap* tap = nullptr;        // tap of a view, which outlives the run; or null
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
        tap_(plan.tap) {
    statistics_.prepare(session.scene(), session.at_start());
  }

  /// Runs one period. Real-time if `record` comes from Session::at_start(). Returns true if the period was a
  /// step, described by `record`.
  bool run(CycleRecord& record) noexcept {
    if (stop_.load(std::memory_order_relaxed)) session_.stop();
    if (insisted_ && insisted_->load(std::memory_order_relaxed)) session_.quick_stop();
    const bool stepped = session_.advance(record);
    if (events_) events_->look(session_, record, stepped);
    if (tap_) tap_->offer(session_, record);
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
  /// Counts missed deadlines; called before each period with a deadline. Periods before the first step do not
  /// count, because booting has no deadline.
  void watch(const Wake& wake) noexcept {
    if (tap_) tap_->woke(wake.latency);
    if (session_.phase() != RunPhase::running) return deadlines_.reset();
    deadlines_.add(wake.late_before, wake.skipped);
    session_.hold(deadlines_.holds());
    if (deadlines_.lost()) session_.deadlines_missed();
  }
  bool ended() const noexcept { return session_.phase() == RunPhase::ended || log_ended(); }
  /// Sets the flag that stops the motors at once, without running down. Not while the loop runs.
  void quick_stop_on(const std::atomic<bool>& insisted) noexcept { insisted_ = &insisted; }
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
  const std::atomic<bool>* insisted_ = nullptr;
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
  RealtimeCycle(Session& session, const RunPlan& plan, const std::atomic<bool>& stop, Ring<CycleEntry>& out)
      : cycle_(session, plan, stop), out_(out), entry_(entry_of(session)) {}

  /// Runs a period. Returns false after the last.
  bool operator()(const Wake& wake) noexcept {
    entry_.wake_ns = wake.latency;
    cycle_.watch(wake);
    if (cycle_.run(entry_.record)) static_cast<void>(out_.try_push(entry_));  // the ring counts losses
    return !cycle_.ended();
  }

  const RunStatistics& statistics() const noexcept { return cycle_.statistics(); }
  RunCycle& cycle() noexcept { return cycle_; }

 private:
  RunCycle cycle_;
  Ring<CycleEntry>& out_;
  CycleEntry entry_;
};

}  // namespace godobject
