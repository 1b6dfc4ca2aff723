#include "platform/cli/run_report.h"

#include <sstream>

namespace godobject {
namespace {

void add_core_faults(const RunStatistics& statistics, std::vector<FaultReport>& faults) {
  for (std::size_t i = 0; i < fault_names.size(); ++i)
    if (statistics.fault_cycles[i] > 0)
      faults.push_back({.name = std::string(fault_names[i].name),
                        .text = std::string(fault_names[i].meaning),
                        .cycles = statistics.fault_cycles[i]});
}

/// Rig::fault_text() has one line per set bit, in the order of the bits.
void add_rig_faults(const Rig& rig, std::vector<FaultReport>& faults) {
  std::istringstream lines(rig.fault_text());
  for (const RigFaultText& text : rig_fault_texts()) {
    if (!any(rig.faults() & text.fault)) continue;
    FaultReport fault{.name = std::string(text.name), .text = ""};
    std::getline(lines, fault.text);
    fault.text.erase(0, fault.name.size() + 1);
    faults.push_back(std::move(fault));
  }
}

void add_file_faults(const RunReport& report, const std::vector<std::string>& incomplete_files,
                     std::vector<FaultReport>& faults) {
  for (const std::string& file : incomplete_files)
    faults.push_back(
        {.name = "file_incomplete", .text = file + " could not be written in full: is the disk full?"});
  const auto lost = [&](const std::string& file, std::uint64_t count) {
    if (!file.empty() && count > 0)
      faults.push_back(
          {.name = "records_lost",
           .text = file + " lacks " + std::to_string(count) + " records: the disk could not keep up"});
  };
  lost(report.options.trace, report.result.lost_cycles);
  lost(report.options.record, report.result.lost_frames);
}

}  // namespace

RunReport make_report(const RunOptions& options, const Session& session, const RunResult& result,
                      const std::vector<std::string>& incomplete_files) {
  RunReport report{.options = options, .session = session, .result = result, .buses = {}, .faults = {}};
  if (const Rig* rig = session.rig()) {
    const std::vector<double> measured = session.bus_load_percent();
    const RigParams& rig_params = *session.scene().device->rig;
    const std::vector<BusLoad> computed = bus_load(rig_params, simulated_load(rig_params));
    for (std::size_t i = 0; i < computed.size(); ++i) report.buses.push_back({computed[i], measured[i]});
    add_rig_faults(*rig, report.faults);
    if (!result.ready && report.faults.empty())
      report.faults.push_back(
          {.name = "not_ready", .text = "the device did not come up in time: see boot_timeout"});
  }
  if (!session.reachable())
    report.faults.push_back({.name = "unreachable",
                             .text = "the motion left the workspace of the device, or met a singular "
                                     "configuration: move the device's base, or scale the motion"});
  add_core_faults(result.statistics, report.faults);
  add_file_faults(report, incomplete_files, report.faults);
  return report;
}

}  // namespace godobject
