// --bus: which buses a run has, and the real ones among them.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "platform/linux/link.h"
#include "platform/session/session.h"

namespace godobject {

struct BusPlan {
  BusChoice choice = BusChoice::sim;
  std::vector<BusAddress> addresses;  // real: one per bus of the scene, in its order
  std::vector<std::string> texts;     // the same as given
};

/// What --bus asks for: "sim", "direct", an address where the scene has one bus, NAME=ADDRESS for each where it
/// has several. None given: sim where the scene describes buses or trackers, which `notes` says where it does not.
BusPlan plan_buses(std::span<const std::string> given, const SceneConfig& scene,
                   std::vector<std::string>& errors, std::vector<std::string>& notes);

/// The buses of the plan, closed. step: s. everything: also the frames that the rig does not listen to.
std::unique_ptr<LinuxLink> make_link(const BusPlan& plan, const RigParams& rig, double step, bool everything);

/// Opens all that are closed. One line for each that does not open: bus, address, why, what to do.
std::vector<std::string> open_buses(LinuxLink& link, const BusPlan& plan, const RigParams& rig);

/// One line for each bus with something to say about it, as open_buses.
std::vector<std::string> bus_troubles(LinuxLink& link, const BusPlan& plan, const RigParams& rig);

}  // namespace godobject
