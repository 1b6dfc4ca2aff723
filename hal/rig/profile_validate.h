// Checks profiles against their rig, before any bus is opened.
#pragma once

#include <string>
#include <vector>

#include "hal/canopen/node_profile.h"
#include "hal/rig/params.h"

namespace godobject {

/// Returns contradictions between profiles and rig: heartbeats, period, maps that the rig would misread. One
/// line each, with its place in the profile; empty if none. cycle_s: SYNC period, s.
std::vector<std::string> validate(const RigParams& rig, double cycle_s, const RigProfiles& profiles);

/// Copies mode and statusword bits from the profiles to the rig's drives.
void apply_profiles(const RigProfiles& profiles, RigParams& rig) noexcept;

}  // namespace godobject
