// Limits of a run: intended bounds of the core, the loop and the drives.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "platform/session/record.h"

namespace godobject {

struct RunLimit {
  std::string_view name;                           // name in the summary, the report and the view
  bool (*is_active)(const CycleRecord&) noexcept;  // true if the limit was active in this cycle
  std::string_view remedy;  // for a run in which the limit is often active; empty: no warning
};

template <Limited bit>
bool core_limited(const CycleRecord& record) noexcept {
  return has(record.limited, bit);
}

template <std::uint32_t CommandReport::*drives>
bool drives_limited(const CycleRecord& record) noexcept {
  return record.drives.*drives != 0;
}

/// List of all limits: statistics, report, summary and view take names, order and remedies from here.
inline constexpr std::array run_limits{
    RunLimit{"force", core_limited<Limited::force>,
             "lower the feedback's stiffness, or raise [device.limits] force as far as the device and the "
             "hand bear it"},
    RunLimit{"torque", core_limited<Limited::torque>,
             "lower the feedback's rotational stiffness, or raise [device.limits] torque as far as the "
             "device and the hand "
             "bear it"},
    RunLimit{"force_rate", core_limited<Limited::force_rate>,
             "lower the feedback's damping and stiffness (godobject check prints the margins), or raise "
             "[device.limits] "
             "force_rate"},
    RunLimit{"torque_rate", core_limited<Limited::torque_rate>,
             "lower the feedback's rotational damping and stiffness (godobject check prints the margins), or "
             "raise "
             "[device.limits] torque_rate"},
    RunLimit{"ramp", core_limited<Limited::ramp>, ""},
    RunLimit{"held",
             [](const CycleRecord& record) noexcept {
               return has(record.limited, Limited::held) && !record.on_hold;
             },
             "find the cause of the missing samples: bus load, cables, a tracker's view of its tools"},
    RunLimit{"deadlines", [](const CycleRecord& record) noexcept { return record.on_hold; },
             "use a longer step, a faster machine or a real-time kernel: the loop missed its deadlines, and "
             "the pose was held "
             "meanwhile"},
    RunLimit{
        "first_order", core_limited<Limited::first_order>,
        "shorten the step, or raise net_iterations where limit net_cap is met too: TR-BDF2 falls back to "
        "implicit Euler where a body turns faster than godobject check allows, or contacts or stops change"},
    RunLimit{"contact_residual", core_limited<Limited::contact_residual>,
             "shorten the step, soften contacts, or put fewer bodies into one heap: a contact force misses "
             "its law by more than 10 % "
             "of the largest"},
    RunLimit{"newton_cap", core_limited<Limited::newton_cap>,
             "shorten the step or soften contacts: the iterations over sticking, slipping and opening "
             "contacts end before they "
             "converge"},
    RunLimit{"substeps", core_limited<Limited::substeps>,
             "shorten the step or lower the contrast of masses and inertias in the tool: stages are "
             "subdivided, to first order, "
             "because joints come apart otherwise"},
    RunLimit{
        "net_cap", core_limited<Limited::net_cap>,
        "raise net_iterations: the iteration of nets ends before its tolerance (residual_N of the report)"},
    RunLimit{
        "drive_torque", drives_limited<&CommandReport::torque_limited>,
        "lower the feedback's gains or [device.limits], or raise torque_max_Nm as far as the motor bears it"},
    RunLimit{"drive_torque_rate", drives_limited<&CommandReport::rate_limited>,
             "lower the feedback's damping and stiffness (godobject check prints the margins), or raise "
             "torque_rate_Nm_per_s"},
    RunLimit{"drive_internal_limit", drives_limited<&CommandReport::drive_limited>,
             "compare the drive's own limits with torque_max_Nm"},
    RunLimit{"drive_command_not_sent", drives_limited<&CommandReport::not_sent>,
             "lower the bus load: godobject check prints it"}};

/// Returns one bit for each entry of run_limits, set if the limit was active in this cycle.
inline std::uint32_t active_limits(const CycleRecord& record) noexcept {
  std::uint32_t bits = 0;
  for (std::size_t i = 0; i < run_limits.size(); ++i)
    bits |= (run_limits[i].is_active(record) ? 1u : 0u) << i;
  return bits;
}

}  // namespace godobject
