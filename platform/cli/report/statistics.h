// What a run adds up while it goes: errors, limits, faults. Adding a cycle is real-time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "platform/cli/fault_texts.h"
#include "platform/rt/histogram.h"
#include "platform/session/limits.h"
#include "platform/session/session.h"

namespace godobject {

/// Root mean square and largest value of a pose error.
class PoseErrorStatistics {
 public:
  void add(const PoseError& e) noexcept {
    ++count_;
    sum_sq_.m += e.m * e.m;
    sum_sq_.rad += e.rad * e.rad;
    max_ = {.m = std::max(max_.m, e.m), .rad = std::max(max_.rad, e.rad)};
  }

  std::uint64_t count() const noexcept { return count_; }
  const PoseError& max() const noexcept { return max_; }
  PoseError rms() const noexcept {
    const double n = count_ > 0 ? static_cast<double>(count_) : 1;
    return {.m = std::sqrt(sum_sq_.m / n), .rad = std::sqrt(sum_sq_.rad / n)};
  }

 private:
  std::uint64_t count_ = 0;
  PoseError sum_sq_, max_;
};

/// The worst of a run.
struct NetStatistics {
  double stretch = 0, deepest = 0, residual = 0;  // l / l_0; m; N
  std::size_t contacts = 0;
  std::uint64_t iterations = 0;  // in all
  int most_iterations = 0;       // in a step

  void add(const NetReport& net, double stretch_now) noexcept {
    stretch = std::max(stretch, stretch_now);
    deepest = std::max(deepest, static_cast<double>(net.deepest));
    residual = std::max(residual, static_cast<double>(net.residual));
    contacts = std::max(contacts, net.num_contacts);
    iterations += static_cast<std::uint64_t>(net.iterations);
    most_iterations = std::max(most_iterations, net.iterations);
  }
};

struct RunStatistics {
  std::uint64_t cycles = 0;
  Histogram step_ns;  // the engine's step alone
  // Over engaged cycles after the ramp: until then the body is on its way to the target, or let go.
  PoseErrorStatistics following, sensing, exact_following, encoders;
  std::array<std::uint64_t, run_limits.size()> limit_cycles{};        // cycles with that limit
  std::array<std::uint64_t, core_fault_texts.size()> fault_cycles{};  // in the order of core_fault_texts
  RigFault rig_faults = RigFault::none;
  std::uint64_t holds = 0, hold_cycles = 0;  // since too many deadlines were missed
  bool on_hold = false;
  bool force_oscillates = false;
  NetStatistics nets;
  EnergyReport gain;  // where the share gained of the energy at work was largest

  void add(const CycleRecord& record) noexcept {
    ++cycles;
    step_ns.add(record.step_ns);
    if (record.engaged && !has(record.limited, Limited::ramp)) {
      following.add(record.following);
      sensing.add(record.sensing);
      exact_following.add(record.exact_following);
      encoders.add(record.encoders);
    }
    const std::uint32_t active = active_limits(record);
    for (std::size_t i = 0; i < run_limits.size(); ++i) limit_cycles[i] += active >> i & 1u;
    for (std::size_t i = 0; i < core_fault_texts.size(); ++i)
      fault_cycles[i] += has(record.fault, core_fault_texts[i].fault) ? 1 : 0;
    rig_faults = rig_faults | record.rig_faults;
    if (record.on_hold && !on_hold) ++holds;
    if (record.on_hold) ++hold_cycles;
    on_hold = record.on_hold;
    if (record.energy.gained > gain_floor &&
        record.energy.gained * gain.at_work >= gain.gained * record.energy.at_work)
      gain = record.energy;
    force_oscillates = force_oscillates || record.force_oscillates;
    nets.add(record.nets, record.net_stretch);
  }
};

}  // namespace godobject
