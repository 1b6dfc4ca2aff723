#include "platform/rig/buses.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <thread>
#include <utility>

#include "hal/canopen/canopen.h"
#include "hal/drive/link.h"
#include "hal/rig/commissioning.h"
#include "hal/rig/profile_validate.h"
#include "hal/rig/rig.h"
#include "hal/rig/watchdog.h"
#include "platform/linux/bus/bus.h"
#include "platform/rt/cyclic.h"
#include "platform/scene/toml.h"

namespace godobject {
namespace {

/// Source of the addresses, for messages.
struct Given {
  const SceneConfig& scene;
  const std::string& option;

  std::string complaint(const std::string& what) const {
    return (option.empty() ? "" : option + ": ") + what;
  }
  std::string how_to() const {
    std::string text;
    for (const BusParams& bus : scene.device->rig->buses)
      text += (option.empty() ? " " : " " + option + " ") + bus.name + "=ADDRESS";
    return text;
  }
};

/// Returns the index of the bus that `given` names; none, with the reason in errors.
std::optional<std::size_t> bus_of(const NamedAddress& given, const Given& by,
                                  std::vector<std::string>& errors) {
  const std::vector<BusParams>& buses = by.scene.device->rig->buses;
  if (given.name.empty() && buses.size() == 1) return 0;
  if (given.name.empty()) {
    if (std::string error; !parse_bus_address(given.address, error)) errors.push_back(by.complaint(error));
    errors.push_back(by.complaint("'" + given.address + "' names no bus of the scene, which has " +
                                  quoted_names(buses) + ": give" + by.how_to()));
    return std::nullopt;
  }
  const auto named = std::ranges::find(buses, given.name, &BusParams::name);
  if (named != buses.end()) return static_cast<std::size_t>(named - buses.begin());
  errors.push_back(by.complaint("scene '" + by.scene.name + "' has no bus '" + given.name +
                                "': its buses are " + quoted_names(buses)));
  return std::nullopt;
}

/// Expands `pty`, or a single log, to one NAME=ADDRESS per bus.
std::vector<std::string> with_names(std::span<const std::string> given, const std::vector<BusParams>& buses) {
  std::vector<std::string> named;
  for (const std::string& text : given) {
    std::string ignored;
    const std::optional<BusAddress> address = parse_bus_address(text, ignored);
    if (address && (address->backend->makes_terminal || (address->backend->is_file && given.size() == 1)))
      for (const BusParams& bus : buses) named.push_back(bus.name + "=" + text);
    else named.push_back(text);
  }
  return named;
}

/// Reserves a transmit slot for the SYNC and for each command, because those of the last cycle are obsolete
/// in this one.
/// Frames without a slot wait in the common queue, as do commands with extended identifiers (moteus).
void add_slots(LinuxLink& link, const RigParams& rig, Nanoseconds period) {
  for (std::size_t i = 0; i < rig.buses.size(); ++i)
    static_cast<void>(link.add_slot(i, canopen::make_sync().id, period / 2));
  for (const DriveParams& drive : rig.drives) {
    const auto command_id = bus_protocol(drive.protocol).command_id;
    if (command_id != nullptr) static_cast<void>(link.add_slot(drive.bus, command_id(drive.node_id), period));
  }
}

std::string trouble_of(LinuxLink& link, const RigAddresses& where, const RigParams& rig, std::size_t i) {
  return "bus " + rig.buses[i].name + " (" + where.texts[i] + "): " + link.bus(i).trouble();
}

/// NMT 000h and SYNC 080h.
constexpr CanFilter network{.id = 0x000, .mask = 0x77F};

void add(const std::vector<CanFilter>& more, std::vector<CanFilter>& filters) {
  filters.insert(filters.end(), more.begin(), more.end());
}

constexpr std::chrono::milliseconds stop_poll{20}, commissioning_poll{1};

/// Waits until the other end of each pseudo-terminal is open, because the bus is down until then. Returns
/// false at `stop`.
bool wait_for_other_ends(const RigOnBuses& real, const std::atomic<bool>& stop) {
  for (std::size_t i = 0; i < real.link.num_buses(); ++i)
    if (real.has_other_end(i))
      std::fprintf(stderr, "bus %s: waiting for the other end of %s\n", real.rig.buses[i].name.c_str(),
                   real.link.bus(i).name().c_str());
  const auto one_waits = [&] {
    drain(real.link);
    for (std::size_t i = 0; i < real.link.num_buses(); ++i)
      if (real.has_other_end(i) && is_cut_off(real.link.bus(i).state())) return true;
    return false;
  };
  while (one_waits())
    if (!pause(0, stop)) return false;
  return true;
}

}  // namespace

// ---- buses ----------------------------------------------------------------------------------------

RigAddresses rig_addresses(std::span<const std::string> given, const SceneConfig& scene,
                           const std::string& option, std::vector<std::string>& errors) {
  const Given by{scene, option};
  RigAddresses where;
  const std::vector<BusParams>& buses = scene.device->rig->buses;
  std::vector<std::optional<BusAddress>> addresses(buses.size());
  where.texts.resize(buses.size());
  for (const std::string& text : with_names(given, buses)) {
    const NamedAddress bus = split_name(text, ':');
    const std::optional<std::size_t> index = bus_of(bus, by, errors);
    if (!index) continue;
    if (!where.texts[*index].empty())
      errors.push_back(by.complaint("bus '" + buses[*index].name + "' is given twice: remove one"));
    std::string error;
    addresses[*index] = parse_bus_address(bus.address, error);
    if (!addresses[*index]) errors.push_back(by.complaint(error));
    where.texts[*index] = bus.address;
  }
  for (std::size_t i = 0; i < addresses.size(); ++i) {
    if (addresses[i]) where.addresses.push_back(*addresses[i]);
    if (where.texts[i].empty() && errors.empty())
      errors.push_back(
          by.complaint("bus '" + buses[i].name + "' of the scene has no address: give" + by.how_to()));
  }
  if (errors.empty() && !where.are_logs() &&
      std::ranges::any_of(where.addresses, [](const BusAddress& bus) { return bus.backend->is_file; }))
    errors.push_back(
        by.complaint("a log and a bus with a clock of its own do not go together: give replay:FILE for "
                     "every bus, or for none"));
  return where;
}

std::unique_ptr<LinuxLink> make_link(const RigAddresses& where, const RigParams& rig, double step,
                                     bool everything) {
  const std::vector<std::vector<CanFilter>> filters = rig_filters(rig);
  std::vector<std::unique_ptr<LinuxBus>> buses;
  for (std::size_t i = 0; i < where.addresses.size(); ++i) {
    BusSettings settings{
        .bit_rate = rig.buses[i].bit_rate, .data_bit_rate = rig.buses[i].data_bit_rate, .filters = {}};
    if (!everything) settings.filters = filters[i];
    buses.push_back(make_bus(where.addresses[i], settings));
  }
  const Nanoseconds period = to_ns(step);
  auto link = std::make_unique<LinuxLink>(std::move(buses), period);
  add_slots(*link, rig, period);
  return link;
}

std::vector<std::string> open_buses(LinuxLink& link, const RigAddresses& where, const RigParams& rig) {
  std::vector<std::string> errors;
  for (std::size_t i = 0; i < link.num_buses(); ++i)
    if (link.bus(i).state() == BusState::closed && !link.bus(i).open())
      errors.push_back(trouble_of(link, where, rig, i));
  return errors;
}

std::vector<std::string> bus_troubles(LinuxLink& link, const RigAddresses& where, const RigParams& rig) {
  std::vector<std::string> troubles;
  for (std::size_t i = 0; i < link.num_buses(); ++i)
    if (!link.bus(i).trouble().empty()) troubles.push_back(trouble_of(link, where, rig, i));
  return troubles;
}

std::vector<std::vector<CanFilter>> rig_filters(const RigParams& rig) {
  std::vector<std::vector<CanFilter>> filters(rig.buses.size());
  for (std::vector<CanFilter>& of_bus : filters) {
    of_bus.push_back(network);
    of_bus.push_back({.id = canopen::heartbeat_cob_id(rig.host_node_id), .mask = 0x7FF});
  }
  for (const EncoderParams& encoder : rig.encoders)
    add(canopen::filters(encoder.node_id), filters[encoder.bus]);
  for (const DriveParams& drive : rig.drives)
    add(bus_protocol(drive.protocol).filters(drive.node_id), filters[drive.bus]);
  for (const ButtonParams& button : rig.buttons) add(canopen::filters(button.node_id), filters[button.bus]);
  return filters;
}

std::string load_advice(const BusLoad& load) {
  const char* verdict = nullptr;
  if (is_overloaded(load)) {
    verdict = "error: the bus cannot carry its messages; raise bit_rate, raise step, or use more buses";
  } else if (load.worst_percent > planned_load_percent) {
    verdict = "warning: above 70 %, messages of low priority may come a period late; use more buses";
  } else if (load.worst_percent > advised_load_percent) {
    verdict = "warning: above 50 %, little is left for repeated and sporadic messages";
  }
  if (!verdict) return "";
  std::array<char, 32> percent{};
  std::snprintf(percent.data(), percent.size(), "%.1f", load.worst_percent);
  return "bus " + load.bus + ": worst-case load " + percent.data() + " %: " + verdict;
}

// ---- preparation ----------------------------------------------------------------------------------

RigProfiles checked_profiles(SceneConfig& scene, const std::string& scene_file,
                             std::vector<std::string>& errors) {
  RigParams& rig = *scene.device->rig;
  RigProfilesResult loaded =
      load_profiles(rig, scene.step, std::filesystem::path(scene_file).parent_path().string(), scene_file);
  errors.insert(errors.end(), loaded.errors.begin(), loaded.errors.end());
  if (loaded.errors.empty() && shows_force(scene.device->kind))
    for (const std::string& line : missing_watchdogs(rig, scene.step, loaded.profiles))
      errors.push_back(scene_file + ": " + line);
  apply_profiles(loaded.profiles, rig);
  return std::move(loaded.profiles);
}

void drain(LinuxLink& link) {
  ReceivedFrame ignored;
  for (CanBus* bus : link.buses()) {
    int left = Rig::max_frames_per_receive;
    while (left > 0 && bus->try_receive(ignored)) --left;
  }
}

bool pause(double s, const std::atomic<bool>& stop) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(s);
  do {
    std::this_thread::sleep_for(stop_poll);
  } while (!stop && std::chrono::steady_clock::now() < end);
  return !stop;
}

std::vector<std::string> commission(const RigOnBuses& real, const std::atomic<bool>& stop) {
  Commissioning nodes(real.rig, real.cycle_s, real.profiles, real.link.buses());
  const MonotonicClock clock;
  while (!nodes.done() && !stop) {
    nodes.poll(clock.now());
    std::this_thread::sleep_for(commissioning_poll);
  }
  return nodes.failed() ? nodes.errors() : std::vector<std::string>{};
}

std::vector<std::string> bring_up(const RigOnBuses& real, const std::atomic<bool>& stop) {
  if (!wait_for_other_ends(real, stop)) return {};
  return commission(real, stop);
}

std::vector<LastWords> last_words(const RigParams& params, double cycle_s, LinuxLink& link) {
  std::vector<FrameNotebook> notes(link.num_buses());
  std::vector<CanBus*> buses;
  for (FrameNotebook& note : notes) buses.push_back(&note);
  Rig rig(params, cycle_s, buses);
  rig.start(0);
  rig.stop();
  std::vector<LastWords> words;
  for (std::size_t i = 0; i < notes.size(); ++i) {
    words.push_back({.descriptor = link.bus(i).descriptor(), .writes = {}, .rest = link.bus(i).line_rest()});
    for (const CanFrame& frame : notes[i].frames())
      words.back().writes.push_back(link.bus(i).as_written(frame));
  }
  return words;
}

}  // namespace godobject
