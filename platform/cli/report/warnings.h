// The warnings of a run: the same lines in its summary and in its report.
#pragma once

#include <string>
#include <vector>

#include "platform/cli/report/report.h"

namespace godobject {

/// Returns in how many percent of the cycles the limit was active.
double limit_percent(const RunStatistics& statistics, std::size_t limit) noexcept;

/// Returns a warning if more than one cycle in a thousand took longer than its period; empty otherwise.
std::string slow_scene_warning(const CyclicStatistics& timing, const Histogram& step_ns, double period_s);

/// Returns the warnings of a run that has ended, each with its remedy.
std::vector<std::string> run_warnings(const RunReport& report);

}  // namespace godobject
