// What a run came to: one collection of facts, shown as the summary and written as report.json.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "hal/rig/bus_load.h"
#include "platform/cli/run/loop.h"
#include "platform/cli/run/options.h"

namespace godobject {

struct FaultReport {
  std::string name;
  std::string text;          // where, what it means, what to do
  std::uint64_t cycles = 0;  // with this fault; 0: not counted
};

struct BusReport {
  BusLoad computed;
  std::string address;                     // empty: simulated
  std::optional<double> measured_percent;  // mean since the bus was started; of simulated ones
  BusCounters counters;
  std::string slowness;  // see LinuxBus::slowness()
};

/// A tracker at the end of a run.
struct TrackerReportLine {
  TrackerParams params;
  bool is_real = false;  // on params.port
  TrackerReport report;
  std::vector<TrackedPose> tools;  // in the order of params.tools
};

/// A SpaceMouse at the end of a run.
struct SpaceMouseLine {
  std::string socket;
  SpaceMouseCounters counters;
};

struct RunReport {
  const RunOptions& options;
  const Session& session;
  const RunResult& result;
  const LinkTiming* link_timing = nullptr;  // of real buses
  std::vector<BusReport> buses;
  std::vector<TrackerReportLine> trackers;
  std::optional<SpaceMouseLine> spacemouse{};
  std::vector<FaultReport> faults;
  std::optional<Nanoseconds> wall_origin_ns{};  // of real buses: time of day less that of their clock
};

/// losses: outputs that lack something.
RunReport make_report(const RunOptions& options, const PreparedRun& run, const RunResult& result,
                      const std::vector<FileLoss>& losses);

std::string hash_text(std::uint64_t hash);
/// "sim", "direct" or "real".
std::string_view name_of(BusChoice bus) noexcept;

nlohmann::ordered_json to_json(const RunReport& report);
void print_summary(std::FILE* out, const RunReport& report);
/// One line each.
void print_faults(std::FILE* out, const std::vector<FaultReport>& faults);

}  // namespace godobject
