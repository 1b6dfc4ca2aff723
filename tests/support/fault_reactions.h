// Every fault verb, and what the rig does about it as docs/faults.md has it: for test::FaultyRig.
#pragma once

#include <array>
#include <ostream>

#include "hal/rig_fault.h"

namespace godobject::test {

/// From the fault of a drive that hears nothing any more to its own watchdog, with a cycle on either side.
inline constexpr int cycles_of_watchdog = 22;
/// What is seen at the third cycle.
inline constexpr int cycles_of_silence = 5;
/// lost_after is 100 cycles.
inline constexpr int cycles_of_loss = 105;

struct FaultReaction {
  const char* words;
  RigFault expected;  // one of its bits at least; none: no fault may come up
  int within = 0;     // cycles
};

inline std::ostream& operator<<(std::ostream& out, const FaultReaction& reaction) {
  return out << reaction.words;
}

inline constexpr std::array fault_reactions{
    FaultReaction{"drop bus=can0 node=1 duration=0.09", RigFault::none},
    FaultReaction{"drop bus=can1 duration=0.015", RigFault::none},
    FaultReaction{"delay bus=can0 value=0.05 duration=0.05", RigFault::none},
    FaultReaction{"drop bus=can0 node=1 value=0.005", RigFault::none},
    FaultReaction{"drop bus=can0 node=1", RigFault::sample_stale, cycles_of_loss},
    FaultReaction{"drop bus=can1 node=1", RigFault::drive_silent, cycles_of_loss},
    FaultReaction{"drop", RigFault::sample_stale | RigFault::drive_silent, cycles_of_loss},
    FaultReaction{"duplicate", RigFault::none},
    FaultReaction{"delay bus=can0 value=3e-4", RigFault::none},
    FaultReaction{"delay bus=can0 value=0.01", RigFault::sample_stale, cycles_of_loss},
    FaultReaction{"corrupt value=0.05", RigFault::none},
    FaultReaction{"corrupt bus=can0 node=1 value=1", RigFault::sample_stale, cycles_of_loss},
    FaultReaction{"stuck bus=can0 node=1", RigFault::none},
    FaultReaction{"spike bus=can0 node=1", RigFault::none},
    FaultReaction{"spike bus=can0 node=1 duration=1", RigFault::sample_implausible, cycles_of_silence},
    FaultReaction{"wrap bus=can0 node=1", RigFault::sample_implausible, cycles_of_silence},
    FaultReaction{"nan bus=can0 node=1", RigFault::sample_implausible, cycles_of_silence},
    FaultReaction{"reboot-node bus=can0 node=1", RigFault::node_restarted, cycles_of_silence},
    FaultReaction{"reboot-node bus=can1 node=1 duration=0.1",
                  RigFault::drive_silent | RigFault::node_restarted, cycles_of_loss},
    FaultReaction{"emcy bus=can0 node=1 value=20480", RigFault::emergency, 2},
    FaultReaction{"emcy bus=can1 node=1", RigFault::emergency | RigFault::drive_not_enabled, 2},
    FaultReaction{"bus-off bus=can0", RigFault::bus_down, 2},
    FaultReaction{"bus-off bus=can1 node=1", RigFault::drive_silent, cycles_of_loss},
    FaultReaction{"restart", RigFault::none},
    FaultReaction{"unplug bus=can0 node=1", RigFault::sample_stale, cycles_of_loss},
    FaultReaction{"unplug", RigFault::sample_stale | RigFault::drive_silent | RigFault::send_refused,
                  cycles_of_loss},
    FaultReaction{"id-collision bus=can0 node=1", RigFault::node_restarted | RigFault::sample_stale,
                  cycles_of_loss},
    FaultReaction{"id-collision bus=can1 node=1", RigFault::node_restarted | RigFault::drive_silent,
                  cycles_of_loss},
    FaultReaction{"clock-drift bus=can0 node=1", RigFault::none},
    FaultReaction{"clock-drift bus=can1 node=1 value=-9e5", RigFault::heartbeat_lost, 1200}};

}  // namespace godobject::test
