// Summary at the end of a run.
#include "platform/cli/report/report.h"

#include <array>
#include <cinttypes>

namespace godobject {
namespace {

void print_timing(std::FILE* out, const char* label, const Histogram& h) {
  if (h.count() == 0) return;
  const auto us = [&](double share) { return 1e-3 * static_cast<double>(h.percentile(share)); };
  std::fprintf(out, "  %-26s p50 %.1f, p99 %.1f, p99.9 %.1f, max %.1f us\n", label, us(0.5), us(0.99),
               us(0.999), 1e-3 * static_cast<double>(h.max()));
}

/// Prints the time of a cycle, that of its stages without the wait for the device, and each stage.
void print_stages(std::FILE* out, const RunResult& result) {
  print_timing(out, "cycle", result.timing.cycle_ns);
  print_timing(out, "compute", result.statistics.compute_ns);
  for (std::size_t i = 0; i < stage_names.size(); ++i)
    print_timing(out, ("  " + std::string(stage_names[i])).c_str(), result.statistics.stage_ns[i]);
}

void print_error(std::FILE* out, const char* label, const PoseErrorStatistics& e) {
  if (e.count() == 0) {
    std::fprintf(out, "  %-26s not measured: no cycle was engaged with the ramp complete\n", label);
    return;
  }
  std::fprintf(out, "  %-26s rms %.3g m, max %.3g m; rms %.3g rad, max %.3g rad\n", label, e.rms().m,
               e.max().m, e.rms().rad, e.max().rad);
}

void print_errors(std::FILE* out, const RunReport& report) {
  if (!report.session.follows()) return;
  const RunStatistics& statistics = report.result.statistics;
  if (report.session.bus() == BusChoice::real)
    std::fprintf(out, "  %-26s none known: errors are relative to the core's target\n", "truth");
  print_error(out, "following error", statistics.following);
  if (report.session.bus() != BusChoice::sim || statistics.following.count() == 0) return;
  print_error(out, report.session.rig() ? "  with no encoders" : "  with no trackers",
              statistics.exact_following);
  print_error(out, report.session.rig() ? "  encoders add" : "  trackers add", statistics.encoders);
  print_error(out, "sensing error", statistics.sensing);
}

void print_limits(std::FILE* out, const RunStatistics& statistics) {
  std::fprintf(out, "  %-26s", "limits hit");
  bool any_hit = false;
  for (std::size_t i = 0; i < run_limits.size(); ++i) {
    if (statistics.limit_cycles[i] == 0) continue;
    std::fprintf(out, "%s %s %" PRIu64 " cycles (%.1f %%)", any_hit ? "," : "",
                 std::string(run_limits[i].name).c_str(), statistics.limit_cycles[i],
                 limit_percent(statistics, i));
    any_hit = true;
  }
  std::fprintf(out, "%s\n", any_hit ? "" : " none");
}

void print_nets(std::FILE* out, const RunReport& report) {
  const SceneNets& nets = report.session.engine().nets();
  if (nets.nodes.empty()) return;
  const NetStatistics& n = report.result.statistics.nets;
  const double cycles = static_cast<double>(std::max<std::uint64_t>(report.result.statistics.cycles, 1));
  std::fprintf(out,
               "  %-26s %zu nodes, %zu springs; stretched to %.4g at most; %zu contacts at most, %.3g m "
               "deep; %.1f iterations a step, %d at most, residual of forces %.3g N\n",
               "nets", nets.nodes.size(), nets.springs.size(), n.stretch, n.contacts, n.deepest,
               static_cast<double>(n.iterations) / cycles, n.most_iterations, n.residual);
}

void print_bus(std::FILE* out, const BusReport& bus) {
  const char* const name = bus.computed.bus.c_str();
  if (bus.measured_percent)
    std::fprintf(out, "  %-26s %s: %.1f %% measured, %.1f %% worst case\n", "bus load", name,
                 *bus.measured_percent, bus.computed.worst_percent);
  else
    std::fprintf(out, "  %-26s %s: %s, %.1f %% worst case\n", "bus", name, bus.address.c_str(),
                 bus.computed.worst_percent);
  const BusCounters& c = bus.counters;
  std::fprintf(out,
               "  %-26s %s: %" PRIu64 " sent, %" PRIu64 " received, %" PRIu64 " refused, %" PRIu64
               " overflowed, %" PRIu64 " error frames, %" PRIu64 " bus-off, TEC %d, REC %d\n",
               "frames", name, c.sent, c.received, c.send_refused, c.receive_overflow, c.error_frames,
               c.bus_off_events, int{c.transmit_error_counter}, int{c.receive_error_counter});
  if (!bus.slowness.empty()) std::fprintf(out, "  %-26s %s: %s\n", "WARNING", name, bus.slowness.c_str());
}

void print_tracker(std::FILE* out, const TrackerReportLine& tracker) {
  const TrackerCounters& c = tracker.report.counters;
  std::fprintf(out,
               "  %-26s %s: %s, %s; %" PRIu64 " samples, %" PRIu64 " repeated, %" PRIu64 " lost, %" PRIu64
               " bad CRC, %" PRIu64 " restarts\n",
               "tracker", tracker.params.name.c_str(),
               tracker.is_real ? tracker.params.port.c_str() : "simulated", name(tracker.report.state),
               c.samples, c.repeated, c.lost_frames, c.bad_crc, c.restarts);
  for (std::size_t i = 0; i < tracker.tools.size(); ++i) {
    const TrackedToolParams& tool = tracker.params.tools[i];
    std::fprintf(out, "  %-26s %s: %s", "  tool", tool.tool.c_str(), name(tracker.tools[i].state));
    if (tracker.report.tools[i].number > 0)
      std::fprintf(out, ", newest sample %.1f ms old", 1e-6 * static_cast<double>(tracker.tools[i].age));
    std::fputc('\n', out);
  }
}

void print_spacemouse(std::FILE* out, const SpaceMouseLine& mouse) {
  const SpaceMouseCounters& c = mouse.counters;
  std::fprintf(out,
               "  %-26s %s: %s, %" PRIu64 " events, %" PRIu64 " malformed, connected %" PRIu64 " times\n",
               "spacemouse", mouse.socket.c_str(), c.connected ? "there" : "GONE", c.events, c.malformed,
               c.connections);
}

void print_socket_device(std::FILE* out, const SocketDeviceLine& device) {
  const SocketDeviceCounters& c = device.counters;
  std::fprintf(out,
               "  %-26s %s: %s, %" PRIu64 " samples, %" PRIu64 " malformed, %" PRIu64 " late; %" PRIu64
               " wrenches sent, %" PRIu64 " not; connected %" PRIu64 " times\n",
               "device's program", device.socket.c_str(), c.connected ? "there" : "GONE", c.samples,
               c.malformed, c.late, c.wrenches, c.not_sent, c.connections);
}

void print_world(std::FILE* out, const WorldLine& world) {
  const WorldCounters& c = world.counters;
  std::fprintf(out,
               "  %-26s %s: %s, %" PRIu64 " packets, %" PRIu64 " malformed, %" PRIu64 " late; silent %" PRIu64
               " times, held back in %" PRIu64 " steps\n",
               "world", world.name.c_str(), c.live ? "there" : "GONE", c.packets, c.malformed, c.late,
               c.silences, c.limited);
}

void print_recoveries(std::FILE* out, const RunReport& report) {
  for (const Recovery& recovery : report.result.recoveries)
    if (!recovery.recovered_after_s)
      std::fprintf(out, "  %-26s at %.3f s, not armed again, %d boots tried\n", "device lost",
                   recovery.seen_s, recovery.boots);
}

void print_files(std::FILE* out, const RunReport& report) {
  const auto print = [out](const std::string& file, const std::string& about = "") {
    if (!file.empty()) std::fprintf(out, "  %-26s %s%s\n", "file", file.c_str(), about.c_str());
  };
  const RunFileNames& files = report.options.files;
  for (const std::string& file : {files.trace, files.contacts, files.nets, files.record, files.inputs})
    print(file);
  for (const FaultFile& file : report.fault_files) {
    std::array<char, 48> about{};
    std::snprintf(about.data(), about.size(), ", %.3g s before a fault", file.kept_s);
    print(file.path, about.data());
  }
  print(report.options.report);
}

}  // namespace

void print_faults(std::FILE* out, const std::vector<FaultReport>& faults) {
  for (const FaultReport& fault : faults) {
    std::fprintf(out, "  %-26s %s: %s", "FAULT", fault.name.c_str(), fault.text.c_str());
    if (fault.cycles > 0) std::fprintf(out, " (%" PRIu64 " cycles)", fault.cycles);
    std::fputc('\n', out);
  }
}

std::string hash_text(std::uint64_t hash) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016" PRIx64, hash);
  return text.data();
}

void print_summary(std::FILE* out, const RunReport& report) {
  const RunResult& result = report.result;
  const SceneConfig& scene = report.session.scene();
  const Composition& composition = report.session.engine().composition();
  std::fprintf(out, "%s: %" PRIu64 " cycles of %g s, composition '%s', %zu bytes\n", scene.name.c_str(),
               result.statistics.cycles, scene.step, composition.name.c_str(), composition.bytes());
  if (!result.stopped_by.empty())
    std::fprintf(out, "  %-26s %.*s, after %g s\n", "stopped by", static_cast<int>(result.stopped_by.size()),
                 result.stopped_by.data(), static_cast<double>(result.statistics.cycles) * scene.step);
  if (report.options.realtime)
    std::fprintf(out, "  %-26s %" PRIu64 " (%" PRIu64 " cycles late, %" PRIu64 " periods skipped)\n",
                 "missed deadlines", result.timing.missed(), result.timing.late, result.timing.skipped);
  if (result.page_faults)
    std::fprintf(out, "  %-26s %ld, and %ld from a disk\n", "page faults of the loop",
                 result.page_faults->minor, result.page_faults->major);
  if (result.first_page_fault)
    std::fprintf(out, "  %-26s in cycle %" PRIu64 "\n", "first page fault", *result.first_page_fault);
  if (report.options.seal)
    std::fprintf(out, "  %-26s %" PRIu64 " system calls refused\n", "seal", result.refused_calls);
  if (result.statistics.holds > 0)
    std::fprintf(out, "  %-26s %" PRIu64 " times, %" PRIu64 " cycles in all: see missed deadlines\n",
                 "held, force faded", result.statistics.holds, result.statistics.hold_cycles);
  print_timing(out, "wake-up", result.timing.wake_ns);
  print_stages(out, result);
  print_errors(out, report);
  if (report.link_timing) {
    print_timing(out, "added latency", report.link_timing->added_latency_ns);
    print_timing(out, "SYNC jitter", report.link_timing->sync_jitter_ns);
  }
  for (const BusReport& bus : report.buses) print_bus(out, bus);
  for (const TrackerReportLine& tracker : report.trackers) print_tracker(out, tracker);
  if (report.spacemouse) print_spacemouse(out, *report.spacemouse);
  if (report.socket_device) print_socket_device(out, *report.socket_device);
  if (report.world) print_world(out, *report.world);
  if (report.session.rig()) {
    const RigCounters counters = report.session.rig_counters();
    std::fprintf(out, "  %-26s to %" PRIu64 " of %" PRIu64 " SYNCs\n", "late answers",
                 counters.incomplete_syncs, counters.syncs);
  }
  print_recoveries(out, report);
  print_nets(out, report);
  print_limits(out, result.statistics);
  for (const std::string& warning : run_warnings(report))
    std::fprintf(out, "  %-26s %s\n", "WARNING", warning.c_str());
  if (report.faults.empty()) std::fprintf(out, "  %-26s none\n", "faults");
  print_faults(out, report.faults);
  if (report.options.realtime)
    std::fprintf(out, "  %-26s %" PRIu64 " cycles, %" PRIu64 " frames\n", "lost to the files",
                 result.lost_cycles, result.lost_frames);
  std::fprintf(out, "  %-26s %s\n", "state hash", hash_text(report.session.engine().state_hash()).c_str());
  print_files(out, report);
}

}  // namespace godobject
