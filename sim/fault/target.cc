#include "sim/fault/target.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include "hal/base/format.h"
#include "hal/canopen/canopen.h"

namespace godobject {
namespace {

bool has_node(const RigParams& rig, std::size_t bus, std::uint8_t id) {
  const auto is_it = [&](const auto& device) { return device.bus == bus && device.node_id == id; };
  return std::ranges::any_of(rig.encoders, is_it) || std::ranges::any_of(rig.drives, is_it) ||
         std::ranges::any_of(rig.buttons, is_it);
}

bool has_encoder(const RigParams& rig, std::size_t bus, double id) {
  return std::ranges::any_of(rig.encoders,
                             [&](const EncoderParams& e) { return e.bus == bus && e.node_id == id; });
}

std::string in_quotes(std::string_view text) { return "'" + std::string(text) + "'"; }

std::string verb_names() {
  std::string names;
  for (const FaultVerbText& text : fault_verb_texts())
    names += (names.empty() ? "" : ", ") + std::string(text.name);
  return names;
}

std::string no_such_verb(const std::string& verb) {
  return "unknown verb " + in_quotes(verb) + "; expected one of " + verb_names();
}

/// Returns the error in the effective value; empty if valid.
std::string check_value(const FaultVerbText& text, double value) {
  if (text.value.empty() || (value >= text.min && value <= text.max)) return "";
  return "value is " + shortest(value) + ", must be from " + shortest(text.min) + " to " +
         shortest(text.max) + " (" + std::string(text.value) + ")";
}

/// Sets first_bus and end_bus. Returns the error; empty if none.
std::string find_buses(const FaultConfig& config, const RigParams& rig, SimFault& fault) {
  fault.end_bus = rig.buses.size();
  if (config.bus.empty()) return rig.buses.empty() ? "the scene has no buses" : "";
  const auto bus = std::ranges::find(rig.buses, config.bus, &BusParams::name);
  if (bus == rig.buses.end()) return "unknown bus " + in_quotes(config.bus);
  fault.first_bus = static_cast<std::size_t>(bus - rig.buses.begin());
  fault.end_bus = fault.first_bus + 1;
  return "";
}

/// Restricts the buses to that of the node. Returns the error; empty if none.
std::string find_node(const RigParams& rig, SimFault& fault) {
  const std::string name = "node " + std::to_string(fault.node_id);
  std::vector<std::size_t> buses;
  for (std::size_t bus = fault.first_bus; bus < fault.end_bus; ++bus)
    if (has_node(rig, bus, fault.node_id)) buses.push_back(bus);
  if (buses.empty()) return "no " + name + " on the buses of this rig";
  if (buses.size() > 1) return "there is a " + name + " on more than one bus: add bus=NAME";
  fault.first_bus = buses.front();
  fault.end_bus = fault.first_bus + 1;
  return "";
}

/// Checks two encoders that exchange their ids. Returns the error; empty if none.
std::string check_swap(const RigParams& rig, const SimFault& fault) {
  const bool are_two = fault.value != fault.node_id && has_encoder(rig, fault.first_bus, fault.node_id) &&
                       has_encoder(rig, fault.first_bus, fault.value);
  return are_two ? "" : "node and value must be two encoders on one bus";
}

/// Checks a node whose button is pressed. Returns the error; empty if none.
std::string check_press(const RigParams& rig, const SimFault& fault) {
  const auto is_it = [&](const ButtonParams& button) {
    return button.bus == fault.first_bus && button.node_id == fault.node_id && presses(fault.value, button);
  };
  if (std::ranges::any_of(rig.buttons, is_it)) return "";
  return "node " + std::to_string(fault.node_id) + " has no button at input " + shortest(fault.value) +
         ": give node and input (bit + 1) of a [[device.button]]";
}

bool to_number(std::string_view text, double& out) {
  const std::string copy(text);
  char* end = nullptr;
  out = std::strtod(copy.c_str(), &end);
  return !copy.empty() && *end == '\0' && std::isfinite(out);
}

/// Sets one key=value of a fault. Returns the error; empty if none.
std::string set(FaultConfig& fault, std::string_view key, std::string_view value) {
  if (key == "bus") fault.bus = value;
  else if (key == "tracker") fault.tracker = value;
  else {
    double number = 0;
    const bool is_number = to_number(value, number);
    const bool is_node =
        is_number && number >= 1 && number <= canopen::max_node_id && number == std::floor(number);
    if (!is_number) return in_quotes(key) + " must be a number, not " + in_quotes(value);
    if (key == "value") fault.value = number;
    else if (key == "at" && number >= 0) fault.at = number;
    else if (key == "duration" && number > 0) fault.duration = number;
    else if (key == "node" && is_node) fault.node_id = static_cast<std::uint8_t>(number);
    else
      return in_quotes(key) + " = " + in_quotes(value) +
             ": unknown or out of range; expected bus, node (1 to 127), "
             "tracker, value, at (>= 0), duration (> 0)";
  }
  return "";
}

}  // namespace

FaultResult resolve(const FaultConfig& config, const RigParams& rig) {
  const std::optional<FaultVerb> verb = fault_verb_named(config.verb);
  if (!verb) return {{}, no_such_verb(config.verb)};
  const FaultVerbText& text = text_of(*verb);
  if (!config.tracker.empty()) return {{}, "it names a tracker instead of a bus or node"};
  if (text.place == FaultPlace::tracker)
    return {{}, in_quotes(text.name) + " is a fault of a tracker: add tracker=NAME"};
  SimFault fault;
  fault.verb = *verb;
  fault.node_id = config.node_id.value_or(0);
  fault.at = config.at;
  fault.value = config.value == 0 ? text.default_value : config.value;
  if (config.duration) fault.duration_ns = to_ns(*config.duration);
  std::string error = check_value(text, fault.value);
  if (error.empty()) error = find_buses(config, rig, fault);
  if (error.empty() && config.node_id) error = find_node(rig, fault);
  if (error.empty() && !config.node_id && text.place == FaultPlace::node)
    error = in_quotes(text.name) + " is a fault of one node: add node=ID";
  if (error.empty() && config.node_id && text.place == FaultPlace::bus)
    error = in_quotes(text.name) + " is a fault of a bus: remove node";
  if (error.empty() && *verb == FaultVerb::swap_ids) error = check_swap(rig, fault);
  if (error.empty() && *verb == FaultVerb::press) error = check_press(rig, fault);
  if (!error.empty()) return {{}, error};
  return {fault, ""};
}

TrackerFaultResult resolve(const FaultConfig& config, std::span<const TrackerParams> trackers) {
  const std::optional<FaultVerb> verb = fault_verb_named(config.verb);
  if (!verb) return {{}, no_such_verb(config.verb)};
  const FaultVerbText& text = text_of(*verb);
  if (!acts_on_trackers(text.place)) return {{}, in_quotes(text.name) + " is no fault of a tracker"};
  if (!config.bus.empty() || config.node_id) return {{}, "a tracker is on no bus: remove bus and node"};
  const auto named = std::ranges::find(trackers, config.tracker, &TrackerParams::name);
  if (named == trackers.end()) return {{}, "unknown tracker " + in_quotes(config.tracker)};
  SimTrackerFault fault{.verb = *verb,
                        .tracker = static_cast<std::size_t>(named - trackers.begin()),
                        .tool = 0,
                        .at = config.at,
                        .duration_ns = std::nullopt,
                        .value = config.value == 0 ? text.default_value : config.value};
  if (config.duration) fault.duration_ns = to_ns(*config.duration);
  const std::string error = check_value(text, fault.value);
  if (!error.empty()) return {{}, error};
  if (text.place != FaultPlace::tracker) return {fault, ""};
  if (fault.value != std::floor(fault.value) || fault.value > static_cast<double>(named->tools.size()))
    return {
        {},
        "tracker " + in_quotes(config.tracker) + " has tools 1 to " + std::to_string(named->tools.size())};
  fault.tool = static_cast<std::size_t>(fault.value) - 1;
  return {fault, ""};
}

std::optional<FaultConfig> parse_fault(std::string_view words, std::string& error) {
  FaultConfig fault;
  for (std::size_t begin = 0; begin < words.size();) {
    const std::size_t end = std::min(words.find_first_of(" \t", begin), words.size());
    const std::string_view word = words.substr(begin, end - begin);
    begin = end + 1;
    const std::size_t equals = word.find('=');
    if (word.empty()) continue;
    if (fault.verb.empty()) {
      fault.verb = word;
    } else if (equals == std::string_view::npos) {
      error = in_quotes(word) + ": expected key=value";
    } else {
      error = set(fault, word.substr(0, equals), word.substr(equals + 1));
    }
    if (!error.empty()) return std::nullopt;
  }
  if (fault.verb.empty()) error = "expected a verb: one of " + verb_names();
  return error.empty() ? std::optional(fault) : std::nullopt;
}

}  // namespace godobject
