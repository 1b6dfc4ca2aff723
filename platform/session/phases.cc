// Session: the phases of a run, one period at a time, and the frames of a period.
#include <algorithm>
#include <cmath>

#include "platform/session/session.h"

namespace godobject {
namespace {

/// The last frames are no more than a few cycles': a command to each drive, a message to each node.
constexpr std::int64_t closing_periods = 10;
/// When the time of a tracker is over its last try may be going on: it says why it failed after that.
constexpr double tracker_patience_s = 2;

}  // namespace

void Session::start(double limit_s) noexcept {
  if (phase_ != RunPhase::off) return;
  phase_ = rig_ || tracked_ ? RunPhase::booting : RunPhase::running;
  if (tracked_)
    for (const TrackerParams& tracker : scene_.device->trackers)
      limit_s = std::max(limit_s, tracker.boot_timeout_s + tracker_patience_s);
  periods_left_ = std::llround(limit_s / scene_.step);
}

bool Session::advance(CycleRecord& record) noexcept {
  const bool step = phase_ == RunPhase::running;
  switch (phase_) {
    case RunPhase::booting: boot_cycle(); break;
    case RunPhase::running: cycle(record); break;
    case RunPhase::running_down: run_down_cycle(); break;
    case RunPhase::closing: closing_cycle(); break;
    case RunPhase::off:
    case RunPhase::ended: break;
  }
  return step;
}

void Session::stop() noexcept {
  if (phase_ == RunPhase::off) phase_ = RunPhase::ended;
  if (phase_ == RunPhase::booting || phase_ == RunPhase::running) give_up_running();
}

void Session::quick_stop() noexcept {
  stop();
  if (rig_ && phase_ == RunPhase::running_down) rig_->quick_stop();
}

void Session::give_up_running() noexcept {
  if (!rig_) {
    phase_ = RunPhase::ended;
    return;
  }
  rig_->disarm();
  phase_ = RunPhase::running_down;
  periods_left_ = std::llround(shut_down_limit_s / scene_.step);
}

void Session::deadlines_missed() noexcept {
  deadlines_missed_ = true;
  if (rig_) rig_->deadlines_missed();
}

void Session::restart() {
  if (phase_ != RunPhase::ended) return;
  phase_ = RunPhase::off;
  on_hold_ = deadlines_missed_ = false;
  if (!rig_) return;
  earlier_rigs_ = rig_counters();
  rig_.emplace(*scene_.device->rig, link_->buses());
  swings_->reset();
  let_go_ = true;
}

bool Session::boot(double limit_s) {
  start(limit_s);
  while (phase_ == RunPhase::booting) boot_cycle();
  return phase_ == RunPhase::running;
}

void Session::shut_down() noexcept {
  stop();
  while (phase_ == RunPhase::running_down) run_down_cycle();
  while (phase_ == RunPhase::closing) closing_cycle();
}

void Session::boot_cycle() noexcept {
  if (rig_) {
    static_cast<void>(exchange());
    static_cast<void>(command({}));
  } else {
    pass_period();
  }
  if (tracked_) track();
  if (cycle_ == 0) motion_start_ns_ = t_bus_ns_;
  if (device_ready()) {
    phase_ = RunPhase::running;
  } else if (device_failed() || --periods_left_ <= 0) {
    give_up_running();
  }
}

/// The rig is armed last.
bool Session::device_ready() noexcept {
  if (tracked_ && !tracked_->ready()) return false;
  return !rig_ || (rig_->state() == RigState::ready && rig_->arm());
}

bool Session::device_failed() const noexcept {
  for (std::size_t i = 0; tracked_ && i < tracked_->num_trackers(); ++i)
    if (tracked_->report(i).state == TrackerState::failed) return true;
  return rig_ && rig_->state() == RigState::fault;
}

/// Of a device without buses, which have a clock of their own.
void Session::pass_period() noexcept {
  t_bus_ns_ = clock_ ? clock_() : t_bus_ns_ + to_ns(scene_.step);
  t_now_ns_ = t_bus_ns_;
}

void Session::track() noexcept {
  if (sim_trackers_) sim_trackers_->run(t_now_ns_, motion_time(cycle_));
  tracked_->update(t_now_ns_);
}

void Session::run_down_cycle() noexcept {
  if (commands_torque() && periods_left_-- > 0) {
    static_cast<void>(exchange());
    static_cast<void>(command({}));
    return;
  }
  take_in();  // room in the transmit queues
  rig_->stop();
  phase_ = RunPhase::closing;
  periods_left_ = closing_periods;
}

void Session::closing_cycle() noexcept {
  take_in();
  if (--periods_left_ == 0) phase_ = RunPhase::ended;
}

/// SYNC, and its answers: until all are in or their share of the period is over.
DeviceSample Session::exchange() noexcept {
  t_bus_ns_ = link_->begin_cycle(motion_time(cycle_));
  if (phase_ == RunPhase::booting) rig_->start(t_bus_ns_);
  rig_->sync(t_bus_ns_);
  t_now_ns_ = t_bus_ns_;
  const Nanoseconds deadline = t_bus_ns_ + gather_ns_;
  do {
    t_now_ns_ = link_->wait(deadline);
    rig_->receive(t_now_ns_);
  } while (!rig_->complete() && t_now_ns_ < deadline);
  return rig_->read(t_now_ns_);
}

CommandReport Session::command(std::span<const Wrench> F_hand_W) noexcept {
  const CommandReport report = rig_->command(F_hand_W, t_now_ns_);
  link_->end_cycle();
  return report;
}

/// A period without SYNC.
void Session::take_in() noexcept {
  t_bus_ns_ = link_->begin_cycle(motion_time(cycle_));
  t_now_ns_ = link_->wait(t_bus_ns_);
  rig_->receive(t_now_ns_);
}

/// To a drive that can still be told otherwise.
bool Session::commands_torque() const noexcept {
  const std::vector<DriveParams>& drives = scene_.device->rig->drives;
  for (std::size_t i = 0; i < rig_->num_drives(); ++i)
    if (rig_->commanded_torque_Nm(i) != 0 && !is_cut_off(link_->buses()[drives[i].bus]->state())) return true;
  return false;
}

RigCounters Session::rig_counters() const noexcept {
  static_assert(sizeof(RigCounters) == 7 * sizeof(std::uint64_t), "every counter is added up here");
  RigCounters sum = earlier_rigs_;
  if (!rig_) return sum;
  const RigCounters& now = rig_->counters();
  sum.syncs += now.syncs;
  sum.incomplete_syncs += now.incomplete_syncs;
  sum.frames += now.frames;
  sum.malformed += now.malformed;
  sum.repeated += now.repeated;
  sum.foreign += now.foreign;
  sum.receive_truncated += now.receive_truncated;
  return sum;
}

}  // namespace godobject
