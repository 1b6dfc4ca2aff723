// What a rig does about each fault: which of its faults come up, within which time, and what becomes of the motors.
// One list, which docs/faults.md prints and the tests play.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "hal/rig/fault.h"
#include "hal/rig/params.h"
#include "sim/fault/verb.h"

namespace godobject {

/// How long a fault takes to be seen, from the beginning of what is played.
enum class FaultDelay : std::uint8_t {
  at_once,         // with the frame that shows it
  votes,           // three samples of five
  lost,            // no good sample for stale_after, and then for lost_after
  heartbeat,       // no heartbeat for heartbeat_timeout
  late_heartbeat,  // the same after one that came late
  duration,        // when what is played has ended
  travel,          // when the joint has moved by max_slip
};

struct PromisedFault {
  RigFault fault = RigFault::none;  // none: the end of the list
  FaultDelay within = FaultDelay::at_once;
  bool always = true;  // else it may come up as well, by chance of the moment
};

enum class MotorsEnd : std::uint8_t {
  keep,      // torque goes on as commanded
  run_down,  // every drive still hears the rig, which takes its torque down
  watchdog,  // a drive hears nothing any more, and stops by itself
};

struct FaultPromise {
  /// As the control command has them; ENCODER, DRIVE stand for bus and node of one, OTHER for the node id of another
  /// encoder on its bus, N*stale_after and N*lost_after for that time in s.
  std::string_view words;
  std::array<PromisedFault, 5> faults{};
  MotorsEnd motors = MotorsEnd::keep;
};

/// At least one of each verb that acts on buses and nodes.
std::span<const FaultPromise> fault_promises() noexcept;

/// In ns; duration_ns: of what is played. None of travel.
std::optional<Nanoseconds> bound(FaultDelay delay, const RigParams& rig, Nanoseconds duration_ns) noexcept;

/// The table of docs/faults.md, in Markdown.
std::string fault_promises_markdown();

}  // namespace godobject
