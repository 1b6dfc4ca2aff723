// A fault that has found what it acts on.
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
  std::size_t first_bus = 0, end_bus = 0;  // the buses it acts on; with a node just that node's
  std::uint8_t node_id = 0;                // 0: the host's end of the buses
  double at = 0;                           // s of the motion
  std::optional<Nanoseconds> duration_ns;  // of bus time
  double value = 0;                        // in effect: the verb's default in place of 0
};

struct FaultResult {
  std::optional<SimFault> fault;  // none: see error
  std::string error;              // completes "fault ...: "
};

/// Finds verb, bus and node of `config`, which names no tracker, on a rig.
FaultResult resolve(const FaultConfig& config, const RigParams& rig);

/// A fault of a tracker.
struct SimTrackerFault {
  FaultVerb verb = FaultVerb::missing;
  std::size_t tracker = 0;
  std::size_t tool = 0;                    // of its tools, where the verb is of one
  double at = 0;                           // s of the motion
  std::optional<Nanoseconds> duration_ns;  // without: to the end
  double value = 0;                        // in effect: the verb's default in place of 0
};

struct TrackerFaultResult {
  std::optional<SimTrackerFault> fault;  // none: see error
  std::string error;                     // as in FaultResult
};

/// Finds verb and tracker of `config`, which names one.
TrackerFaultResult resolve(const FaultConfig& config, std::span<const TrackerParams> trackers);

/// One fault in words, as at run time: "drop bus=can0 node=4 value=0.1 duration=0.5"; also at, in s of the motion,
/// and tracker. Verb first, the rest in any order, all of it optional. What is wrong with it: in `error`.
std::optional<FaultConfig> parse_fault(std::string_view words, std::string& error);

}  // namespace godobject
