#include "platform/cli/report/report.h"

#include <algorithm>
#include <array>
#include <cinttypes>
#include <cstdio>
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

/// Adds a fault for each line of Rig::fault_text().
/// troubles: texts of the buses, which explain bus_down and send_refused.
void add_rig_faults(const Rig& rig, const std::vector<std::string>& troubles,
                    std::vector<FaultReport>& faults) {
  std::istringstream lines(rig.fault_text());
  bool explained = false;
  for (const RigFaultRecord& record : rig.fault_log().records()) {
    FaultReport fault{.name = std::string(text_of(record.place.fault).name), .text = ""};
    std::getline(lines, fault.text);
    fault.text.erase(0, fault.name.size() + 1);
    const bool of_bus = any(record.place.fault & (RigFault::bus_down | RigFault::send_refused));
    if (of_bus && !explained)
      for (const std::string& trouble : troubles) fault.text += " " + trouble;
    explained = explained || of_bus;
    faults.push_back(std::move(fault));
  }
}

/// Adds the faults before each re-arming, which the present rig does not record.
void add_recoveries(const std::vector<Recovery>& recoveries, std::vector<FaultReport>& faults) {
  for (const Recovery& recovery : recoveries) {
    if (!recovery.recovered_after_s) continue;
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(), "seen at %.3f s, armed again after %.3f s: ", recovery.seen_s,
                  *recovery.recovered_after_s);
    FaultReport fault{.name = std::string(text_of(RunFault::recovered).name),
                      .text = text.data() + recovery.named};
    std::ranges::replace(fault.text, '\n', ' ');
    for (const std::string& trouble : recovery.troubles) fault.text += trouble + " ";
    faults.push_back(std::move(fault));
  }
}

/// Adds the fault `held` if the pose was held for too long, with its causes and the slowness of the buses.
void add_held(const RunReport& report, std::vector<FaultReport>& faults) {
  const RunStatistics& statistics = report.result.statistics;
  // Samples are not counted after a fault of the rig, which is reported itself and begins with missing
  // samples. They are not counted for trackers, whose tools may be hidden.
  const bool counts_samples = report.session.rig() != nullptr && !any(statistics.rig_faults);
  const std::uint64_t held_cycles = counts_samples ? statistics.held_cycles : statistics.hold_cycles;
  const auto held = static_cast<double>(held_cycles), cycles = static_cast<double>(statistics.cycles);
  if (held <= RunStatistics::max_held * cycles) return;
  std::array<char, 160> share{};
  std::snprintf(
      share.data(), share.size(),
      "%.0f of %.0f cycles (%.1f %%), %" PRIu64 " after missed deadlines, %" PRIu64 " for want of a sample: ",
      held, cycles, 100 * held / cycles, statistics.hold_cycles, held_cycles - statistics.hold_cycles);
  FaultReport fault{.name = std::string(text_of(RunFault::held).name),
                    .text = share.data() + line_of(text_of(RunFault::held)),
                    .cycles = held_cycles};
  for (const BusReport& bus : report.buses)
    if (!bus.slowness.empty()) fault.text += "; bus " + bus.computed.bus + ": " + bus.slowness;
  faults.push_back(std::move(fault));
}

void add_not_ready(const RunReport& report, std::vector<FaultReport>& faults) {
  for (const std::string& node : report.result.not_set_up)
    faults.push_back({.name = std::string(text_of(RunFault::not_set_up).name), .text = node});
  if (faults.empty() && report.result.stopped_by.empty()) add_run_fault(RunFault::not_ready, faults);
}

void add_file_faults(const RunReport& report, const std::vector<FileLoss>& losses,
                     std::vector<FaultReport>& faults) {
  std::uint64_t lost_rows = report.result.lost_cycles, lost_frames = report.result.lost_frames;
  std::uint64_t lost_inputs = report.result.lost_cycles;
  const auto lost = [&](const std::string& file, std::uint64_t count) {
    if (!file.empty() && count > 0)
      faults.push_back(
          {.name = std::string(text_of(RunFault::records_lost).name),
           .text = file + " lacks " + std::to_string(count) + " records: the disk could not keep up"});
  };
  for (const FileLoss& loss : losses) {
    if (loss.why.empty() && is_input_log(loss.path)) {
      if (loss.path == report.options.files.inputs) lost_inputs += loss.lost_lines;
      else lost(loss.path, loss.lost_lines);
      continue;
    }
    if (loss.why.empty()) {
      (loss.path == report.options.files.record ? lost_frames : lost_rows) += loss.lost_lines;
      continue;
    }
    faults.push_back({.name = std::string(text_of(RunFault::file_incomplete).name),
                      .text = loss.path + " could not be written in full: " + loss.why + "; it lacks " +
                              std::to_string(loss.lost_lines) + " lines"});
  }
  lost(report.options.files.trace, lost_rows);
  lost(report.options.files.contacts, lost_rows);
  lost(report.options.files.record, lost_frames);
  lost(report.options.files.inputs, lost_inputs);
}

std::vector<TrackerReportLine> tracker_reports(const Session& session) {
  std::vector<TrackerReportLine> lines;
  const TrackedPoses* const trackers = session.trackers();
  std::size_t tool = 0;
  for (std::size_t i = 0; trackers && i < trackers->num_trackers(); ++i) {
    lines.push_back({.params = trackers->params(i),
                     .is_real = session.bus() == BusChoice::real,
                     .report = trackers->report(i),
                     .tools = {}});
    for (std::size_t k = 0; k < lines.back().params.tools.size(); ++k)
      lines.back().tools.push_back(trackers->poses()[tool++]);
  }
  return lines;
}

void add_trackers_not_ready(const RunReport& report, std::vector<FaultReport>& faults) {
  for (const TrackerReportLine& tracker : report.trackers)
    if (tracker.report.state != TrackerState::tracking && report.result.stopped_by.empty())
      faults.push_back({.name = std::string(text_of(RunFault::tracker_not_ready).name),
                        .text = "tracker " + tracker.params.name + " (" +
                                (tracker.is_real ? tracker.params.port : "simulated") + "), " +
                                name(tracker.report.state) + ": " + tracker.report.text.data()});
}

std::vector<BusReport> bus_reports(const PreparedRun& run) {
  const SceneConfig& scene = run.session->scene();
  const RigParams& rig = *scene.device->rig;
  std::vector<BusReport> reports;
  const Truth* const truth = run.session->truth();
  const std::vector<double> measured = truth != nullptr ? truth->bus_load_percent() : std::vector<double>{};
  const std::vector<BusLoad> computed = bus_load(rig, scene.step, usual_load(rig));
  for (std::size_t i = 0; i < computed.size(); ++i)
    reports.push_back({.computed = computed[i],
                       .address = run.link || run.log ? run.buses.real.texts[i] : "",
                       .measured_percent = truth ? std::optional(measured[i]) : std::nullopt,
                       .counters = run.session->host_buses()[i]->counters(),
                       .slowness = run.link ? run.link->bus(i).slowness() : ""});
  return reports;
}

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

RunReport make_report(const RunOptions& options, const PreparedRun& run, const RunResult& result,
                      const std::vector<FileLoss>& losses) {
  const Session& session = *run.session;
  RunReport report{.options = options,
                   .session = session,
                   .result = result,
                   .link_timing = run.link ? &run.link->timing() : nullptr,
                   .buses = {},
                   .trackers = tracker_reports(session),
                   .faults = {}};
  if (const SpaceMouseThread* const mouse = run.spacemouse_thread.get())
    report.spacemouse = {.socket = mouse->socket(), .counters = mouse->counters()};
  if (const SocketDevice* const device = run.socket_device.get())
    report.socket_device = {.socket = device->path(), .counters = device->counters()};
  if (run.world) {
    report.world = {.name = run.shared_world->name(), .counters = run.world->counters()};
    report.world->counters.malformed += run.shared_world->broken();
  }
  if (const Rig* rig = session.rig()) {
    const RigParams& params = *session.scene().device->rig;
    report.buses = bus_reports(run);
    add_recoveries(result.recoveries, report.faults);
    const std::vector<std::string> troubles =
        run.link ? bus_troubles(*run.link, run.buses.real, params) : std::vector<std::string>{};
    add_rig_faults(*rig, troubles, report.faults);
  }
  if (!result.ready && (session.rig() || session.trackers())) {
    add_trackers_not_ready(report, report.faults);
    add_not_ready(report, report.faults);
  }
  if (session.truth() != nullptr && !session.truth()->reachable())
    add_run_fault(RunFault::unreachable, report.faults);
  if (session.missed_deadlines() && !session.rig()) add_run_fault(RunFault::deadlines_missed, report.faults);
  if (result.statistics.force_oscillates && !session.rig())
    add_run_fault(RunFault::force_oscillates, report.faults);
  if (session.bus() == BusChoice::real && !run.log) add_held(report, report.faults);
  if (!result.seal_broken.empty())
    report.faults.push_back(
        {.name = std::string(text_of(RunFault::seal_broken).name),
         .text = result.seal_broken + "; " + std::string(text_of(RunFault::seal_broken).remedy),
         .cycles = result.refused_calls});
  add_core_faults(result.statistics, report.faults);
  add_file_faults(report, losses, report.faults);
  return report;
}

double limit_percent(const RunStatistics& statistics, std::size_t limit) noexcept {
  const double cycles = static_cast<double>(std::max<std::uint64_t>(1, statistics.cycles));
  return 100 * static_cast<double>(statistics.limit_cycles[limit]) / cycles;
}

std::string slow_scene_warning(const CyclicStatistics& timing, const Histogram& step_ns, double period_s) {
  constexpr double share = 0.999;
  const double cycle_s = 1e-9 * static_cast<double>(timing.cycle_ns.percentile(share));
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
    const std::string slow = slow_scene_warning(report.result.timing, report.result.statistics.step_ns(),
                                                report.session.scene().step);
    if (!slow.empty()) warnings.push_back(slow);
  }
  return warnings;
}

}  // namespace godobject
