#include "platform/cli/run/buses.h"

#include <algorithm>
#include <cmath>

#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"
#include "platform/cli/named_address.h"
#include "platform/linux/bus/rig_filters.h"

namespace godobject {
namespace {

std::string how_to(const SceneConfig& scene) {
  std::string text;
  for (const BusParams& bus : scene.device->rig->buses) text += " --bus " + bus.name + "=ADDRESS";
  return text;
}

/// Index of the bus that `given` means; none, with the reason in errors.
std::optional<std::size_t> bus_of(const NamedAddress& given, const SceneConfig& scene,
                                  std::vector<std::string>& errors) {
  const std::vector<BusParams>& buses = scene.device->rig->buses;
  if (given.name.empty() && buses.size() == 1) return 0;
  if (given.name.empty()) {
    if (std::string error; !parse_bus_address(given.address, error)) errors.push_back("--bus: " + error);
    errors.push_back("--bus: '" + given.address + "' names no bus of the scene, which has " +
                     quoted_names(buses) + ": give" + how_to(scene));
    return std::nullopt;
  }
  const auto named = std::ranges::find(buses, given.name, &BusParams::name);
  if (named != buses.end()) return static_cast<std::size_t>(named - buses.begin());
  errors.push_back("--bus: scene '" + scene.name + "' has no bus '" + given.name + "': its buses are " +
                   quoted_names(buses));
  return std::nullopt;
}

/// `pty` alone stands for one of each bus, as of simulate.
std::vector<std::string> with_names(std::span<const std::string> given, const std::vector<BusParams>& buses) {
  std::vector<std::string> named;
  for (const std::string& text : given) {
    std::string ignored;
    const std::optional<BusAddress> address = parse_bus_address(text, ignored);
    if (address && address->backend->makes_terminal)
      for (const BusParams& bus : buses) named.push_back(bus.name + "=" + text);
    else named.push_back(text);
  }
  return named;
}

void plan_real_buses(std::span<const std::string> given, const SceneConfig& scene, BusPlan& plan,
                     std::vector<std::string>& errors) {
  if (!scene.device || !scene.device->rig) {
    errors.push_back("--bus: scene '" + scene.name +
                     "' describes no buses: add them, with encoders and joints, or use --bus direct");
    return;
  }
  const RigParams& rig = *scene.device->rig;
  std::vector<std::optional<BusAddress>> addresses(rig.buses.size());
  plan.texts.resize(rig.buses.size());
  for (const std::string& text : with_names(given, rig.buses)) {
    const NamedAddress bus = split_name(text, ':');
    const std::optional<std::size_t> index = bus_of(bus, scene, errors);
    if (!index) continue;
    if (!plan.texts[*index].empty())
      errors.push_back("--bus: bus '" + rig.buses[*index].name + "' is given twice");
    std::string error;
    addresses[*index] = parse_bus_address(bus.address, error);
    if (!addresses[*index]) errors.push_back("--bus: " + error);
    plan.texts[*index] = bus.address;
  }
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    if (addresses[i]) plan.addresses.push_back(*addresses[i]);
    if (plan.texts[i].empty() && errors.empty())
      errors.push_back("--bus: bus '" + rig.buses[i].name + "' of the scene has no address: give" +
                       how_to(scene));
  }
}

/// A SYNC or a command of the last cycle is worth nothing in this one. What finds no slot waits in the queue of
/// the rest, as do commands with extended identifiers (moteus).
void add_slots(LinuxLink& link, const RigParams& rig, Nanoseconds period) {
  for (std::size_t i = 0; i < rig.buses.size(); ++i)
    static_cast<void>(link.add_slot(i, canopen::make_sync().id, period / 2));
  for (const DriveParams& drive : rig.drives) {
    const auto command_id = bus_protocol(drive.protocol).command_id;
    if (command_id != nullptr) static_cast<void>(link.add_slot(drive.bus, command_id(drive.node_id), period));
  }
}

std::string trouble_of(LinuxLink& link, const BusPlan& plan, const RigParams& rig, std::size_t i) {
  return "bus " + rig.buses[i].name + " (" + plan.texts[i] + "): " + link.bus(i).trouble();
}

}  // namespace

BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes) {
  BusPlan plan;
  const auto is_choice = [](const std::string& text) { return text == "sim" || text == "direct"; };
  if (given.empty()) {
    if (scene.device && (scene.device->rig || !scene.device->trackers.empty())) return plan;
    const bool has_other_hand = scene.device && scene.device->spacemouse;
    if (!has_other_hand)
      notes.push_back("scene '" + scene.name + "' describes no buses: it runs with --bus direct");
    plan.choice = BusChoice::direct;
  } else if (std::ranges::any_of(given, is_choice)) {
    if (given.size() > 1) errors.push_back("--bus: sim and direct stand for all buses: give one --bus");
    plan.choice = given.front() == "sim" ? BusChoice::sim : BusChoice::direct;
  } else {
    plan.choice = BusChoice::real;
    plan_real_buses(given, scene, plan, errors);
  }
  return plan;
}

std::unique_ptr<LinuxLink> make_link(const BusPlan& plan, const RigParams& rig, double step,
                                     bool everything) {
  const std::vector<std::vector<CanFilter>> filters = rig_filters(rig);
  std::vector<std::unique_ptr<LinuxBus>> buses;
  for (std::size_t i = 0; i < plan.addresses.size(); ++i) {
    BusSettings settings{
        .bit_rate = rig.buses[i].bit_rate, .data_bit_rate = rig.buses[i].data_bit_rate, .filters = {}};
    if (!everything) settings.filters = filters[i];
    buses.push_back(make_bus(plan.addresses[i], settings));
  }
  const Nanoseconds period = to_ns(step);
  auto link = std::make_unique<LinuxLink>(std::move(buses), period);
  add_slots(*link, rig, period);
  return link;
}

std::vector<std::string> open_buses(LinuxLink& link, const BusPlan& plan, const RigParams& rig) {
  std::vector<std::string> errors;
  for (std::size_t i = 0; i < link.num_buses(); ++i)
    if (link.bus(i).state() == BusState::closed && !link.bus(i).open())
      errors.push_back(trouble_of(link, plan, rig, i));
  return errors;
}

std::vector<std::string> bus_troubles(LinuxLink& link, const BusPlan& plan, const RigParams& rig) {
  std::vector<std::string> troubles;
  for (std::size_t i = 0; i < link.num_buses(); ++i)
    if (!link.bus(i).trouble().empty()) troubles.push_back(trouble_of(link, plan, rig, i));
  return troubles;
}

}  // namespace godobject
