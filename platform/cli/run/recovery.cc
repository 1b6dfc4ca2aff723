// Recovery between two loops: with --rearm auto, after a fault.
#include "platform/cli/run/loop.h"

#include <algorithm>
#include <cmath>

#include "platform/rt/cyclic.h"

namespace godobject {
namespace {

constexpr double first_pause_s = 0.1, longest_pause_s = 2;
constexpr int max_simulated_boots = 20;  // bound, because simulated time passes without end

double pause_after(int tries) {
  return std::min(first_pause_s * std::exp2(std::min(tries, 10)), longest_pause_s);
}

}  // namespace

bool Recoveries::again() {
  note();
  const bool lost = !list_.empty() && !list_.back().recovered_after_s;
  if (!lost || plan_.rearm == Rearm::never || cycle_.left() == 0 || stop_) return false;
  if (any(session_.rig()->faults() & never_rearmed)) {
    tell(RunEventKind::lost, "the device is lost: the torque is zero, its nodes are pre-operational",
         "--rearm auto does not arm it after this fault: remove the cause and start the run again");
    return false;
  }
  // A drive that failed when enabled, before any step, would fail again.
  if (any(session_.rig()->faults() & RigFault::drive_error) && !cycle_.t_fault_ns()) return false;
  Recovery& recovery = list_.back();
  if (recovery.boots == 0)
    tell(RunEventKind::lost, "the device is lost: the torque is zero, its nodes are pre-operational",
         "--rearm auto ARMS it again as soon as it is back");
  for (bool up = false; !up; ++recovery.boots) {
    if (!real_ && recovery.boots == max_simulated_boots) return false;
    if (!wait(pause_after(recovery.boots))) return false;
    if (!real_) {
      up = true;
    } else if (!reopen()) {
      return false;
    } else {
      const std::vector<std::string> not_set_up = commission(*real_, stop_);
      up = not_set_up.empty();
      for (const std::string& node : not_set_up) tell(RunEventKind::trying, node, "tried again");
    }
  }
  tell(RunEventKind::trying, "boot " + std::to_string(recovery.boots) + " of the nodes begins", "");
  cycle_.restart();
  session_.restart();
  return true;
}

void Recoveries::note() {
  const auto since_start = [&](Nanoseconds t) {
    return 1e-9 * static_cast<double>(t - session_.motion_start_ns());
  };
  if (!list_.empty() && !list_.back().recovered_after_s && cycle_.t_first_step_ns())
    list_.back().recovered_after_s = since_start(*cycle_.t_first_step_ns()) - list_.back().seen_s;
  if (!cycle_.t_fault_ns()) return;
  Recovery recovery{.seen_s = since_start(*cycle_.t_fault_ns()),
                    .named = session_.rig()->fault_text(),
                    .troubles = {},
                    .boots = 0,
                    .recovered_after_s = std::nullopt};
  if (real_) recovery.troubles = bus_troubles(real_->link, real_->where, real_->rig);
  list_.push_back(std::move(recovery));
}

void Recoveries::tell(RunEventKind kind, std::string cause, std::string remedy) {
  const Nanoseconds now = real_ ? MonotonicClock{}.now() : session_.bus_time_ns();
  events_.tell(kind, 1e-9 * static_cast<double>(now - session_.motion_start_ns()), std::move(cause),
               std::move(remedy));
}

// Lets a time pass on the clock of the buses. A log has the pauses of its own host. Returns false to stop.
bool Recoveries::wait(double time_s) {
  if (real_) return pause(time_s, stop_);
  CycleRecord none;
  if (!plan_.log)
    for (double s = 0; s < time_s && !stop_; s += session_.scene().step)
      static_cast<void>(session_.advance(none));
  return !stop_;
}

bool Recoveries::reopen() {
  LinuxLink& link = real_->link;
  for (int tries = 0; !stop_; ++tries) {
    drain(link);
    bool all_back = true;
    for (std::size_t i = 0; i < link.num_buses(); ++i) {
      LinuxBus& bus = link.bus(i);
      // A pseudo-terminal is not opened again: it would be a new one, while the other end returns to this
      // one.
      if (is_cut_off(bus.state()) && !real_->has_other_end(i)) {
        bus.close();
        static_cast<void>(bus.open());  // trouble() has the reason
      }
      all_back = all_back && !is_cut_off(bus.state());
    }
    if (all_back) return true;
    if (tries == 0)
      for (const std::string& trouble : bus_troubles(link, real_->where, real_->rig))
        tell(RunEventKind::trying, trouble, "opened again until it is back");
    if (!pause(pause_after(tries), stop_)) return false;
  }
  return false;
}

}  // namespace godobject
