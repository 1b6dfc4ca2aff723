#include "platform/cli/report/warnings.h"

namespace godobject {
namespace {

/// Share above which a limit shapes the displayed force, %.
constexpr double rarely_percent = 5;

void add_limit_warnings(const RunStatistics& statistics, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < run_limits.size(); ++i) {
    const double percent = limit_percent(statistics, i);
    if (run_limits[i].remedy.empty() || percent <= rarely_percent) continue;
    std::array<char, 32> share{};
    std::snprintf(share.data(), share.size(), " in %.1f %% of the cycles: ", percent);
    warnings.push_back("limit " + std::string(run_limits[i].name) + share.data() +
                       std::string(run_limits[i].remedy));
  }
}

}  // namespace

double limit_percent(const RunStatistics& statistics, std::size_t limit) noexcept {
  const double cycles = static_cast<double>(std::max<std::uint64_t>(1, statistics.cycles));
  return 100 * static_cast<double>(statistics.limit_cycles[limit]) / cycles;
}

std::string slow_scene_warning(const CyclicStatistics& timing, const Histogram& step_ns, double period_s) {
  constexpr double share = 0.999;
  const double cycle_s = 1e-9 * static_cast<double>(timing.compute_ns.percentile(share));
  if (cycle_s <= period_s) return {};
  const double step_s = 1e-9 * static_cast<double>(step_ns.percentile(share));
  const char* const remedy =
      step_s > period_s / 2
          ? "the scene is too slow for this machine; use a longer [scene] step, fewer nodes, spheres or "
            "net_iterations"
          : "other programs, the buses or the simulated device use the time: end other programs; see "
            "docs/running.md";
  std::array<char, 320> text{};
  std::snprintf(
      text.data(), text.size(),
      "one cycle in a thousand takes %.3g ms or more, the period is %.3g ms (the step alone: %.3g ms): %s",
      1e3 * cycle_s, 1e3 * period_s, 1e3 * step_s, remedy);
  return text.data();
}

std::vector<std::string> run_warnings(const RunReport& report) {
  std::vector<std::string> warnings;
  add_limit_warnings(report.result.statistics, warnings);
  if (report.options.realtime) {
    const std::string slow = slow_scene_warning(report.result.timing, report.result.statistics.step_ns,
                                                report.session.scene().step);
    if (!slow.empty()) warnings.push_back(slow);
  }
  return warnings;
}

}  // namespace godobject
