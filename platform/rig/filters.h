// CAN filters of a rig: the kernel or an adapter may drop all other frames before they wake the loop.
#pragma once

#include <vector>

#include "hal/can/filter.h"
#include "hal/rig/params.h"

namespace godobject {

/// Returns the filters of each bus of the rig. They pass all frames of the rig's own nodes and of the host.
/// Frames of nodes: the predefined connection set (CiA 301 7.3.3: PDO, EMCY, SDO, heartbeat), and those of
/// drives with other protocols.
/// Frames of the host: NMT and SYNC among them, because a bus confirms a transmission by returning the frame.
std::vector<std::vector<CanFilter>> rig_filters(const RigParams& rig);

}  // namespace godobject
