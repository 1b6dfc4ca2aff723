#include "platform/cli/run_report.h"

#include <sstream>

namespace godobject {
namespace {

std::string line_of(const FaultText& text) {
  return std::string(text.meaning) + ": " + std::string(text.remedy);
}

void add_run_fault(RunFault fault, std::vector<FaultReport>& faults) {
  faults.push_back({.name = std::string(text_of(fault).name), .text = line_of(text_of(fault))});
}

void add_core_faults(const RunStatistics& statistics, std::vector<FaultReport>& faults) {
  for (std::size_t i = 0; i < core_fault_texts.size(); ++i)
    if (statistics.fault_cycles[i] > 0)
      faults.push_back({.name = std::string(core_fault_texts[i].text.name),
                        .text = line_of(core_fault_texts[i].text),
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
    faults.push_back({.name = std::string(text_of(RunFault::file_incomplete).name),
                      .text = file + " could not be written in full: is the disk full?"});
  const auto lost = [&](const std::string& file, std::uint64_t count) {
    if (!file.empty() && count > 0)
      faults.push_back(
          {.name = std::string(text_of(RunFault::records_lost).name),
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
    if (!result.ready && report.faults.empty()) add_run_fault(RunFault::not_ready, report.faults);
  }
  if (!session.reachable()) add_run_fault(RunFault::unreachable, report.faults);
  add_core_faults(result.statistics, report.faults);
  add_file_faults(report, incomplete_files, report.faults);
  return report;
}

}  // namespace godobject
