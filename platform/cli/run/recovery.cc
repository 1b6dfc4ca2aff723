#include "platform/cli/run/recovery.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include "platform/rt/clock.h"

namespace godobject {
namespace {

constexpr double first_pause_s = 0.1, longest_pause_s = 2;
constexpr int max_simulated_boots = 20;  // simulated time would pass for ever
constexpr std::chrono::milliseconds stop_poll{20}, commissioning_poll{1};

/// What has arrived also says how a bus is. The frames were for a loop that has ended.
void drain(LinuxLink& link) {
  ReceivedFrame ignored;
  for (CanBus* bus : link.buses()) {
    int left = Rig::max_frames_per_receive;
    while (left > 0 && bus->try_receive(ignored)) --left;
  }
}

/// Waits that long, or for `stop`. False: stop.
bool pause(double s, const std::atomic<bool>& stop) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(s);
  do {
    std::this_thread::sleep_for(stop_poll);
  } while (!stop && std::chrono::steady_clock::now() < end);
  return !stop;
}

bool is_pty(const RunLink& real, std::size_t i) { return real.plan.addresses[i].backend->makes_terminal; }

/// A pseudo-terminal is down until its other end is opened, by whoever plays the device.
bool wait_for_other_ends(const RunLink& real, const std::atomic<bool>& stop) {
  for (std::size_t i = 0; i < real.link.num_buses(); ++i)
    if (is_pty(real, i))
      std::fprintf(stderr, "bus %s: waiting for the other end of %s\n", real.rig.buses[i].name.c_str(),
                   real.link.bus(i).name().c_str());
  const auto one_waits = [&] {
    drain(real.link);
    for (std::size_t i = 0; i < real.link.num_buses(); ++i)
      if (is_pty(real, i) && is_cut_off(real.link.bus(i).state())) return true;
    return false;
  };
  while (one_waits())
    if (!pause(0, stop)) return false;
  return true;
}

std::vector<std::string> commission(const RunLink& real, const std::atomic<bool>& stop) {
  Commissioning nodes(real.rig, real.profiles, real.link.buses());
  const MonotonicClock clock;
  while (!nodes.done() && !stop) {
    nodes.poll(clock.now());
    std::this_thread::sleep_for(commissioning_poll);
  }
  return nodes.failed() ? nodes.errors() : std::vector<std::string>{};
}

double pause_after(int tries) {
  return std::min(first_pause_s * std::exp2(std::min(tries, 10)), longest_pause_s);
}

}  // namespace

std::vector<std::string> bring_up(const RunLink& real, const std::atomic<bool>& stop) {
  if (!wait_for_other_ends(real, stop)) return {};
  return commission(real, stop);
}

bool Recoveries::again() {
  note();
  const bool lost = !list_.empty() && !list_.back().recovered_after_s;
  if (!lost || plan_.rearm == Rearm::never || cycle_.left() == 0 || stop_) return false;
  // armed again it would do so again
  if (any(session_.rig()->faults() & (RigFault::force_oscillates | RigFault::energy_gained))) return false;
  Recovery& recovery = list_.back();
  if (recovery.boots == 0)
    tell(RunEventKind::lost, "the device is lost: torque is gone, its nodes are pre-operational",
         "--rearm auto: it is ARMED again as soon as it is back");
  for (bool up = false; !up; ++recovery.boots) {
    if (!real_ && recovery.boots == max_simulated_boots) return false;
    if (!real_) {
      up = true;
    } else if (!pause(pause_after(recovery.boots), stop_) || !reopen()) {
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
  if (real_) recovery.troubles = bus_troubles(real_->link, real_->plan, real_->rig);
  list_.push_back(std::move(recovery));
}

void Recoveries::tell(RunEventKind kind, std::string cause, std::string remedy) {
  const Nanoseconds now = real_ ? MonotonicClock{}.now() : session_.bus_time_ns();
  events_.tell(kind, 1e-9 * static_cast<double>(now - session_.motion_start_ns()), std::move(cause),
               std::move(remedy));
}

bool Recoveries::reopen() {
  LinuxLink& link = real_->link;
  for (int tries = 0; !stop_; ++tries) {
    drain(link);
    bool all_back = true;
    for (std::size_t i = 0; i < link.num_buses(); ++i) {
      LinuxBus& bus = link.bus(i);
      // A pseudo-terminal opened anew would be another one: its other end comes back to this one.
      if (is_cut_off(bus.state()) && !is_pty(*real_, i)) {
        bus.close();
        static_cast<void>(bus.open());  // trouble() says why not
      }
      all_back = all_back && !is_cut_off(bus.state());
    }
    if (all_back) return true;
    if (tries == 0)
      for (const std::string& trouble : bus_troubles(link, real_->plan, real_->rig))
        tell(RunEventKind::trying, trouble, "tried again until it is back");
    if (!pause(pause_after(tries), stop_)) return false;
  }
  return false;
}

}  // namespace godobject
