// Checks of a rig's parameters before anything is built from them.
#pragma once

#include <string>
#include <vector>

#include "hal/rig/params.h"

namespace godobject {

inline constexpr std::size_t max_buses = 4;

/// One sentence per broken rule, naming the joint, device or scene-file key, the value and the admissible
/// range; empty when a Rig can be built. Set-up only: allocates.
std::vector<std::string> validate(const RigParams& rig);

}  // namespace godobject
