// What the loop does once a period, from the first boot cycle to the last of shut-down.
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
#include "platform/view/tap.h"

namespace godobject {

/// Whether a run that lost its device arms it again by itself.
enum class Rearm : std::uint8_t { never, automatic };

struct RunPlan {
  std::uint64_t num_cycles = 0;  // steps
  Rearm rearm = Rearm::never;
  bool quiet = false;            // no status line
  const LogLink* log = nullptr;  // of the session's buses; the run ends with it
  ViewTap* tap = nullptr;        // of who looks on; it outlives the run
};

/// Counts the steps and ends the session after the last, when it is told to, and, where the device is armed
/// again, at a fault.
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

  /// One period; real-time, for a record that comes from Session::at_start(). True: it was a step, and the
  /// record is of it.
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
  /// Before each period that has a deadline. Those before the first step do not count: booting waits for nobody.
  void watch(const Wake& wake) noexcept {
    if (tap_) tap_->woke(wake.latency);
    if (session_.phase() != RunPhase::running) return deadlines_.reset();
    deadlines_.add(wake.late_before, wake.skipped);
    session_.hold(deadlines_.holds());
    if (deadlines_.lost()) session_.deadlines_missed();
  }
  bool ended() const noexcept { return session_.phase() == RunPhase::ended || log_ended(); }
  /// Once this is set the motors are stopped at once, without running down. Not while it runs.
  void quick_stop_on(const std::atomic<bool>& insisted) noexcept { insisted_ = &insisted; }
  /// What happens is marked there. Not while it runs.
  void tell(EventWatch& events) noexcept { events_ = &events; }

  std::uint64_t left() const noexcept { return log_ended() ? 0 : left_; }
  const RunStatistics& statistics() const noexcept { return statistics_; }
  /// In bus time, since the session was started last: of the first step without a rig fault, and with one.
  std::optional<Nanoseconds> t_first_step_ns() const noexcept { return t_first_step_ns_; }
  std::optional<Nanoseconds> t_fault_ns() const noexcept { return t_fault_ns_; }
  /// Not while it runs.
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

/// A cycle on its way from the real-time thread to the files.
struct CycleEntry {
  CycleRecord record;
  Nanoseconds wake_ns = 0;
};

/// As all entries of this session: the ring and what fills it are made of it.
inline CycleEntry entry_of(const Session& session) { return {.record = session.at_start(), .wake_ns = 0}; }

/// What the real-time thread does once a period: no allocation, no lock, no system call but those of real buses.
class RealtimeCycle {
 public:
  RealtimeCycle(Session& session, const RunPlan& plan, const std::atomic<bool>& stop, Ring<CycleEntry>& out)
      : cycle_(session, plan, stop), out_(out), entry_(entry_of(session)) {}

  /// False after the last cycle.
  bool operator()(const Wake& wake) noexcept {
    entry_.wake_ns = wake.latency;
    cycle_.watch(wake);
    if (cycle_.run(entry_.record)) static_cast<void>(out_.try_push(entry_));  // counted there when full
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
