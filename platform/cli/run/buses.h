// --bus: selects the buses of a run.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "platform/rig/buses.h"
#include "platform/session/session.h"

namespace godobject {

struct BusPlan {
  BusChoice choice = BusChoice::sim;
  RigAddresses real;  // addresses, for BusChoice::real
};

/// Plans the buses from the values of --bus: "sim", "direct", an address for a scene with one bus, or
/// NAME=ADDRESS for each bus. Default: sim for a scene with buses or trackers; otherwise direct, with a note.
BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes);

}  // namespace godobject
