// The limits of a run: how often each was met, and what to do where that is often.
#pragma once

#include <string>
#include <vector>

#include "platform/cli/report/statistics.h"

namespace godobject {

/// Percent of the cycles; a limit that is met more often shapes what is felt.
inline constexpr double rarely_percent = 5;

/// In the order of limit_names. Empty: not warned of, since it is met on purpose.
inline constexpr std::array<std::string_view, limit_names.size()> limit_remedies{
    "lower the feedback's stiffness, or raise [device.limits] force as far as the device and the hand bear "
    "it",
    "lower the feedback's rotational stiffness, or raise [device.limits] torque",
    "lower the feedback's damping and stiffness (godobject check prints the margins), or raise "
    "[device.limits] "
    "force_rate",
    "lower the feedback's rotational damping and stiffness (godobject check prints the margins), or raise "
    "[device.limits] torque_rate",
    "",
    "look for what takes the samples away: bus load, cables, a tracker's view",
    "TR-BDF2 falls back to implicit Euler where a body turns faster than godobject check allows, contacts or "
    "stops change, or a net needs more than net_iterations; shorten the step",
    "lower the feedback's gains or [device.limits], or raise torque_max_Nm as far as the motor bears it",
    "lower the feedback's damping and stiffness (godobject check prints the margins), or raise "
    "torque_rate_Nm_per_s",
    "compare the drive's own limits with torque_max_Nm",
    "lower the bus load: godobject check prints it"};

/// Percent of the cycles of the run in which the limit was met.
inline double limit_percent(const RunStatistics& statistics, std::size_t limit) noexcept {
  const double cycles = static_cast<double>(std::max<std::uint64_t>(1, statistics.cycles));
  return 100 * static_cast<double>(statistics.limit_cycles[limit]) / cycles;
}

/// For each limit that was met in more than rarely_percent of the cycles: how often, and what to do.
inline std::vector<std::string> limit_warnings(const RunStatistics& statistics) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < limit_names.size(); ++i) {
    const double percent = limit_percent(statistics, i);
    if (limit_remedies[i].empty() || percent <= rarely_percent) continue;
    std::array<char, 32> share{};
    std::snprintf(share.data(), share.size(), " in %.1f %% of the cycles: ", percent);
    warnings.push_back("limit " + std::string(limit_names[i]) + share.data() +
                       std::string(limit_remedies[i]));
  }
  return warnings;
}

}  // namespace godobject
