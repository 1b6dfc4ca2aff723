#include "platform/cli/report/console.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

#include "platform/cli/report/statistics.h"

namespace godobject {
namespace {

constexpr double core_fault_is_over_after_s = 0.5;

double since_start_s(const Session& session, Nanoseconds t) noexcept {
  return 1e-9 * static_cast<double>(t - session.motion_start_ns());
}

}  // namespace

std::string_view name_of(RunEventKind kind) noexcept {
  switch (kind) {
    case RunEventKind::rig_fault:
    case RunEventKind::core_fault:
    case RunEventKind::run_fault: return "fault";
    case RunEventKind::core_over: return "over";
    case RunEventKind::cleared: return "cleared";
    case RunEventKind::lost: return "lost";
    case RunEventKind::trying: return "trying";
    case RunEventKind::armed: return "armed";
    case RunEventKind::homing: return "homing";
    case RunEventKind::refused: return "refused";
    case RunEventKind::homed: return "homed";
    case RunEventKind::stop: return "stop";
    case RunEventKind::world_lost: return "world_lost";
    case RunEventKind::world_back: return "world_back";
    case RunEventKind::kept: return "kept";
    case RunEventKind::quick_stop: break;
  }
  return "quick_stop";
}

std::string line_of(const RunEvent& event) {
  std::array<char, 32> time{};
  std::snprintf(time.data(), time.size(), "at %.3f s: ", event.t_s);
  std::string line = time.data();
  if (is_fault(event.kind)) line += "FAULT ";
  line += event.name;
  if (!event.place.empty()) line += " (" + event.place + ")";
  if (!event.name.empty()) line += ": ";
  line += event.cause;
  if (!event.remedy.empty()) line += "; " + event.remedy;
  return line;
}

void EventWatch::look(const Session& session, const CycleRecord& record, bool stepped) noexcept {
  if (const Rig* const rig = session.rig()) look_at_rig(session, *rig);
  if (!stepped) return;
  look_at_core(record);
  look_at_run(session, record);
  if (const WorldPlanes* const world = session.world()) look_at_world(*world, record.t);
}

void EventWatch::look_at_world(const WorldPlanes& world, double t_s) noexcept {
  const bool live = world.counters().live;
  if (live == was_world_live_) return;
  was_world_live_ = live;
  push({.kind = live ? RunEventKind::world_back : RunEventKind::world_lost, .t_s = t_s});
}

void EventWatch::look_at_rig(const Session& session, const Rig& rig) noexcept {
  const std::span<const RigFaultRecord> records = rig.fault_log().records();
  const double now_s = since_start_s(session, session.bus_time_ns());
  if (records.size() < num_seen_) {
    num_seen_ = 0;
    push({.kind = RunEventKind::cleared, .t_s = now_s});
  }
  for (; num_seen_ < records.size(); ++num_seen_) {
    const RigFaultRecord& record = records[num_seen_];
    push({.kind = RunEventKind::rig_fault, .rig_fault = record, .t_s = since_start_s(session, record.t_ns)});
  }
  if (rig.needs_homing()) look_at_homing(rig, now_s);
  if (!was_lost_ || rig.state() != RigState::armed) return;
  was_lost_ = false;
  push({.kind = RunEventKind::armed, .t_s = now_s});
}

void EventWatch::look_at_homing(const Rig& rig, double now_s) noexcept {
  const bool is_homing = rig.state() == RigState::homing;
  const RefusedPresses& refused = rig.refused_presses();
  if (is_homing && !was_homing_) push({.kind = RunEventKind::homing, .t_s = now_s});
  if (refused.count > num_refused_)
    push({.kind = RunEventKind::refused, .joint = refused.joint, .t_s = now_s});
  const bool is_homed = rig.state() > RigState::homing && rig.state() <= RigState::armed;
  if (was_homing_ && is_homed) push({.kind = RunEventKind::homed, .t_s = now_s});
  num_refused_ = refused.count;
  was_homing_ = is_homing;
}

void EventWatch::look_at_core(const CycleRecord& record) noexcept {
  for (std::size_t i = 0; i < active_.size(); ++i) {
    if ((static_cast<std::uint32_t>(record.fault) & static_cast<std::uint32_t>(core_fault_texts[i].fault)) !=
        0) {
      if (!active_[i]) push({.kind = RunEventKind::core_fault, .core_fault = i, .t_s = record.t});
      active_[i] = true;
      t_last_[i] = record.t;
    } else if (active_[i] && record.t - t_last_[i] >= core_fault_is_over_after_s) {
      active_[i] = false;
      push({.kind = RunEventKind::core_over, .core_fault = i, .t_s = record.t});
    }
  }
}

/// Detects faults of the run itself; with a rig they are faults of the rig.
void EventWatch::look_at_run(const Session& session, const CycleRecord& record) noexcept {
  if (session.rig() != nullptr) return;
  if (session.missed_deadlines() && !std::exchange(had_missed_deadlines_, true))
    push({.kind = RunEventKind::run_fault, .run_fault = RunFault::deadlines_missed, .t_s = record.t});
  if (record.force_oscillates && !std::exchange(had_oscillation_, true))
    push({.kind = RunEventKind::run_fault, .run_fault = RunFault::force_oscillates, .t_s = record.t});
}

void RunEvents::drain() {
  for (RunEventMark mark; ring_.try_pop(mark);) tell(event_of(mark));
}

RunEvent RunEvents::event_of(const RunEventMark& mark) const {
  RunEvent event{.kind = mark.kind, .t_s = mark.t_s};
  switch (mark.kind) {
    case RunEventKind::rig_fault: {
      const RigFaultText& text = text_of(mark.rig_fault.place.fault);
      event.name = text.name;
      if (mark.rig_fault.place.bus)
        event.bus = session_.scene().device->rig->buses[*mark.rig_fault.place.bus].name;
      event.node = mark.rig_fault.place.node_id;
      event.place = session_.rig()->place_text(mark.rig_fault);
      event.cause = text.meaning;
      event.remedy = text.remedy;
      break;
    }
    case RunEventKind::core_fault:
    case RunEventKind::core_over: {
      const FaultText& text = core_fault_texts[mark.core_fault].text;
      event.name = text.name;
      event.cause = mark.kind == RunEventKind::core_fault ? text.meaning : "over";
      if (mark.kind == RunEventKind::core_fault) event.remedy = text.remedy;
      break;
    }
    case RunEventKind::run_fault: {
      const FaultText& text = text_of(mark.run_fault);
      event.name = text.name;
      event.cause = text.meaning;
      event.remedy = text.remedy;
      break;
    }
    case RunEventKind::world_lost:
      event.cause = "the world is silent: its planes are released, and their force fades";
      event.remedy = "restart its program, or let it send sooner than its valid_s";
      break;
    case RunEventKind::world_back: event.cause = "the world sends planes"; break;
    case RunEventKind::homing:
      event.cause = "HOMING: the motors have no torque";
      event.remedy = homing_request(*session_.scene().device->rig);
      break;
    case RunEventKind::refused:
      event.cause = "press refused: joint '" + session_.scene().device->rig->tree.joints[mark.joint].name +
                    "' was not at rest for 0.1 s";
      event.remedy = "keep the device in its home pose and press again";
      break;
    case RunEventKind::homed: event.cause = "homed: the zeros of the incremental sensors are set"; break;
    case RunEventKind::cleared: event.cause = "the faults of the device were cleared"; break;
    default: event.cause = "ARMED again: the motors have torque"; break;
  }
  return event;
}

void RunEvents::tell(RunEventKind kind, double t_s, std::string cause, std::string remedy, std::string name) {
  drain();
  RunEvent event{.kind = kind, .t_s = t_s, .name = std::move(name)};
  event.cause = std::move(cause);
  event.remedy = std::move(remedy);
  tell(std::move(event));
}

void RunEvents::tell(RunEvent event) {
  static_cast<void>(console_.write(line_of(event) + "\n"));
  if (list_.size() < max_kept) list_.push_back(event);
  else ++left_out_;
  if (keep_ && is_fault(event.kind)) keep_(event);
}

StatusLine::StatusLine(BackgroundFile& console, bool quiet) noexcept
    : console_(console),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      interval_s_(terminal_ ? 0.2 : 1.0),
      due_s_(interval_s_) {}

void StatusLine::update(const CycleRecord& record, Nanoseconds wake_ns) {
  worst_wake_us_ = std::max(worst_wake_us_, 1e-3 * static_cast<double>(wake_ns));
  ++cycles_;
  if (is_held(record)) ++held_;
  if (record.on_hold != on_hold_) print_hold(record);
  constexpr double rounding = 1e-9;
  if (quiet_ || record.t < due_s_ - rounding) return;
  show(record);
  worst_wake_us_ = 0;
  due_s_ += interval_s_;
}

void StatusLine::show(const CycleRecord& record) {
  const bool fault = any(record.fault) || any(record.rig_faults);
  const double held_percent = 100 * static_cast<double>(held_) / static_cast<double>(cycles_);
  std::array<char, 24> state{};
  if (held_percent > 100 * RunStatistics::max_held)
    std::snprintf(state.data(), state.size(), "%sHELD %.0f %%", fault ? "FAULT, " : "", held_percent);
  else std::snprintf(state.data(), state.size(), "%s", fault ? "FAULT" : "ok");
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(),
                "%st %7.2f s   wake-up <= %6.0f us   following %7.3f mm %7.4f rad   energy %8.2e J   %s%s",
                terminal_ ? "\r" : "", record.t, worst_wake_us_, 1e3 * record.following.m,
                record.following.rad, record.energy.total, state.data(), terminal_ ? "\033[K" : "\n");
  static_cast<void>(console_.write(line.data()));
}

/// Prints the begin or end of a hold at once.
void StatusLine::print_hold(const CycleRecord& record) {
  on_hold_ = record.on_hold;
  std::array<char, 200> line{};
  std::snprintf(line.data(), line.size(), "%st %7.3f s   deadlines: %s%s\n", terminal_ ? "\r" : "", record.t,
                on_hold_ ? "5 or more missed within 100 ms: the pose is held, the force fades"
                         : "kept for 100 ms: the force returns by the ramp",
                terminal_ ? "\033[K" : "");
  static_cast<void>(console_.write(line.data()));
}

void StatusLine::end() {
  if (terminal_ && !quiet_) static_cast<void>(console_.write("\n"));
}

FastProgress::FastProgress(BackgroundFile& console, double duration_s, bool quiet) noexcept
    : console_(console), wanted_(!quiet && isatty(STDERR_FILENO) == 1), duration_s_(duration_s) {}

void FastProgress::update(double t_s, Nanoseconds now) {
  constexpr Nanoseconds first_after = 1'000'000'000, interval = 200'000'000;
  if (!wanted_) return;
  if (start_ns_ == 0) {
    start_ns_ = now;
    due_ns_ = now + first_after;
  }
  if (now < due_ns_) return;
  due_ns_ = now + interval;
  shown_ = true;
  const double taken_s = 1e-9 * static_cast<double>(now - start_ns_);
  const double left_s = t_s > 0 ? taken_s * (duration_s_ - t_s) / t_s : 0;
  std::array<char, 120> line{};
  std::snprintf(line.data(), line.size(), "\rt %.2f of %.2f s (%.0f %%), about %.0f s left\033[K", t_s,
                duration_s_, 100 * t_s / duration_s_, left_s);
  static_cast<void>(console_.write(line.data()));
}

void FastProgress::end() {
  if (shown_) static_cast<void>(console_.write("\r\033[K"));
}

}  // namespace godobject
