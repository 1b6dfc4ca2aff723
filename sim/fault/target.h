// A fault with resolved target.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "hal/can/frame.h"
#include "hal/rig/params.h"
#include "hal/rig/simulation.h"
#include "hal/tracker/params.h"
#include "sim/fault/verb.h"

namespace godobject {

struct SimFault {
  FaultVerb verb = FaultVerb::drop;
  std::size_t first_bus = 0, end_bus = 0;  // affected buses; with a node, only that of the node
  std::uint8_t node_id = 0;                // 0: the host's port of the buses
  double at = 0;                           // time of the motion, s
  std::optional<Nanoseconds> duration_ns;  // bus time
  double value = 0;                        // effective value: the verb's default instead of 0
};

/// True if the verb `press` with this value acts on the button of its node.
constexpr bool presses(double value, const ButtonParams& button) noexcept { return value == button.bit + 1; }

struct FaultResult {
  std::optional<SimFault> fault;  // none: see error
  std::string error;              // completes "fault ...: "
};

/// Resolves verb, bus and node of `config`, which names no tracker, on a rig.
FaultResult resolve(const FaultConfig& config, const RigParams& rig);

/// A fault of a tracker.
struct SimTrackerFault {
  FaultVerb verb = FaultVerb::missing;
  std::size_t tracker = 0;
  std::size_t tool = 0;                    // index of its tool, if the verb applies to one
  double at = 0;                           // time of the motion, s
  std::optional<Nanoseconds> duration_ns;  // none: until the end
  double value = 0;                        // effective value: the verb's default instead of 0
};

struct TrackerFaultResult {
  std::optional<SimTrackerFault> fault;  // none: see error
  std::string error;                     // as in FaultResult
};

/// Resolves verb and tracker of `config`, which names a tracker.
TrackerFaultResult resolve(const FaultConfig& config, std::span<const TrackerParams> trackers);

/// Parses one fault in the words of run time: "drop bus=can0 node=4 value=0.1 duration=0.5"; also `at`, s of
/// the motion, and `tracker`. Verb first, the other words in any order, all optional. error: the error in the
/// words.
std::optional<FaultConfig> parse_fault(std::string_view words, std::string& error);

}  // namespace godobject
