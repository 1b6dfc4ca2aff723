// Every fault of the core, of a rig and of a run: name, meaning, remedy. What `godobject faults` prints, what
// reports and traces call them by; docs/faults.md has the same names (tested).
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "core/fault.h"
#include "hal/rig/fault.h"

namespace godobject {

struct FaultText {
  std::string_view name, meaning, remedy;
};

struct CoreFaultText {
  Fault fault;
  FaultText text;
};

inline constexpr std::array<CoreFaultText, 6> core_fault_texts{{
    {Fault::input_not_finite,
     {"input_not_finite", "an input was not a finite number; those steps were not taken",
      "find the source of the sample: encoders and trackers mark bad samples invalid, which is no fault"}},
    {Fault::input_not_unit,
     {"input_not_unit",
      "a target's quaternion was not of unit length, or an increment more than half a turn; those steps were "
      "not taken",
      "normalise where the sample is made"}},
    {Fault::state_not_finite,
     {"state_not_finite", "a step's result was not finite and was not taken",
      "lower the stiffness or the step"}},
    {Fault::contacts_full,
     {"contacts_full", "more contacts at a time than the scene has room for; the deepest were kept",
      "fewer spheres, or a composition with room for more: godobject check prints what the scene has"}},
    {Fault::blocks_full,
     {"blocks_full",
      "contacts couple more pairs of bodies than the solver has blocks for; those steps were iterated, to "
      "the residual "
      "of the contact report",
      "fewer bodies in one heap, or a composition with room for more"}},
    {Fault::energy_gained,
     {"energy_gained",
      "total energy rose by more than 1 % within 1 s without external work; the simulation is not valid from "
      "then on. A single step that would have held 100 times the energy was not taken",
      "a shorter step; softer couplings, contacts or stops; less contrast of masses in an articulated tool"}},
}};

enum class RunFault : std::size_t {
  not_ready,
  not_set_up,
  tracker_not_ready,
  recovered,
  unreachable,
  file_incomplete,
  records_lost,
  deadlines_missed,
  force_oscillates,
  held,
};

/// In the order of RunFault.
inline constexpr std::array<FaultText, 10> run_fault_texts{{
    {"not_ready", "the device did not come up in time, and no single node is to blame; no cycle was run",
     "check power, cables and bit rates; see boot_timeout"},
    {"not_set_up", "a node could not be commissioned; no cycle was run",
     "the line says device, object, what happened and the line of its profile"},
    {"tracker_not_ready", "a tracker did not get to tracking within its boot_timeout; no cycle was run",
     "the line says which, on which port, and what it waits for; see docs/trackers.md"},
    {"recovered", "with --rearm auto: the device was lost and armed again",
     "see the faults that are named with it"},
    {"unreachable", "the motion left the workspace of the device, or met a singular configuration",
     "move the device's base, or scale the motion"},
    {"file_incomplete", "a trace, record or report could not be written in full", "is the disk full?"},
    {"records_lost", "a real-time run made trace rows or frames faster than the disk took them",
     "a faster disk, a memory file system, or no --record; the run itself was not disturbed"},
    {"deadlines_missed", "without a rig: 20 deadlines in a row were missed; from there on nothing was shown",
     "look at what else runs on this machine and at the real-time set-up"},
    {"force_oscillates",
     "of a scene without a rig: the force shown to the hand swung between its bounds for 0.5 s",
     "lower the feedback's damping and stiffness, or raise the limit that it meets"},
    {"held",
     "on a device: deadlines were missed, so the pose was held and the force faded for more than 5 % of the "
     "run",
     "end what else runs on this machine, and look at the real-time set-up; see docs/running.md"},
}};

constexpr const FaultText& text_of(RunFault fault) noexcept {
  return run_fault_texts[static_cast<std::size_t>(fault)];
}

}  // namespace godobject
