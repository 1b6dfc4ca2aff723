// Required reaction of a rig to each fault: its fault bits, their delay, and the state of the motors.
// docs/faults.md prints this list and the tests inject it.
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "hal/rig/fault.h"
#include "hal/rig/params.h"
#include "sim/fault/verb.h"

namespace godobject {

/// Delay from the beginning of the injected fault to the fault bit.
enum class FaultDelay : std::uint8_t {
  at_once,         // with the frame that contains it
  votes,           // three samples of five
  lost,            // stale_after and then lost_after without a good sample
  heartbeat,       // heartbeat_timeout without a heartbeat
  late_heartbeat,  // heartbeat_timeout after a heartbeat that was late
  duration,        // at the end of the injected fault
  travel,          // after the joint has moved by max_slip
};

struct PromisedFault {
  RigFault fault = RigFault::none;  // none: end of the list
  FaultDelay within = FaultDelay::at_once;
  bool always = true;  // false if the fault bit is optional, depending on timing
};

enum class MotorsEnd : std::uint8_t {
  keep,      // torque continues as commanded
  run_down,  // every drive still receives commands; the rig ramps the torque down
  watchdog,  // a drive receives nothing and stops by itself
  cut,       // each drive removes its torque by its own fastest means
};

struct FaultPromise {
  /// Words of the control command. ENCODER, DRIVE, STOP stand for bus and node of one device, OTHER for the
  /// node id of another encoder on its bus. N*stale_after and N*lost_after stand for that time, s.
  std::string_view words;
  std::array<PromisedFault, 5> faults{};
  MotorsEnd motors = MotorsEnd::keep;
};

/// Returns the list: at least one entry per verb for buses and nodes.
std::span<const FaultPromise> fault_promises() noexcept;

/// Returns the bound of a delay, ns; nullopt for travel. cycle_s: period of the rig, s. duration_ns: duration
/// of the injected fault.
std::optional<Nanoseconds> bound(FaultDelay delay, const RigParams& rig, double cycle_s,
                                 Nanoseconds duration_ns) noexcept;

/// Returns the list of docs/faults.md in Markdown.
std::string fault_promises_markdown();

}  // namespace godobject
