// What a run adds up while it goes: errors, limits, faults. Adding a cycle is real-time.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "platform/cli/fault_texts.h"
#include "platform/rt/histogram.h"
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

/// Bounds that were met on purpose.
inline constexpr std::array<std::string_view, 15> limit_names{
    "force",   "torque",       "force_rate",        "torque_rate",          "ramp",
    "held",    "first_order",  "contact_residual",  "newton_cap",           "substeps",
    "net_cap", "drive_torque", "drive_torque_rate", "drive_internal_limit", "drive_command_not_sent"};

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

/// The worst of a run.
struct ContactStatistics {
  double residual = 0, residual_share = 0, deepest = 0;  // N; of the largest normal force; m
  std::size_t contacts = 0;
  int most_newton_iterations = 0;  // in a step

  void add(const ContactReport& step) noexcept {
    residual = std::max(residual, static_cast<double>(step.residual));
    residual_share = std::max(residual_share, static_cast<double>(step.residual_share));
    deepest = std::max(deepest, static_cast<double>(step.deepest));
    contacts = std::max(contacts, step.num_contacts);
    most_newton_iterations = std::max(most_newton_iterations, step.newton_iterations);
  }
};

struct RunStatistics {
  std::uint64_t cycles = 0;
  Histogram step_ns;  // the engine's step alone
  // Over engaged cycles after the ramp: until then the body is on its way to the target, or let go.
  PoseErrorStatistics following, sensing, exact_following, encoders;
  std::array<std::uint64_t, limit_names.size()> limit_cycles{};       // cycles with that limit
  std::array<std::uint64_t, core_fault_texts.size()> fault_cycles{};  // in the order of core_fault_texts
  RigFault rig_faults = RigFault::none;
  std::uint64_t holds = 0, hold_cycles = 0;  // since too many deadlines were missed
  bool on_hold = false;
  bool force_oscillates = false;
  NetStatistics nets;
  ContactStatistics contacts;
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
    constexpr std::size_t num_core_limits = 11;
    for (std::size_t i = 0; i < num_core_limits; ++i)
      limit_cycles[i] += has(record.limited, Limited(1u << i)) ? 1 : 0;
    const CommandReport& drives = record.drives;
    const std::array bits{drives.torque_limited, drives.rate_limited, drives.drive_limited, drives.not_sent};
    for (std::size_t i = 0; i < bits.size(); ++i) limit_cycles[num_core_limits + i] += bits[i] != 0 ? 1 : 0;
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
    contacts.add(record.contacts);
  }
};

}  // namespace godobject
