// Whether profiles fit the rig they are for, before any bus is touched.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

/// Where profiles and rig contradict each other: heartbeats, the period, maps that the rig would misread. One
/// line each with its place in the profile; empty: nowhere.
std::vector<std::string> validate(const RigParams& rig, const RigProfiles& profiles);

/// Gives the rig's drives that have a profile what it says of their mode and the bits of their statusword.
void apply_profiles(const RigProfiles& profiles, RigParams& rig) noexcept;

}  // namespace godobject
