#include "platform/cli/simulate/options.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "hal/rig/profile_validate.h"
#include "hal/rig/validate.h"
#include "platform/scene/toml.h"
#include "platform/simulated/fault_checks.h"
#include "platform/simulated/session.h"

#include "platform/linux/bus/named_address.h"

namespace godobject {
namespace {

/// Makes closed ends of the buses named by `text`.
void offer(const std::string& option, const std::string& text, bool is_tap, const RigParams& rig,
           PreparedSimulation& out, std::vector<OfferedBus>& offered) {
  const auto complain = [&](const std::string& what) {
    out.errors.push_back(option + " " + text + ": " + what);
  };
  const NamedAddress wanted = split_name(text, ':');  // without a name: all buses
  std::string error;
  const std::optional<BusAddress> address = parse_bus_address(wanted.address, error);
  if (!address) return complain(error);
  if (address->backend->no_device != nullptr) return complain(address->backend->no_device);
  if (wanted.name.empty() && rig.buses.size() > 1 && !address->backend->makes_terminal)
    return complain("the scene has " + std::to_string(rig.buses.size()) + " buses: name one, as in " +
                    rig.buses.front().name + "=" + wanted.address);
  bool found = false;
  for (std::size_t i = 0; i < rig.buses.size(); ++i) {
    const BusParams& bus = rig.buses[i];
    if (!wanted.name.empty() && wanted.name != bus.name) continue;
    found = true;
    const BusSettings settings{.bit_rate = bus.bit_rate, .data_bit_rate = bus.data_bit_rate, .filters = {}};
    offered.push_back({.name = bus.name,
                       .address = wanted.address,
                       .wire = i,
                       .is_tap = is_tap,
                       .bus = make_bus(*address, settings)});
  }
  if (!found) complain("the scene has no bus '" + wanted.name + "'");
}

/// Makes one end for each bus of the scene, in its order, then the taps.
std::vector<OfferedBus> offer_all(const SimulateOptions& options, const RigParams& rig,
                                  PreparedSimulation& out) {
  std::vector<OfferedBus> offered;
  for (const std::string& text : options.buses) offer("--bus", text, false, rig, out, offered);
  std::ranges::stable_sort(offered, {}, &OfferedBus::wire);
  for (std::size_t i = 0; i < rig.buses.size(); ++i) {
    const auto ends = std::ranges::count(offered, i, &OfferedBus::wire);
    if (out.errors.empty() && ends != 1)
      out.errors.push_back("--bus: bus '" + rig.buses[i].name + "' of the scene has " + std::to_string(ends) +
                           " addresses and requires one: give --bus " + rig.buses[i].name + "=ADDRESS");
  }
  for (const std::string& text : options.taps) offer("--tap", text, true, rig, out, offered);
  return offered;
}

void open_all(const std::vector<OfferedBus>& offered, PreparedSimulation& out) {
  for (const OfferedBus& o : offered) {
    if (o.bus->open()) continue;
    out.not_available = true;
    out.errors.push_back("bus " + o.name + " at " + o.address + ": " + o.bus->trouble());
  }
}

/// Loads scene and faults; none if they have errors.
std::optional<SceneConfig> load(const SimulateOptions& options, PreparedSimulation& out) {
  LoadResult loaded = load_scene(options.scene, simulated_faults());
  append(out.errors, loaded.errors);
  append(out.notes, loaded.warnings);
  if (!loaded.scene) return std::nullopt;
  SceneConfig& scene = *loaded.scene;
  if (!scene.device || (!scene.device->rig && scene.device->trackers.empty())) {
    out.errors.push_back(options.scene +
                         ": describes no device on buses and no trackers to simulate: add [[bus]] or "
                         "[[device.tracker]] tables");
    return std::nullopt;
  }
  if (!options.faults.empty()) {
    FaultsResult faults = load_faults(options.faults, scene, simulated_faults());
    append(out.errors, faults.errors);
    scene.faults.insert(scene.faults.end(), faults.faults.begin(), faults.faults.end());
  }
  if (scene.device->rig)
    for (const std::string& error : validate(*scene.device->rig, scene.step))
      out.errors.push_back(options.scene + ": " + error);
  return std::move(loaded.scene);
}

/// Opens a pseudo-terminal for each tracker of the scene.
std::vector<std::unique_ptr<TrackerLine>> offer_trackers(const SceneConfig& scene, PreparedSimulation& out) {
  std::vector<std::unique_ptr<TrackerLine>> lines;
  const std::vector<TrackerParams>& trackers = scene.device->trackers;
  for (std::size_t i = 0; i < trackers.size(); ++i) {
    lines.push_back(std::make_unique<TrackerLine>(
        trackers[i].name,
        make_sim_tracker(trackers[i], simulated_rate_hz(trackers[i].protocol), scene.wire.seed + i)));
    const std::string why_not = lines.back()->open();
    if (why_not.empty()) continue;
    out.not_available = true;
    out.errors.push_back("tracker " + trackers[i].name + ": " + why_not);
  }
  return lines;
}

}  // namespace

PreparedSimulation prepare(const SimulateOptions& options) {
  PreparedSimulation out;
  std::optional<SceneConfig> scene = load(options, out);
  if (!scene) return out;
  const bool has_rig = scene->device->rig.has_value();
  RigProfilesResult devices;
  if (has_rig) {
    devices = load_profiles(*scene->device->rig, scene->step,
                            std::filesystem::path(options.scene).parent_path().string(), options.scene);
    apply_profiles(devices.profiles, *scene->device->rig);
  }
  append(out.errors, devices.errors);
  MotionResult motion;
  if (options.motion.empty()) motion.motion.emplace(*scene);
  else motion = Motion::read(options.motion, *scene);
  append(out.errors, motion.errors);
  append(out.notes, motion.notes);
  if (out.errors.empty() && has_rig) {
    const std::string why_not = SimRig::why_not(scene->device->rig->tree, *hand_of(*motion.motion));
    if (!why_not.empty()) out.errors.push_back(options.scene + ": " + why_not);
  }
  std::vector<OfferedBus> offered = offer_all(options, scene->device->rig.value_or(RigParams{}), out);
  std::vector<std::unique_ptr<TrackerLine>> trackers;
  if (out.errors.empty()) open_all(offered, out);
  if (out.errors.empty()) trackers = offer_trackers(*scene, out);
  if (!out.errors.empty()) return out;
  out.simulation = std::make_unique<Simulation>(*scene, devices.profiles, *motion.motion, std::move(offered),
                                                !options.start_now, std::move(trackers));
  return out;
}

}  // namespace godobject
