// Name, meaning and remedy of every fault of the core, of a rig and of a run. `godobject faults` prints them;
// reports and traces use the names. docs/faults.md has the same names (tested).
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
     {"input_not_finite", "an input was NaN or infinite; those steps were not taken",
      "find the source of the sample: encoders and trackers mark bad samples invalid, which is no fault"}},
    {Fault::input_not_unit,
     {"input_not_unit",
      "a target's quaternion was not of unit length, or an increment exceeded half a turn; those steps were "
      "not taken",
      "normalise the quaternion where the sample is made"}},
    {Fault::state_not_finite,
     {"state_not_finite",
      "a step's result was NaN or infinite; the step was not taken and the old state was kept",
      "lower the stiffness or the step"}},
    {Fault::contacts_full,
     {"contacts_full", "more contacts at once than the composition has room for; only the deepest were kept",
      "use fewer spheres, or a composition with a larger capacity: godobject check prints the capacity of "
      "the scene's"}},
    {Fault::blocks_full,
     {"blocks_full",
      "contacts coupled more pairs of bodies than the solver has blocks for; those steps were solved by "
      "iteration, with the residual of the contact report",
      "use fewer bodies in one heap, or a composition with a larger capacity"}},
    {Fault::energy_gained,
     {"energy_gained",
      "total energy rose by more than 1 % within 1 s without external work; the simulation is not valid from "
      "then on. A single step beyond 10 times the energy was not taken",
      "shorten the step; soften couplings, contacts or stops; lower the ratio of masses in an articulated "
      "tool"}},
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
  seal_broken,
};

/// Texts in the order of RunFault.
inline constexpr std::array<FaultText, 11> run_fault_texts{{
    {"not_ready", "the device did not come up in time, and no single node is to blame; no cycle was run",
     "check power, cables and bit rates; see boot_timeout"},
    {"not_set_up", "a node could not be commissioned; no cycle was run",
     "read the line of the fault: it names device, object, cause and the line of the profile"},
    {"tracker_not_ready", "a tracker did not start to track within its boot_timeout; no cycle was run",
     "read the line of the fault: it names the tracker, its port and the awaited answer; see "
     "docs/trackers.md"},
    {"recovered", "with --rearm auto: the device was lost and armed again",
     "read the remedies of the faults named with it"},
    {"unreachable", "the motion left the workspace of the device, or met a singular configuration",
     "move the device's base, or scale the motion"},
    {"file_incomplete", "a trace, record or report could not be written in full",
     "free space on the disk; keep the reader of a FIFO running"},
    {"records_lost",
     "a real-time run produced trace rows or frames faster than the disk took them; the run itself was not "
     "disturbed",
     "use a faster disk or a memory file system, or omit --record"},
    {"deadlines_missed",
     "without a rig: 20 deadlines in a row were missed, or so many for 2 s that the pose was held; from then "
     "on no force was displayed",
     "end other programs on this machine, and check the real-time set-up; see docs/running.md"},
    {"force_oscillates", "without a rig: the displayed force swung between its bounds for 0.5 s",
     "lower the feedback's damping and stiffness, or raise the limit that it reaches"},
    {"held",
     "on a device: deadlines were missed, or samples of the rig; the pose was held and the force faded for "
     "more than 5 % of the run",
     "after missed deadlines: end other programs on this machine, and check the real-time set-up, see "
     "docs/running.md; for want of samples: check bus load and cables"},
    {"seal_broken", "with --seal: the loop made a system call that it must not make; the torque was cut",
     "report the call that is named; without --seal it is made"},
}};

constexpr const FaultText& text_of(RunFault fault) noexcept {
  return run_fault_texts[static_cast<std::size_t>(fault)];
}

}  // namespace godobject
