// Checks a rig's parameters before construction.
#pragma once

#include <string>
#include <vector>

#include "hal/rig/params.h"

namespace godobject {

inline constexpr std::size_t max_buses = 4;

/// Returns one sentence per violated rule: joint, device or scene-file key, value, admissible range. Empty if
/// a Rig can be constructed. cycle_s: SYNC period, s. Set-up only: allocates.
std::vector<std::string> validate(const RigParams& rig, double cycle_s);

/// Returns the rules of validate() on incremental sensors and the button that confirms their home pose.
std::vector<std::string> homing_errors(const RigParams& rig);

}  // namespace godobject
