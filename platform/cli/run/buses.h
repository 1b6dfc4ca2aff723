// --bus: which buses a run has, and the real ones among them.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "platform/rig/buses.h"
#include "platform/session/session.h"

namespace godobject {

struct BusPlan {
  BusChoice choice = BusChoice::sim;
  RigAddresses real;  // where that is the choice
};

/// What --bus asks for: "sim", "direct", an address where the scene has one bus, NAME=ADDRESS for each where it
/// has several. None given: sim where the scene describes buses or trackers, which `notes` says where it does not.
BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes);

}  // namespace godobject
