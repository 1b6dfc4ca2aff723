// Buses of a simulated rig, on their own clock.
#pragma once

#include "hal/rig/link.h"
#include "sim/rig/rig.h"

namespace godobject {

/// Time advances only in its calls: begin_cycle() by one cycle since the previous one, wait() by one poll.
class SimLink final : public RigLink {
 public:
  /// SimRig::why_not() must be empty. cycle_s: s. Allocates; no other function does.
  SimLink(const SimRigConfig& config, double cycle_s, std::shared_ptr<const Hand> hand, Nanoseconds poll,
          const RigProfiles& profiles = {})
      : rig_(config, cycle_s, std::move(hand), profiles), period_ns_(to_ns(cycle_s)), poll_ns_(poll) {}

  std::span<CanBus* const> buses() noexcept override { return rig_.host_buses(); }
  /// Runs the rest of the last period, including the mechanics up to its end.
  Nanoseconds begin_cycle(double motion_time) noexcept override {
    t_cycle_ns_ += period_ns_;
    rig_.run_wires(t_cycle_ns_ - 1);
    rig_.run_plant(t_cycle_ns_, motion_time);
    t_now_ns_ = t_cycle_ns_;
    return t_now_ns_;
  }
  Nanoseconds wait(Nanoseconds until) noexcept override {
    t_now_ns_ = std::min(t_now_ns_ + poll_ns_, until);
    rig_.run_wires(t_now_ns_);
    return t_now_ns_;
  }
  void set_observer(const BusObserver& observer) noexcept override { rig_.set_observer(observer); }

  SimRig& rig() noexcept { return rig_; }
  const SimRig& rig() const noexcept { return rig_; }
  /// Returns the mean load of a bus since the start, percent.
  double load_percent(std::size_t bus) const noexcept { return rig_.load_percent(bus, t_cycle_ns_); }

 private:
  SimRig rig_;
  Nanoseconds period_ns_;
  Nanoseconds poll_ns_;
  Nanoseconds t_cycle_ns_ = 0;
  Nanoseconds t_now_ns_ = 0;
};

}  // namespace godobject
