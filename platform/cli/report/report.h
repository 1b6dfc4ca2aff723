// Report of a run: one collection of facts, printed as the summary and written as report.json, with the same
// warnings.
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
  std::string text;          // place, meaning and remedy
  std::uint64_t cycles = 0;  // number of cycles with this fault; 0: not counted
};

struct BusReport {
  BusLoad computed;
  std::string address;                     // empty: simulated
  std::optional<double> measured_percent;  // mean since the bus was started; simulated buses only
  BusCounters counters;
  std::string slowness;  // see LinuxBus::slowness()
};

/// State of a tracker at the end of a run.
struct TrackerReportLine {
  TrackerParams params;
  bool is_real = false;  // true if on params.port
  TrackerReport report;
  std::vector<TrackedPose> tools;  // in the order of params.tools
};

/// State of a SpaceMouse at the end of a run.
struct SpaceMouseLine {
  std::string socket;
  SpaceMouseCounters counters;
};

/// State of a program that is the device at the end of a run.
struct SocketDeviceLine {
  std::string socket;
  SocketDeviceCounters counters;
};

/// State of another simulation that surrounds the tool, at the end of a run.
struct WorldLine {
  std::string name;
  WorldCounters counters;  // malformed: also packets with a wrong CRC
};

struct RunReport {
  const RunOptions& options;
  const Session& session;
  const RunResult& result;
  const LinkTiming* link_timing = nullptr;  // real buses only
  std::vector<BusReport> buses;
  std::vector<TrackerReportLine> trackers;
  std::optional<SpaceMouseLine> spacemouse{};
  std::optional<SocketDeviceLine> socket_device{};
  std::optional<WorldLine> world{};
  std::vector<FaultReport> faults;
  std::vector<FaultFile> fault_files{};
  std::optional<Nanoseconds> wall_origin_ns{};  // real buses only: time of day minus time of their clock
};

/// losses: incomplete output files.
RunReport make_report(const RunOptions& options, const PreparedRun& run, const RunResult& result,
                      const std::vector<FileLoss>& losses);

std::string hash_text(std::uint64_t hash);
/// Returns "sim", "direct" or "real".
std::string_view name_of(BusChoice bus) noexcept;

nlohmann::ordered_json to_json(const RunReport& report);
void print_summary(std::FILE* out, const RunReport& report);
/// Prints one line per fault.
void print_faults(std::FILE* out, const std::vector<FaultReport>& faults);

/// Returns in how many percent of the cycles the limit was active.
double limit_percent(const RunStatistics& statistics, std::size_t limit) noexcept;

/// Returns a warning if more than one cycle in a thousand took longer than its period; empty otherwise.
std::string slow_scene_warning(const CyclicStatistics& timing, const Histogram& step_ns, double period_s);

/// Returns the warnings of a run that has ended, each with its remedy.
std::vector<std::string> run_warnings(const RunReport& report);

}  // namespace godobject
