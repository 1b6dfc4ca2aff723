// Faults that a simulated rig can inject: one table of names, values and effects.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace godobject {

enum class FaultVerb : std::uint8_t {
  drop,
  duplicate,
  delay,
  corrupt,
  stuck,
  spike,
  wrap,
  nan,
  reboot_node,
  emcy,
  bus_off,
  restart,
  unplug,
  id_collision,
  clock_drift,
  swap_ids,
  second_host,
  flood,
  press,
  missing,
  disabled,
};
inline constexpr std::size_t num_fault_verbs = 21;

/// Target of a verb. A bus means the host's port on it.
enum class FaultPlace : std::uint8_t {
  node,         // one node
  bus,          // a bus
  bus_or_node,  // without a node: the host's port of the bus, which affects all its nodes
  anywhere,     // node, bus or tracker
  tracker,      // a tracker
};

constexpr bool acts_on_trackers(FaultPlace place) noexcept { return place >= FaultPlace::anywhere; }

struct FaultVerbText {
  FaultVerb verb;
  std::string_view name;
  FaultPlace place;
  std::string_view meaning;
  std::string_view value;    // meaning and unit of FaultConfig::value; empty: unused
  double default_value = 0;  // replaces a value of 0
  double min = 0, max = 0;   // range of the value
  bool is_event = false;     // without a duration: happens once; other verbs last until the end
  std::string_view remark;   // reaction of the rig: sim/fault/promise.h
};

/// Returns the texts in the order of FaultVerb.
std::span<const FaultVerbText, num_fault_verbs> fault_verb_texts() noexcept;
const FaultVerbText& text_of(FaultVerb verb) noexcept;
std::optional<FaultVerb> fault_verb_named(std::string_view name) noexcept;

/// Returns the list of docs/faults.md in Markdown.
std::string fault_reference_markdown();

}  // namespace godobject
