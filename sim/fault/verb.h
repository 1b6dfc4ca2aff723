// The faults a simulated rig can play: one table of their names, what they take and what they do.
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
  missing,
  disabled,
};
inline constexpr std::size_t num_fault_verbs = 19;

/// What a verb can act on. A bus stands for the host's end of it.
enum class FaultPlace : std::uint8_t {
  node,         // one node
  bus,          // a bus
  bus_or_node,  // without a node: the host's end of the bus, so all nodes of it at once
  anywhere,     // that, or a tracker
  tracker,      // a tracker
};

constexpr bool acts_on_trackers(FaultPlace place) noexcept { return place >= FaultPlace::anywhere; }

struct FaultVerbText {
  FaultVerb verb;
  std::string_view name;
  FaultPlace place;
  std::string_view meaning;
  std::string_view value;    // what FaultConfig::value is, with its unit; empty: not used
  double default_value = 0;  // in place of a value of 0
  double min = 0, max = 0;   // of the value
  bool is_event = false;     // without a duration it happens once; the others then last to the end
  std::string_view remark;   // what the rig does about it is in sim/fault/promise.h
};

/// In the order of FaultVerb.
std::span<const FaultVerbText, num_fault_verbs> fault_verb_texts() noexcept;
const FaultVerbText& text_of(FaultVerb verb) noexcept;
std::optional<FaultVerb> fault_verb_named(std::string_view name) noexcept;

/// The table of docs/faults.md, in Markdown.
std::string fault_reference_markdown();

}  // namespace godobject
