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
    "implicit Euler stages in place of TR-BDF2: bodies turn too fast for the step (godobject check says how "
    "fast they may), or contacts and stops come and go; a shorter step helps",
    "the worst contact force misses its law by more than 10 % of the largest: a shorter step, or softer "
    "contacts, "
    "or fewer bodies in one heap",
    "the iterations over sticking, slipping and opening contacts end before they converge: a shorter step, "
    "or "
    "softer contacts",
    "stages are subdivided, to first order, since joints come apart in one piece: a shorter step, or less "
    "contrast "
    "of masses and inertias in the tool",
    "the iteration of nets ends before its tolerance (residual_N of the report is what it leaves): raise "
    "net_iterations, or a shorter step",
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
