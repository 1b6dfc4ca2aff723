// The last frames of a rig, ready for when the program dies.
#pragma once

#include "hal/rig_params.h"
#include "platform/last_resort.h"
#include "platform/linux_link.h"

namespace godobject {

/// What Rig::stop() would send on each bus, as bytes: drives off, nodes pre-operational. Good until a bus is closed.
std::vector<LastWords> last_words(const RigParams& rig, LinuxLink& link);

}  // namespace godobject
