// report.json: the facts of a run for other programs. Keys carry their units.
#include <filesystem>

#include "platform/cli/report/report.h"
#include "platform/rt/setup.h"
#include "platform/scene/contact/params.h"
#include "platform/scene/joint/joints.h"

namespace godobject {
namespace {

using Json = nlohmann::ordered_json;

double to_us(std::int64_t ns) { return 1e-3 * static_cast<double>(ns); }

/// Returns percentiles and [upper edge in us, count] of every bin that is not empty; null without samples.
Json to_json(const Histogram& h) {
  if (h.count() == 0) return nullptr;
  Json bins = Json::array();
  for (std::size_t bin = 0; bin < Histogram::num_bins; ++bin)
    if (h.in_bin(bin) > 0) bins.push_back({to_us(Histogram::upper_edge(bin)), h.in_bin(bin)});
  return {{"p50", to_us(h.percentile(0.5))},
          {"p99", to_us(h.percentile(0.99))},
          {"p99_9", to_us(h.percentile(0.999))},
          {"max", to_us(h.max())},
          {"histogram", std::move(bins)}};
}

/// Returns the statistics of a pose error; null without samples.
Json to_json(const PoseErrorStatistics& e) {
  if (e.count() == 0) return nullptr;
  return {{"rms_m", e.rms().m}, {"max_m", e.max().m}, {"rms_rad", e.rms().rad}, {"max_rad", e.max().rad}};
}

Json text_or_null(std::string_view text) { return text.empty() ? Json(nullptr) : Json(text); }

template <class T>
Json or_null(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const BusCounters& c) {
  return {{"sent", c.sent},
          {"received", c.received},
          {"send_refused", c.send_refused},
          {"send_dropped", c.send_dropped},
          {"receive_overflow", c.receive_overflow},
          {"error_frames", c.error_frames},
          {"bus_off_events", c.bus_off_events},
          {"restarts", c.restarts},
          {"last_error", name_of(c.last_error)},
          {"transmit_error_counter", c.transmit_error_counter},
          {"receive_error_counter", c.receive_error_counter}};
}

Json to_json(const BusReport& bus) {
  return {{"name", bus.computed.bus},
          {"address", text_or_null(bus.address)},
          {"measured_percent", or_null(bus.measured_percent)},
          {"nominal_percent", bus.computed.nominal_percent},
          {"worst_percent", bus.computed.worst_percent},
          {"counters", to_json(bus.counters)},
          {"slowness", bus.slowness.empty() ? Json(nullptr) : Json(bus.slowness)}};
}

Json to_json(const SpaceMouseLine& mouse) {
  const SpaceMouseCounters& c = mouse.counters;
  return {{"socket", mouse.socket},
          {"connected", c.connected},
          {"events", c.events},
          {"malformed", c.malformed},
          {"connections", c.connections}};
}

Json to_json(const SocketDeviceLine& device) {
  const SocketDeviceCounters& c = device.counters;
  return {{"socket", device.socket},  {"connected", c.connected}, {"samples", c.samples},
          {"malformed", c.malformed}, {"late", c.late},           {"connections", c.connections},
          {"refused", c.refused},     {"wrenches", c.wrenches},   {"not_sent", c.not_sent}};
}

Json to_json(const WorldLine& world) {
  const WorldCounters& c = world.counters;
  return {{"name", world.name}, {"live", c.live},         {"packets", c.packets}, {"malformed", c.malformed},
          {"late", c.late},     {"silences", c.silences}, {"limited", c.limited}};
}

Json to_json(const TrackerReportLine& tracker) {
  const TrackerCounters& c = tracker.report.counters;
  Json json{{"name", tracker.params.name},
            {"port", tracker.is_real ? Json(tracker.params.port) : Json(nullptr)},
            {"state", name(tracker.report.state)},
            {"text", tracker.report.text.data()},
            {"samples", c.samples},
            {"repeated", c.repeated},
            {"lost_frames", c.lost_frames},
            {"bad_crc", c.bad_crc},
            {"malformed", c.malformed},
            {"timeouts", c.timeouts},
            {"restarts", c.restarts},
            {"tools", Json::array()}};
  for (std::size_t i = 0; i < tracker.tools.size(); ++i)
    json["tools"].push_back(
        {{"body", tracker.params.tools[i].body},
         {"tool", tracker.params.tools[i].tool},
         {"state", name(tracker.tools[i].state)},
         {"samples", tracker.report.tools[i].number},
         {"age_s", tracker.report.tools[i].number > 0 ? Json(1e-9 * static_cast<double>(tracker.tools[i].age))
                                                      : Json(nullptr)}});
  return json;
}

Json to_json(const Recovery& recovery) {
  return {{"seen_s", recovery.seen_s},
          {"named", recovery.named},
          {"troubles", recovery.troubles},
          {"boots", recovery.boots},
          {"recovered_after_s", or_null(recovery.recovered_after_s)}};
}

Json to_json(const RunEvent& event) {
  return {{"t_s", event.t_s},
          {"event", name_of(event.kind)},
          {"name", text_or_null(event.name)},
          {"bus", text_or_null(event.bus)},
          {"node", event.node != 0 ? Json(event.node) : Json(nullptr)},
          {"place", text_or_null(event.place)},
          {"cause", event.cause},
          {"remedy", text_or_null(event.remedy)}};
}

Json to_json(const FaultFile& file) {
  return {{"path", file.path}, {"kept_s", file.kept_s}, {"is_bounded", file.is_bounded}};
}

Json to_json(const RtStep& step) {
  return {{"step", step.name},
          {"result", name_of(step.result)},
          {"detail", step.detail},
          {"remedy", step.remedy}};
}

Json to_json(const FaultReport& fault) {
  return {{"name", fault.name}, {"text", fault.text}, {"cycles", fault.cycles}};
}

template <class T>
Json to_array(const std::vector<T>& items) {
  Json array = Json::array();
  for (const T& item : items) array.push_back(to_json(item));
  return array;
}

Json timing(const CyclicStatistics& t, const RunStatistics& run) {
  Json stages;
  for (std::size_t i = 0; i < stage_names.size(); ++i)
    stages[std::string(stage_names[i])] = to_json(run.stage_ns[i]);
  return {{"missed_deadlines", t.missed()},
          {"late_cycles", t.late},
          {"skipped_periods", t.skipped},
          {"holds", run.holds},
          {"hold_cycles", run.hold_cycles},
          {"wake_us", to_json(t.wake_ns)},
          {"cycle_us", to_json(t.cycle_ns)},
          {"compute_us", to_json(run.compute_ns)},
          {"stages_us", stages}};
}

Json to_json(const PeakAndMean& x, std::uint64_t cycles) {
  return {{"peak", x.peak}, {"mean", cycles > 0 ? x.sum / static_cast<double>(cycles) : 0}};
}

Json bodies(const SceneConfig& scene, const RunStatistics& run) {
  Json array = Json::array();
  for (std::size_t i = 0; i < run.bodies.size(); ++i) {
    const BodyStatistics& b = run.bodies[i];
    const auto json = [&](const PeakAndMean& x) { return to_json(x, run.cycles); };
    array.push_back({{"name", scene.bodies[i].name},
                     {"speed_m_per_s", json(b.speed)},
                     {"turn_rate_rad_per_s", json(b.turn_rate)},
                     {"coupling_force_N", json(b.coupling_force)},
                     {"coupling_torque_Nm", json(b.coupling_torque)},
                     {"displayed_force_N", json(b.displayed_force)},
                     {"displayed_torque_Nm", json(b.displayed_torque)},
                     {"contact_force_N", json(b.contact_force)},
                     {"contact_torque_Nm", json(b.contact_torque)}});
  }
  return array;
}

Json joints(const SceneConfig& scene, const RunStatistics& run) {
  Json array = Json::array();
  std::size_t coordinate = 0;
  for (std::size_t i = 0; i < run.joints.size(); ++i) {
    const JointConfig& joint = scene.joints[i];
    Json json{{"name", joint.name},
              {"force_N", to_json(run.joints[i].force, run.cycles)},
              {"torque_Nm", to_json(run.joints[i].torque, run.cycles)},
              {"coordinates", Json::array()}};
    for (std::size_t k = 0; k < num_coordinates(joint.kind); ++k) {
      const CoordinateStatistics& q = run.coordinates[coordinate++];
      const bool turns = is_turn(joint.kind, k);
      json["coordinates"].push_back({{"unit", turns ? "rad" : "m"},
                                     {"min", q.min},
                                     {"max", q.max},
                                     {"mean", run.cycles > 0 ? q.sum / static_cast<double>(run.cycles) : 0}});
    }
    array.push_back(std::move(json));
  }
  return array;
}

/// Commanded torques, N m; for a sliding joint forces, N.
Json drives(const SceneConfig& scene, const RunStatistics& run) {
  Json array = Json::array();
  for (std::size_t i = 0; i < run.drives.size(); ++i) {
    const DriveParams& drive = scene.device->rig->drives[i];
    array.push_back({{"joint", drive.joint},
                     {"bus", scene.device->rig->buses[drive.bus].name},
                     {"commanded_torque_Nm", to_json(run.drives[i], run.cycles)},
                     {"most_generated_energy_J", run.drive_energy[i]}});
  }
  return array;
}

Json nets(const SceneNets& nets, const NetStatistics& n) {
  return {{"nodes", nets.nodes.size()},
          {"springs", nets.springs.size()},
          {"largest_stretch", n.stretch},
          {"most_contacts", n.contacts},
          {"deepest_m", n.deepest},
          {"iterations", n.iterations},
          {"most_iterations", n.most_iterations},
          {"residual_N", n.residual}};
}

Json contacts(const ContactStatistics& c) {
  return {{"most_contacts", c.contacts},
          {"deepest_m", c.deepest},
          {"most_newton_iterations", c.most_newton_iterations},
          {"residual_N", c.residual},
          {"residual_share", c.residual_share}};
}

Json machine(const std::vector<RtStep>& setup) {
  const Machine m = this_machine();
  return {{"cpu", m.cpu}, {"num_cpus", m.num_cpus}, {"kernel", m.kernel}, {"rt_setup", to_array(setup)}};
}

Json answers(const RigCounters& c) {
  return {{"syncs", c.syncs},       {"incomplete_syncs", c.incomplete_syncs},
          {"frames", c.frames},     {"malformed", c.malformed},
          {"repeated", c.repeated}, {"foreign", c.foreign}};
}

Json limits(const RunStatistics& statistics) {
  Json hit = Json::object();
  for (std::size_t i = 0; i < run_limits.size(); ++i)
    if (statistics.limit_cycles[i] > 0) hit[std::string(run_limits[i].name)] = statistics.limit_cycles[i];
  return hit;
}

Json limits_percent(const RunStatistics& statistics) {
  Json hit = Json::object();
  for (std::size_t i = 0; i < run_limits.size(); ++i)
    if (statistics.limit_cycles[i] > 0) hit[std::string(run_limits[i].name)] = limit_percent(statistics, i);
  return hit;
}

}  // namespace

std::string_view name_of(BusChoice bus) noexcept {
  constexpr std::array<std::string_view, 3> names{"sim", "direct", "real"};
  return names[static_cast<std::size_t>(bus)];
}

nlohmann::ordered_json to_json(const RunReport& report) {
  const RunOptions& options = report.options;
  const SceneConfig& scene = report.session.scene();
  const RunStatistics& statistics = report.result.statistics;
  std::error_code ignored;
  Json json{{"scene", scene.name},
            {"scene_file", options.scene},
            {"folder", std::filesystem::current_path(ignored).string()},
            {"mode", options.realtime ? "realtime" : "fast"},
            {"bus_mode", name_of(report.session.bus())},
            {"stopped_by", text_or_null(report.result.stopped_by)},
            {"integrator", scene.integrator},
            {"composition", report.session.engine().composition().name},
            {"step_s", scene.step},
            {"cycles", statistics.cycles},
            {"motion_start_on_bus_s", 1e-9 * static_cast<double>(report.session.motion_start_ns())},
            {"motion_start_wall_s",
             report.wall_origin_ns
                 ? Json(1e-9 * static_cast<double>(report.session.motion_start_ns() + *report.wall_origin_ns))
                 : Json(nullptr)},
            {"timing", timing(report.result.timing, statistics)}};
  if (const std::optional<PageFaults>& faults = report.result.page_faults)
    json["page_faults"] = {
        {"minor", faults->minor},
        {"major", faults->major},
        {"first_cycle",
         report.result.first_page_fault ? Json(*report.result.first_page_fault) : Json(nullptr)}};
  if (options.seal)
    json["seal"] = {{"broken_by", text_or_null(report.result.seal_broken)},
                    {"refused_calls", report.result.refused_calls}};
  if (report.session.follows()) {
    json["truth"] = report.session.bus() == BusChoice::real ? "none: errors are relative to the core's target"
                                                            : "where the handle is";
    json["following"] = to_json(statistics.following);
    if (report.session.bus() != BusChoice::real) json["sensing"] = to_json(statistics.sensing);
    if (report.session.bus() == BusChoice::sim) {
      json["exact_following"] = to_json(statistics.exact_following);
      json["encoders"] = to_json(statistics.encoders);
    }
  }
  json["bus"] = to_array(report.buses);
  json["trackers"] = to_array(report.trackers);
  if (report.spacemouse) json["spacemouse"] = to_json(*report.spacemouse);
  if (report.socket_device) json["device_program"] = to_json(*report.socket_device);
  if (report.world) json["world"] = to_json(*report.world);
  if (report.link_timing) {
    json["added_latency_us"] = to_json(report.link_timing->added_latency_ns);
    json["sync_jitter_us"] = to_json(report.link_timing->sync_jitter_ns);
  }
  if (report.session.rig()) json["answers"] = answers(report.session.rig_counters());
  json["events"] = to_array(report.result.events);
  json["recoveries"] = to_array(report.result.recoveries);
  if (contact_scope(scene) != ContactScope::none) json["contacts"] = contacts(statistics.contacts);
  if (const SceneNets& n = report.session.engine().nets(); !n.nodes.empty())
    json["nets"] = nets(n, statistics.nets);
  json["bodies"] = bodies(scene, statistics);
  json["joints"] = joints(scene, statistics);
  json["drives"] = drives(scene, statistics);
  json["limits"] = limits(statistics);
  json["limits_percent"] = limits_percent(statistics);
  const EnergyReport& gain = statistics.gain;
  json["largest_energy_gain"] = {{"gained_J", gain.gained}, {"of_J", gain.at_work}};
  json["warnings"] = run_warnings(report);
  json["faults"] = to_array(report.faults);
  json["lost"] = {{"cycles", report.result.lost_cycles},
                  {"frames", report.result.lost_frames},
                  {"events", report.result.lost_events},
                  {"console_lines", report.result.lost_console_lines}};
  json["machine"] = machine(report.result.setup);
  json["state_hash"] = hash_text(report.session.engine().state_hash());
  json["files"] = {{"trace", options.files.trace},   {"contacts", options.files.contacts},
                   {"nets", options.files.nets},     {"record", options.files.record},
                   {"inputs", options.files.inputs}, {"on_fault", to_array(report.fault_files)},
                   {"report", options.report}};
  return json;
}

}  // namespace godobject
