// Session: the phases of a run, one period at a time.
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
  phase_ = rig_ || trackers_ ? RunPhase::booting : RunPhase::running;
  if (trackers_)
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
  if (rig_ && phase_ == RunPhase::running_down) rig_->rig().quick_stop();
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
  if (rig_) rig_->rig().deadlines_missed();
}

void Session::restart() {
  if (phase_ != RunPhase::ended) return;
  phase_ = RunPhase::off;
  on_hold_ = deadlines_missed_ = false;
  if (!rig_) return;
  rig_->restart();
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

Period& Session::begin_period() noexcept {
  t_before_ns_ = period_.began;
  period_.t = motion_time();
  period_.has_begun = false;
  return period_;
}

void Session::boot_cycle() noexcept {
  Period& period = begin_period();
  for (HandDevice* const device : devices_) device->boot(period);
  if (cycle_ == 0) motion_start_ns_ = period.began;
  if (arm()) {
    phase_ = RunPhase::running;
  } else if (failed() || --periods_left_ <= 0) {
    give_up_running();
  }
}

/// None is armed before all are ready.
bool Session::arm() noexcept {
  return std::ranges::all_of(devices_, [](const HandDevice* device) { return device->ready(); }) &&
         std::ranges::all_of(devices_, [](HandDevice* device) { return device->arm(); });
}

bool Session::failed() noexcept {
  return std::ranges::any_of(devices_, [](const HandDevice* device) { return device->failed(); });
}

void Session::run_down_cycle() noexcept {
  Period& period = begin_period();
  if (periods_left_-- > 0 && rig_->run_down(period)) return;
  rig_->stop(period);
  phase_ = RunPhase::closing;
  periods_left_ = closing_periods;
}

void Session::closing_cycle() noexcept {
  rig_->close(begin_period());
  if (--periods_left_ == 0) phase_ = RunPhase::ended;
}

}  // namespace godobject
