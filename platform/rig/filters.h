// Which frames a rig listens to: what the kernel or an adapter may leave out before it wakes the loop.
#pragma once

#include <vector>

#include "hal/can/filter.h"
#include "hal/rig/params.h"

namespace godobject {

/// Per bus of the rig. They pass everything of the rig's own nodes (CiA 301 7.3.3, the predefined connection
/// set: PDO, EMCY, SDO, heartbeat; the frames of drives with a protocol of their own) and the host's own
/// frames, NMT and SYNC among them, whose sending a bus confirms by giving them back.
std::vector<std::vector<CanFilter>> rig_filters(const RigParams& rig);

}  // namespace godobject
