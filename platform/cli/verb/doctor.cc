// godobject doctor: checks this machine for real time, and for the buses, ports and records of a scene.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "platform/cli/program.h"
#include "platform/cli/run/options.h"
#include "platform/linux/serial_port.h"
#include "platform/rt/disk.h"
#include "platform/rt/setup.h"
#include "platform/scene/toml.h"
#include "platform/trace/trace.h"

namespace godobject {
namespace {

struct DoctorOptions {
  std::string scene;                  // path; empty: the machine alone
  std::vector<std::string> buses;     // see rig_addresses()
  std::vector<std::string> trackers;  // see plan_trackers()
  std::string folder = ".";           // of the records
  bool json = false;
  FaultChecks faults{};  // simulation of the program
};

/// Checks with a common subject.
struct CheckGroup {
  const char* name;
  std::vector<RtStep> checks{};
};

/// Returns the addresses of the buses: those given, otherwise each bus on the CAN interface of its name.
RigAddresses addresses_of(const DoctorOptions& options, const SceneConfig& scene,
                          std::vector<std::string>& errors) {
  std::vector<std::string> given = options.buses;
  if (given.empty())
    for (const BusParams& bus : scene.device->rig->buses)
      given.push_back(bus.name + "=socketcan:" + bus.name);
  return rig_addresses(given, scene, "--bus", errors);
}

/// Returns the bytes that a run writes into its trace, 1/s. Most numbers have 15 to 17 digits.
double trace_rate(const SceneConfig& scene) {
  constexpr double bytes_per_number = 18;
  return bytes_per_number * static_cast<double>(trace_columns(scene).size()) / scene.step;
}

/// Checks the scene's devices. Returns errors of options.
std::vector<std::string> check_devices(const DoctorOptions& options, SceneConfig& scene,
                                       std::vector<std::string>& interfaces, CheckGroup& devices) {
  std::vector<std::string> errors;
  const bool has_rig = scene.device && scene.device->rig;
  if (!options.buses.empty() && !has_rig)
    errors.push_back("--bus: scene '" + scene.name +
                     "' describes no buses: remove --bus, or add [[bus]] tables");
  BusPlan plan{.choice = BusChoice::real, .real = {}};
  plan_trackers(options.trackers, !options.buses.empty(), scene, plan, errors);
  if (has_rig && errors.empty()) {
    const RigAddresses where = addresses_of(options, scene, errors);
    if (!errors.empty()) return errors;
    devices.checks = check_buses(scene, where);
    for (const BusAddress& address : where.addresses) interfaces.push_back(address.where);
  }
  if (scene.device)
    for (const TrackerParams& tracker : scene.device->trackers)
      if (tracker.protocol != TrackerProtocol::openigtlink)
        devices.checks.push_back(check_serial_port(tracker.name, tracker.port));
  return errors;
}

RtResult worst(const std::vector<CheckGroup>& groups) {
  RtResult result = RtResult::ok;
  for (const CheckGroup& group : groups)
    for (const RtStep& check : group.checks) result = std::max(result, check.result);
  return result;
}

std::string json_of(const std::vector<CheckGroup>& groups) {
  nlohmann::ordered_json json{{"result", name_of(worst(groups))},
                              {"checks", nlohmann::ordered_json::array()}};
  for (const CheckGroup& group : groups)
    for (const RtStep& check : group.checks)
      json["checks"].push_back(
          {{"group", group.name},
           {"check", check.name},
           {"result", name_of(check.result)},
           {"detail", check.detail},
           {"remedy", check.remedy.empty() ? nullptr : nlohmann::ordered_json(check.remedy)}});
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

ExitCode examine(const DoctorOptions& options) {
  constexpr double usual_trace = 1e6;  // bytes/s
  CheckGroup devices{.name = "devices"};
  std::vector<std::string> interfaces;
  double bytes_per_s = usual_trace;
  if (!options.scene.empty()) {
    LoadResult loaded = load_scene(options.scene, options.faults);
    for (const std::string& warning : loaded.warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
    std::vector<std::string> errors = std::move(loaded.errors);
    if (loaded.scene && errors.empty()) errors = check_devices(options, *loaded.scene, interfaces, devices);
    for (const std::string& error : errors) std::fprintf(stderr, "%s\n", error.c_str());
    if (!errors.empty()) return ExitCode::usage;
    bytes_per_s = trace_rate(*loaded.scene);
  } else if (!options.buses.empty() || !options.trackers.empty()) {
    std::fputs("--bus and --tracker require a scene, which names the devices: give SCENE\n", stderr);
    return ExitCode::usage;
  }
  std::vector<CheckGroup> groups{{.name = "real time", .checks = real_time_checks()},
                                 {.name = "cores", .checks = core_checks(interfaces)},
                                 std::move(devices),
                                 {.name = "records"}};
  groups.back().checks.push_back(disk_check(options.folder, free_bytes(options.folder), bytes_per_s));
  if (options.json) {
    std::fputs(json_of(groups).c_str(), stdout);
  } else {
    for (const CheckGroup& group : groups)
      if (!group.checks.empty()) std::printf("%s\n%s", group.name, rt_table(group.checks).c_str());
  }
  return worst(groups) == RtResult::failed ? ExitCode::fault : ExitCode::ok;
}

}  // namespace

void add_doctor(CLI::App& app, const FaultChecks& checks, ExitCode& code) {
  CLI::App* verb = app.add_subcommand(
      "doctor",
      "Check this machine for real time, and the buses, ports and disk of a scene; fail if a check fails.");
  verb->footer(
      "Exit codes: 0 no check failed, 1 a check failed, 2 usage or configuration. A degraded check works "
      "with "
      "longer latencies.");
  const auto options = std::make_shared<DoctorOptions>();
  options->faults = checks;
  verb->add_option("SCENE", options->scene,
                   "check the devices of this scene file (TOML) too; none of them is opened");
  verb->add_option("--bus", options->buses,
                   "check the scene's bus at ADDRESS, or NAME=ADDRESS, as in run; default: the CAN interface "
                   "with the name of the bus")
      ->type_name("BUS")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option("--tracker", options->trackers,
                   "check the scene's tracker at NAME=PORT; default: the scene's ports")
      ->type_name("TRACKER")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  verb->add_option("--folder", options->folder, "check the free space for records in this folder")
      ->type_name("FOLDER")
      ->capture_default_str();
  verb->add_flag("--json", options->json, "print JSON");
  verb->callback([options, &code] { code = examine(*options); });
}

}  // namespace godobject
